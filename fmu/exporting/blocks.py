"""What a block is to the outside: its variables, and the C core that computes them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

MAX_DOUBLE = 1.7976931348623157e308
LEAST_POSITIVE = 2.2250738585072014e-308

_NOT_IN_XML = re.compile("[\x00-\x1f\ud800-\udfff\ufffe\uffff]")
_WORDS_OF_C = re.compile(
    r"auto|break|case|char|const|continue|default|do|double|else|enum|extern|float|for|goto|if|"
    r"inline|int|long|register|restrict|return|short|signed|sizeof|static|struct|switch|typedef|"
    r"union|unsigned|void|volatile|while"
)
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)")


def check_xml_name(what: str, name: str) -> None:
    """Refuse a name that is blank or that XML cannot hold."""
    if not isinstance(name, str):
        raise TypeError(f"{what} {name!r}: expected text as its name")
    if not name.strip() or _NOT_IN_XML.search(name):
        raise ValueError(
            f"{what} {name!r}: expected a name of letters, digits, signs and blanks, not of blanks "
            "alone; XML holds no control characters, lone surrogates, U+FFFE or U+FFFF"
        )


@dataclass(frozen=True)
class Variable:
    """A scalar variable of a block, as modelDescription.xml tells it.

    Attributes
    ----------
    name, description, unit : str
    causality, variability : str
        As in FMI.
    initial : "exact", "calculated" or None
    start : float
        Start value; of what is calculated, unused.
    minimum, maximum : float, optional
        Enforced by the binary.
    derivative_of : str, optional
        Name of the continuous state whose derivative it is.
    state : bool
        Whether it is a continuous state.
    dependencies, initial_dependencies : mapping
        Names of the variables on which it depends, with the kind ("constant", "tunable",
        "dependent"), at communication points and during initialisation.
    macro : str
        Name of its index in C; empty where the core needs none.
    """

    name: str
    description: str
    causality: str
    variability: str = "continuous"
    initial: str | None = None
    start: float = 0.0
    unit: str = "1"
    minimum: float | None = None
    maximum: float | None = None
    derivative_of: str | None = None
    state: bool = False
    dependencies: Mapping[str, str] = field(default_factory=dict)
    initial_dependencies: Mapping[str, str] = field(default_factory=dict)
    macro: str = ""

    @property
    def has_start(self) -> bool:
        """Whether modelDescription.xml gives a start value."""
        return self.initial == "exact" or self.causality == "input"

    @property
    def flags(self) -> str:
        """What may be done with it, as an expression in C."""
        settable = self.initial == "exact" and self.variability != "constant"
        told = {
            "START": settable and self.variability != "tunable",
            "TUNABLE": self.variability == "tunable",
            "INPUT": self.causality == "input",
            "STATE": self.state,
            "OUTPUT": self.causality == "output",
            "DERIVATIVE": self.derivative_of is not None,
        }
        return " | ".join(name for name, holds in told.items() if holds) or "0"


@dataclass(frozen=True)
class Block:
    """A block that can leave as an FMU.

    Attributes
    ----------
    name : str
        A C identifier: the FMU's modelIdentifier.
    description : str
    variables : tuple of Variable
        Value reference k + 1 is variables[k].
    core : str
        C file that computes them.
    constants : mapping
        Macros of that file, name to text.
    tables : mapping
        Its arrays, name to numbers in any nesting.
    memory : int
        How many numbers it keeps beside its variables.
    work : int
        How many numbers of work space it takes, which may be zeroed at any time.
    partials : bool
        Whether it provides directional derivatives.
    sample_time : float, optional
        Fixed sample time of a block that runs at ticks.
    start_time, stop_time, step : float
        Default experiment.
    notes : tuple of str
        Paragraphs of the documentation.
    """

    name: str
    description: str
    variables: tuple[Variable, ...]
    core: str
    constants: Mapping[str, str] = field(default_factory=dict)
    tables: Mapping[str, Sequence[object]] = field(default_factory=dict)
    memory: int = 0
    work: int = 0
    partials: bool = False
    sample_time: float | None = None
    start_time: float = 0.0
    stop_time: float = 1.0
    step: float = 1e-3
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(f"name = {self.name!r}: expected text, a C identifier such as 'axis'")
        if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,60}", self.name, re.ASCII):
            raise ValueError(
                f"name = {self.name!r}: expected a C identifier of at most 61 characters (letters, "
                "digits and _, no digit first)"
            )
        if _WORDS_OF_C.fullmatch(self.name):
            raise ValueError(f"name = {self.name!r}: is a word of C; use another, as {self.name}_1")
        if _RESERVED.fullmatch(self.name):
            raise ValueError(f"name = {self.name!r}: Windows reserves it for a device; use another")
        for variable in self.variables:
            check_xml_name("variable", variable.name)
            low = -MAX_DOUBLE if variable.minimum is None else variable.minimum
            high = MAX_DOUBLE if variable.maximum is None else variable.maximum
            if variable.has_start and not low <= variable.start <= high:
                raise ValueError(
                    f"{variable.name} = {variable.start!r}: an FMU accepts {low:g} to {high:g}; "
                    "choose other units"
                )
        if len(self.reference) != len(self.variables) or "time" in self.reference:
            names = [variable.name for variable in self.variables]
            twice = sorted({name for name in names if names.count(name) > 1} or {"time"})
            raise ValueError(
                f"two variables of {self.name} are called {', '.join(twice)}: give inputs and "
                "outputs names of their own (control.ss(…, inputs=…, outputs=…))"
            )

    @cached_property
    def reference(self) -> dict[str, int]:
        """Value reference by name."""
        return {variable.name: k for k, variable in enumerate(self.variables, start=1)}

    @property
    def outputs(self) -> list[Variable]:
        """Outputs, in the order of the model structure."""
        return [variable for variable in self.variables if variable.causality == "output"]

    @property
    def derivatives(self) -> list[Variable]:
        """Derivatives of continuous states."""
        return [variable for variable in self.variables if variable.derivative_of is not None]

    @property
    def initial_unknowns(self) -> list[Variable]:
        """What the binary calculates during initialisation."""
        return [
            variable
            for variable in self.variables
            if variable.initial == "calculated"
            and (variable.causality == "output" or variable.state or variable.derivative_of)
        ]


def parameter(
    name: str,
    description: str,
    start: float,
    unit: str = "1",
    *,
    variability: str = "tunable",
    minimum: float | None = None,
    maximum: float | None = None,
) -> Variable:
    """Return a parameter, tunable or fixed."""
    return Variable(
        name,
        description,
        "parameter",
        variability,
        "exact",
        start,
        unit,
        minimum,
        maximum,
        macro=macro(name),
    )


def signal(name: str, description: str, unit: str = "1") -> Variable:
    """Return an input."""
    return Variable(name, description, "input", unit=unit, macro=macro(name))


def output(
    name: str,
    description: str,
    unit: str = "1",
    *,
    variability: str = "continuous",
    dependencies: Mapping[str, str] | None = None,
    initial_dependencies: Mapping[str, str] | None = None,
) -> Variable:
    """Return a calculated output."""
    return Variable(
        name,
        description,
        "output",
        variability,
        "calculated",
        unit=unit,
        dependencies=dependencies or {},
        initial_dependencies=initial_dependencies or {},
        macro=macro(name),
    )


def sample_time_constant(sample_time: float) -> Variable:
    """Return the constant that tells a block's sample time."""
    return Variable("sample_time", "Sample time", "local", "constant", "exact", sample_time, "s")


def macro(name: str) -> str:
    """Return the name of a variable's index in C."""
    return "V_" + re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").upper()
