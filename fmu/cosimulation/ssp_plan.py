"""What an SSP's routes and parameter sets come to, once its FMUs have told variables and units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..importing.description import FmuDescription, FmuError, FmuUnit, candidates
from .conversion import conversion, unit_of
from .over_time import Source
from .participants import units_of
from .ssp_structure import End, Hop, Route, SystemStructure

_NO_UNIT = FmuUnit("")
_SAME = (1.0, 0.0)


@dataclass(frozen=True)
class SspPlan:
    """A system with the description of each of its FMUs, by name of the component.

    `sha256` is that of the whole file.
    """

    structure: SystemStructure
    descriptions: Mapping[str, FmuDescription]
    sha256: str

    @cached_property
    def _units(self) -> dict[str, dict[str, FmuUnit]]:
        found = {}
        for component in self.structure.components:
            own = units_of(self.descriptions[component.name])
            said = {n: unit_of(u, self.structure.units) for n, u in component.units.items()}
            for name, unit in said.items():
                if conversion(unit, own.get(name, _NO_UNIT)) != _SAME:
                    raise FmuError(
                        f"'{component.name}.{name}' is in {unit.name} in the SSP, in "
                        f"{own[name].name} in its FMU; make them one"
                    )
            found[component.name] = {**said, **own}
        return found

    def settings(
        self, parameters: Mapping[str, Any]
    ) -> tuple[dict[str, dict[str, Any]], tuple[str, ...]]:
        """Return what to set in each component, and notes on values that nothing takes."""
        found: dict[str, dict[str, Any]] = {name: {} for name in self.descriptions}
        notes = list(self.structure.notes)
        for value in self.structure.values:
            block, name = value.target
            if not _has(self.descriptions[block], name):
                notes.append(f"{value.said_by}: {block} has no {name!r}; its value is not used")
                continue
            place = f"{value.said_by} for '{block}.{name}'"
            kind = self.descriptions[block].variable(name).type
            if isinstance(value.value, bytes) and kind != "Binary":
                raise FmuError(
                    f"{place} is of type Binary, the variable of {kind}; correct the SSP"
                )
            by = self._along(value.unit, value.hops, value.target, place)
            found[block][name] = _scaled(value.value, by, place)
        for name, given in parameters.items():
            for (block, own), by in self._targets(name):
                found[block][own] = _scaled(given, by, f"parameter {name!r}")
        return found, tuple(notes)

    @property
    def of_system(self) -> tuple[str, ...]:
        """Inputs and parameters of the system as a whole."""
        return (*self.structure.inputs, *self.structure.parameters)

    def _targets(self, name: str) -> list[tuple[End, tuple[float, float]]]:
        """Return the variables that the name of a parameter stands for, each with its gain."""
        if name in self.of_system:
            return [(r.target, self._by(r)) for r in self._routes(name) if r.target[0]]
        block, _, own = name.partition(".")
        if block not in self.descriptions or not own:
            known = [*self.of_system, *(f"{each}.…" for each in self.descriptions)]
            raise FmuError(f"parameter {name!r}{candidates(name, known)}")
        return [((block, own), _SAME)]

    def connections(self) -> tuple[tuple[Source, str], ...]:
        """Return the connections between components, as `cosimulate` takes them."""
        found: list[tuple[Source, str]] = []
        for route in self.structure.routes:
            if route.source[0] and route.target[0]:
                gain, offset = self._by(route)
                source, target = ".".join(route.source), ".".join(route.target)
                # a plain one is converted there, and told
                ends = (self._unit(end, by_fmu=True) for end in (route.source, route.target))
                plain = conversion(*ends) == (gain, offset)
                found.append((source if plain else f"{gain!r}*{source}", target))
                if offset and not plain:
                    found.append((offset, target))
        return tuple(found)

    def links(self) -> list[tuple[str, str, float, float]]:
        """Return source, target, gain and offset of all connections, those of the system last."""
        found = [
            (".".join(r.source), ".".join(r.target), *self._by(r))
            for r in self.structure.routes
            if r.source[0] and r.target[0]
        ]
        found += [(name, *end) for name, ends in self.inputs().items() for end in ends]
        outputs = self.outputs().items()
        return found + [(source, name, gain, by) for name, (source, gain, by) in outputs]

    def inputs(self) -> dict[str, tuple[tuple[str, float, float], ...]]:
        """Return, by input of the system, what it feeds: target, gain, offset."""
        return {
            name: tuple(
                (".".join(r.target), *self._by(r)) for r in self._routes(name) if r.target[0]
            )
            for name in self.structure.inputs
        }

    def free_inputs(self) -> list[str]:
        """Return the inputs of components that nothing feeds, "component.input"."""
        taken = {target for _, target in self.connections()}
        known = [
            f"{name}.{label}"
            for name, description in self.descriptions.items()
            for variable in description.of_causality("input")
            for label in variable.labels
        ]
        return [name for name in known if name not in taken]

    def outputs(self) -> dict[str, tuple[str, float, float]]:
        """Return, by output of the system, what it shows: source, gain, offset."""
        return {
            route.target[1]: (".".join(route.source), *self._by(route))
            for route in self.structure.routes
            if route.source[0] and not route.target[0]
        }

    def units(self) -> dict[str, FmuUnit]:
        """Return the unit of each variable, and of each input and output of the system."""
        found = {f"{b}.{n}": unit for b, own in self._units.items() for n, unit in own.items()}
        ends = {**self.outputs(), **{name: fed[0] for name, fed in self.inputs().items() if fed}}
        alike = {name: end for name, (end, *by) in ends.items() if by == [*_SAME]}
        found |= {name: found[end] for name, end in alike.items() if end in found}
        return found | {n: self._named(u) for n, u in self.structure.named_units.items()}

    def recorded(self, names: Iterable[str]) -> dict[str, list[str]]:
        """Return what to record of each component."""
        found: dict[str, list[str]] = {name: [] for name in self.descriptions}
        for name in names:
            block, _, own = name.partition(".")
            if block not in found or not own:
                known = [f"{each}.…" for each in found]
                raise FmuError(f"record {name!r}{candidates(name, known)}")
            found[block].append(own)
        return found

    def _routes(self, name: str) -> list[Route]:
        return [route for route in self.structure.routes if route.source == ("", name)]

    def _by(self, route: Route) -> tuple[float, float]:
        place = f"connection {'.'.join(filter(None, route.source))} -> {'.'.join(route.target)}"
        unit = self._unit(route.source) if route.source[0] else self._named(route.unit)
        return self._along(unit, route.hops, route.target, place)

    def _named(self, unit: str) -> FmuUnit:
        return unit_of(unit, self.structure.units)

    def _unit(self, end: End, *, by_fmu: bool = False) -> FmuUnit:
        if not end[0]:
            return _NO_UNIT
        units = units_of(self.descriptions[end[0]]) if by_fmu else self._units[end[0]]
        return units.get(end[1], _NO_UNIT)

    def _along(
        self, unit: FmuUnit, hops: tuple[Hop, ...], target: End, place: str
    ) -> tuple[float, float]:
        """Return gain and offset of a chain of connections, units converted before each."""
        gain, offset = _SAME
        for hop in hops:
            last = self._unit(target) if hop is hops[-1] else _NO_UNIT
            unit_there = self._named(hop.unit) if hop.unit else last
            found = _SAME if hop.literal else conversion(unit, unit_there)
            if found is None:
                raise FmuError(
                    f"{place}: {unit.name} cannot be converted to {unit_there.name}; correct the "
                    "units, or suppress the conversion in the SSP"
                )
            gain = hop.factor * found[0] * gain
            offset = hop.factor * (found[0] * offset + found[1]) + hop.offset
            if unit_there.name or hop.literal:
                unit = unit_there
        return gain, offset


def _has(description: FmuDescription, name: str) -> bool:
    try:
        description.variable(name)
    except FmuError:
        return False
    return True


def _scaled(value: Any, by: tuple[float, float], place: str) -> Any:
    if by == _SAME:
        return value
    if isinstance(value, str | bytes | bool):
        raise FmuError(f"{place}: {value!r} is no number, but is to be converted; correct the SSP")
    return by[0] * value + by[1]
