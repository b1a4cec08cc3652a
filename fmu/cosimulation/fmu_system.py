"""FMUs and what connects them, as one system: run, fed from outside, its outputs shown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from types import MappingProxyType, TracebackType
from typing import Literal, Self

import numpy as np

from ...shaping.checks import positive
from ...shaping.told import table
from ..importing.description import FmuError, FmuUnit, candidates
from ..importing.stepping import Fmu
from .cosimulate import cosimulate
from .cosimulation_result import CosimulationResult
from .over_time import Source, scaled
from .participants import units_of

_NEARLY = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class FmuSystem:
    """FMUs, initialised, with what connects them: those of an SSP file. A context manager.

    Attributes
    ----------
    name : str
    blocks : mapping of str to Fmu
        In the order of the file; those of a system within the system are "system/component".
    connections : tuple of (source, target)
        Between them, as `cosimulate` takes them.
    inputs : mapping of str to tuple of (target, gain, offset)
        What each input of the system as a whole feeds.
    outputs : mapping of str to (source, gain, offset)
        What each output of the system as a whole shows.
    units : mapping of str to FmuUnit
        Of inputs and outputs of the system, and by "component.variable", where they have one.
    dt : float
        Least step that one of the FMUs suggests.
    stop_time : float or None
        Of the default experiment.
    notes : tuple of str
        Parameters of the file that nothing takes.
    """

    name: str
    blocks: Mapping[str, Fmu]
    connections: tuple[tuple[Source, str], ...]
    inputs: Mapping[str, tuple[tuple[str, float, float], ...]]
    outputs: Mapping[str, tuple[str, float, float]]
    units: Mapping[str, FmuUnit]
    dt: float
    stop_time: float | None
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        links = f"{len(self.connections)} connections"
        return f"<FmuSystem {self.name}: {', '.join(self.blocks)}; {links}>"

    def _repr_html_(self) -> str:
        """Return the system as a table: its FMUs, and each input and output with its unit."""
        rows = [("FMU", name) for name in self.blocks]
        rows.append(("connections", str(len(self.connections))))
        for kind, names in (("input", self.inputs), ("output", self.outputs)):
            rows += [
                (kind, f"{name} [{self.units[name].name}]" if name in self.units else name)
                for name in names
            ]
        rows.append(("step", f"{self.dt:g} s"))
        return table(self.name, rows)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close all the FMUs."""
        with ExitStack() as stack:
            for fmu in self.blocks.values():
                stack.callback(fmu.close)

    def run(
        self,
        duration: float | None = None,
        *,
        dt: float | None = None,
        inputs: Mapping[str, Source] | None = None,
        order: Literal["gauss-seidel", "jacobi"] | Sequence[str] = "gauss-seidel",
        progress: bool | None = None,
    ) -> CosimulationResult:
        """Return `cosimulate` of the system, with its outputs as further signals.

        Parameters
        ----------
        duration, dt : float, optional
            Default: to the stop time of the default experiment, in the steps that the FMUs
            suggest.
        inputs : mapping of str to source, optional
            By name of an input of the system, or by "component.input" that nothing feeds:
            numbers, trajectories, functions of time, tables, as sources of `cosimulate`.
        order, progress
            As in `cosimulate`; SSP itself says nothing of an order.
        """
        dt = self.dt if dt is None else positive("dt", dt)
        if duration is None:
            duration = self._lasting(dt)
        links = [*self.connections, *self._fed(inputs or {})]
        try:
            found = cosimulate(
                self.blocks, links, dt=dt, duration=duration, order=order, progress=progress
            )
        except FmuError as error:
            if error.result is not None:
                error.result = self._with_outputs(error.result)
            raise
        return self._with_outputs(found)

    @property
    def free_inputs(self) -> tuple[str, ...]:
        """Inputs that nothing feeds, "component.input"."""
        taken = {target for _, target in self.connections}
        known = [f"{own}.{name}" for own, fmu in self.blocks.items() for name in fmu.input_names]
        return tuple(name for name in known if name not in taken)

    def _lasting(self, dt: float) -> float:
        start = next(iter(self.blocks.values())).time
        if self.stop_time is None or not self.stop_time > start:
            raise FmuError(f"{self.name} suggests no stop time: give a duration")
        return max(math.ceil((self.stop_time - start) / dt * (1.0 - _NEARLY)), 1) * dt

    def _fed(self, inputs: Mapping[str, Source]) -> list[tuple[Source, str]]:
        taken = {target for _, target in self.connections}
        found: list[tuple[Source, str]] = []
        for name, source in inputs.items():
            if name in taken:
                raise FmuError(f"input {name!r} is connected within {self.name}; leave it out")
            if name in self.inputs:
                found += [(scaled(source, *by), target) for target, *by in self.inputs[name]]
            elif name in self.free_inputs:
                found.append((source, name))
            else:
                known = (*self.inputs, *self.free_inputs)
                raise FmuError(f"{self.name} has no input {name!r}{candidates(name, known)}")
        targets = [target for _, target in found]
        for target in targets:
            if targets.count(target) > 1:
                raise FmuError(f"inputs: {target!r} is given twice, by two names; leave one out")
        return found

    def _with_outputs(self, found: CosimulationResult) -> CosimulationResult:
        shown = {}
        for name, (source, gain, offset) in self.outputs.items():
            shown[name] = np.asarray(gain * found[source] + offset)
            shown[name].flags.writeable = False
        return replace(
            found,
            signals=MappingProxyType({**shown, **found.signals}),
            outputs=(*shown, *found.outputs),
            notes=(*self.notes, *found.notes),
        )


def system_of(fmu: Fmu) -> FmuSystem:
    """Return one FMU as a system, its inputs those of the system."""
    description = fmu.description
    own = description.model_identifier
    units = units_of(description, fmu.units)
    named = {f"{own}.{label}": unit for label, unit in units.items()}
    return FmuSystem(
        name=description.model_name,
        blocks=MappingProxyType({own: fmu}),
        connections=(),
        inputs=MappingProxyType({n: ((f"{own}.{n}", 1.0, 0.0),) for n in fmu.input_names}),
        outputs=MappingProxyType({}),
        units=MappingProxyType({**units, **named}),
        dt=fmu.dt,
        stop_time=description.default_experiment.stop_time,
    )
