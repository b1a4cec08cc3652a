"""What an FMU says of itself: variables, units, platforms, capabilities, structure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from ...shaping.told import Rows, Told

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

CO_SIMULATION = "co-simulation"

_NAMES_IN_ERROR = 12
_LINES_IN_TEXT = 60
_NAMED = 12  # variables that a table names


class FmuError(ValueError):
    """An FMU that cannot be used as asked: what is wrong with it, and what to do about it.

    Attributes
    ----------
    result : CosimulationResult or None
        Where a run of `cosimulate` broke off at step k: its rows 0 … k.
    """

    result: Any = None


class FmuTerminated(FmuError):
    """An FMU that ended the simulation by itself, as FMI allows.

    Attributes
    ----------
    time : float
        The last time that it reached.
    outputs : (number of outputs,) array
        What it shows there.
    reached : bool
        Whether that is the end of the step.
    """

    time: float
    outputs: FloatArray
    reached: bool


@dataclass(frozen=True)
class FmuVariable:
    """A variable of an FMU, as its modelDescription.xml declares it.

    Attributes
    ----------
    name, description, unit : str
        Empty where not given. The unit may come from the declared type.
    value_reference : int
        Its handle in the binary; in FMI 2.0 aliases share one.
    type : str
        FMI's own word: Real, Integer, Boolean, String, Enumeration in FMI 2.0; Float64, Int32, …
        in FMI 3.0.
    causality, variability, initial : str
        FMI's own words; initial is empty where not given.
    start : float, int, bool, str, bytes, tuple of them or None
        None where not given; a tuple for an array, row by row.
    min, max, nominal : float or None
        None where not given.
    shape : tuple of int
        () for a scalar.
    derivative_of : str
        Name of the variable whose derivative it is, or empty.
    items : tuple of (str, int)
        Name and value of each item of an enumeration.
    relative : bool
        Whether it is a difference, such as of temperatures, to which no offset of a unit applies.
    aliases : tuple of str
        Its other names in FMI 3.0; in FMI 2.0 they are variables of the same value reference.
    """

    name: str
    value_reference: int
    type: str
    causality: str = "local"
    variability: str = "continuous"
    initial: str = ""
    start: object = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    unit: str = ""
    description: str = ""
    shape: tuple[int, ...] = ()
    derivative_of: str = ""
    items: tuple[tuple[str, int], ...] = ()
    relative: bool = False
    aliases: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of values: 1 for a scalar."""
        count = 1
        for length in self.shape:
            count *= length
        return count

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each value: the variable's own, or name[1], name[2], … (row by row)."""
        if not self.shape:
            return (self.name,)
        return tuple(f"{self.name}[{','.join(map(str, i))}]" for i in _indices(self.shape))

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Each of its values, in the order of `labels`."""
        return tuple(Signal(label, self, i) for i, label in enumerate(self.labels))


class Signal(NamedTuple):
    """One value of a variable, by a name of its own: at `place`, counted row by row from 0."""

    label: str
    variable: FmuVariable
    place: int


@dataclass(frozen=True)
class FmuUnit:
    """A unit: value in base units = factor·value + offset; exponents of kg, m, s, A, K, … .

    `base` is empty where the FMU does not say what the unit is made of.
    """

    name: str
    base: tuple[tuple[str, int], ...] = ()
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Capabilities:
    """What the co-simulation interface declares it can do, and what it needs."""

    can_get_and_set_state: bool = False
    can_serialize_state: bool = False
    provides_directional_derivatives: bool = False
    can_handle_variable_step: bool = False
    can_interpolate_inputs: bool = False
    fixed_internal_step: float | None = None
    has_event_mode: bool = False
    needs_execution_tool: bool = False
    only_one_instance_per_process: bool = False


@dataclass(frozen=True)
class DefaultExperiment:
    """Times suggested by the exporter; None where not given."""

    start_time: float | None = None
    stop_time: float | None = None
    tolerance: float | None = None
    step_size: float | None = None


@dataclass(frozen=True)
class Unknown:
    """A variable of the model structure; dependencies None where the FMU does not tell them."""

    name: str
    dependencies: tuple[str, ...] | None = None


@dataclass(frozen=True, repr=False)
class FmuDescription(Told):
    """What is in an FMU, read without running any of it.

    Attributes
    ----------
    fmi_version, model_name, description, author, version, generation_tool : str
        Empty where not given.
    model_identifier : str
        Name of the binary: that of the co-simulation interface if there is one.
    kinds : tuple of str
        Of "co-simulation", "model-exchange", "scheduled-execution".
    token : str
        guid (FMI 2.0) or instantiationToken (FMI 3.0).
    variables : tuple of FmuVariable
        In the order of the file.
    units : tuple of FmuUnit
    platforms : tuple of str
        Folders of `binaries` that hold a library of this model identifier.
    has_sources : bool
    capabilities : Capabilities
    default_experiment : DefaultExperiment
    outputs, derivatives, initial_unknowns : tuple of Unknown
        The model structure.
    sha256 : str
        Of the whole file, in hexadecimal digits.
    """

    fmi_version: str
    model_name: str
    model_identifier: str
    kinds: tuple[str, ...]
    token: str
    description: str = ""
    author: str = ""
    version: str = ""
    generation_tool: str = ""
    variables: tuple[FmuVariable, ...] = ()
    units: tuple[FmuUnit, ...] = ()
    platforms: tuple[str, ...] = ()
    has_sources: bool = False
    capabilities: Capabilities = field(default_factory=Capabilities)
    default_experiment: DefaultExperiment = field(default_factory=DefaultExperiment)
    outputs: tuple[Unknown, ...] = ()
    derivatives: tuple[Unknown, ...] = ()
    initial_unknowns: tuple[Unknown, ...] = ()
    sha256: str = ""

    def table_rows(self) -> Rows:
        """Return what it is, and the variables of each causality."""
        yield from (("model", self.model_name), ("FMI", self.fmi_version))
        yield "kinds", ", ".join(self.kinds)
        yield "platforms", ", ".join(self.platforms) or "none"
        for causality in ("input", "output", "parameter"):
            names = [variable.name for variable in self.of_causality(causality)]
            some = ", ".join(names[:_NAMED]) + (", …" if len(names) > _NAMED else "")
            yield f"{causality}s", f"{len(names)}: {some}" if names else "none"

    def variable(self, name: str) -> FmuVariable:
        """Return the variable of a name, an alias or an element, such as A[1,2] of A.

        FmuError, naming the nearest ones, if none has it.
        """
        return self.element(name)[0]

    def element(self, name: str) -> tuple[FmuVariable, int | None]:
        """Return `variable(name)`, and the place of an element, counted row by row from 0."""
        if name in self._named:
            return self._named[name], None
        head, _, index = str(name).rpartition("[")
        variable = self._named.get(head)
        if variable is None or not variable.shape or not index.endswith("]"):
            raise FmuError(
                f"{self.model_name} has no variable {name!r}{candidates(name, self._named)}"
            )
        return variable, _place(name, index[:-1], variable.shape)

    def signals(self, name: str) -> tuple[Signal, ...]:
        """Return the values that a name stands for: one, or all those of an array, spread out."""
        variable, place = self.element(name)
        if place is not None:
            return (Signal(name, variable, place),)
        return tuple(
            signal._replace(variable=variable) for signal in replace(variable, name=name).signals
        )

    @property
    def tool_hint(self) -> str:
        """What may be behind an FMU's failure to begin: the end of a message, or nothing."""
        if not self.capabilities.needs_execution_tool:
            return ""
        return (
            " (it declares needsExecutionTool: it may need the tool that made it, "
            f"{self.generation_tool or 'unknown'}, on this machine; install that, or export the "
            "FMU self-contained)"
        )

    @cached_property
    def _named(self) -> dict[str, FmuVariable]:
        others = {alias: v for v in self.variables for alias in v.aliases}
        return {**others, **{variable.name: variable for variable in self.variables}}

    def of_causality(self, *causalities: str) -> tuple[FmuVariable, ...]:
        """Return the variables of these causalities, in the order of the file."""
        return tuple(v for v in self.variables if v.causality in causalities)

    def __str__(self) -> str:
        lines = [
            f"{self.model_name}: FMI {self.fmi_version}, {', '.join(self.kinds)}",
            *(f"  {line}" for line in self._summary()),
        ]
        for title, causalities in (
            ("inputs", ("input",)),
            ("outputs", ("output",)),
            ("parameters", ("parameter", "structuralParameter")),
        ):
            chosen = self.of_causality(*causalities)
            lines += [f"  {title}: {len(chosen) or 'none'}"]
            lines += [f"    {_line(variable)}" for variable in chosen[:_LINES_IN_TEXT]]
            if len(chosen) > _LINES_IN_TEXT:
                lines.append(f"    … and {len(chosen) - _LINES_IN_TEXT} more")
        return "\n".join(lines)

    def _summary(self) -> list[str]:
        can = self.capabilities
        declared = {
            "get and set its state": can.can_get_and_set_state,
            "serialise its state": can.can_serialize_state,
            "directional derivatives": can.provides_directional_derivatives,
            "steps of any length": can.can_handle_variable_step,
        }
        code = [*self.platforms, *(["sources"] if self.has_sources else [])]
        experiment = self.default_experiment
        pairs = {
            "description": self.description,
            "made by": self.generation_tool,
            "binary": f"{self.model_identifier} ({', '.join(code) or 'no binary, no sources'})",
            "can": ", ".join(text for text, able in declared.items() if able) or "only step",
            "step size": "" if experiment.step_size is None else f"{experiment.step_size:g}",
            "variables": str(len(self.variables)),
            "sha256": self.sha256,
        }
        return [f"{key}: {value}" for key, value in pairs.items() if value]


def candidates(name: str, names: Iterable[str]) -> str:
    """Return the end of an error about an unknown name: what it may have meant, and a full stop."""
    known = list(names)
    if not known:
        return ": there are none"
    near = get_close_matches(name, known, n=3, cutoff=0.5)
    if near:
        return f": did you mean {' or '.join(map(repr, near))}?"
    listed = ", ".join(known[:_NAMES_IN_ERROR])
    return f": expected one of {listed}{', …' if len(known) > _NAMES_IN_ERROR else ''}"


def _line(variable: FmuVariable) -> str:
    shape = f"[{'×'.join(map(str, variable.shape))}]" if variable.shape else ""
    parts = [f"{variable.name}{shape}"]
    if variable.unit:
        parts.append(f"[{variable.unit}]")
    if variable.start is not None:
        parts.append(f"= {variable.start}")
    if variable.min is not None or variable.max is not None:
        low = "−∞" if variable.min is None else f"{variable.min:g}"
        high = "∞" if variable.max is None else f"{variable.max:g}"
        parts.append(f"({low} to {high})")
    if variable.type not in ("Real", "Float64"):
        parts.append(variable.type)
    if variable.items:
        parts.append(f"({', '.join(f'{name} = {value}' for name, value in variable.items)})")
    if variable.aliases:
        parts.append(f"(also {', '.join(variable.aliases)})")
    if variable.description:
        parts.append(f"– {variable.description}")
    return " ".join(parts)


def _place(name: str, index: str, shape: tuple[int, ...]) -> int:
    counts = [int(part) if part.strip().isdecimal() else 0 for part in index.split(",")]
    if len(counts) != len(shape) or not all(map(_within, counts, shape)):
        raise FmuError(
            f"no element {name!r}: the array has {'×'.join(map(str, shape))} values, counted "
            "from 1 in each direction"
        )
    place = 0
    for i, length in zip(counts, shape, strict=True):
        place = place * length + i - 1
    return place


def _within(count: int, length: int) -> bool:
    return 1 <= count <= length


def _indices(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    found: list[tuple[int, ...]] = [()]
    for length in shape:
        found = [(*index, i) for index in found for i in range(1, length + 1)]
    return found
