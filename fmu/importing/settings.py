"""What a caller names of an FMU: variables to record, to start with, to read and to set."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from .description import FmuDescription, FmuError, FmuVariable, Signal
from .values import flat_values, one_value, start_values


def recorded_signals(
    description: FmuDescription,
    names: Sequence[str],
    types: Collection[str],
    known: Collection[str],
) -> list[Signal]:
    """Return the signals of names, each once, but for those whose labels are known.

    Raises
    ------
    FmuError
        For names that nothing has, and for variables that are not of one of `types`.
    """
    found: dict[str, Signal] = {}
    for name in names:
        if description.variable(name).type not in types:
            raise FmuError(
                f"record: {name!r} is of type {description.variable(name).type}, and a run records "
                "numbers; read it between steps with `get`"
            )
        found |= {signal.label: signal for signal in description.signals(name)}
    return [signal for label, signal in found.items() if label not in known]


def start_settings(
    description: FmuDescription, given: Mapping[str, Any]
) -> list[tuple[FmuVariable, list[Any]]]:
    """Return the variables that are given, and their values row by row.

    Elements stand beside the start values of the others, or beside what was given before them.
    """
    found: dict[str, tuple[FmuVariable, list[Any]]] = {}
    for name, value in given.items():
        variable, place = description.element(name)
        _check_settable(variable)
        if place is None:
            found[variable.name] = variable, flat_values(variable, value)
            continue
        if variable.name not in found:
            found[variable.name] = variable, start_values(variable)
        found[variable.name][1][place] = one_value(variable, value)
    return list(found.values())


def _check_settable(variable: FmuVariable) -> None:
    if variable.causality == "structuralParameter":
        raise FmuError(
            f"{variable.name!r} is a structural parameter, the size of an array: sizes cannot be "
            "changed here; export the FMU with the size that is needed"
        )
    settable = (
        variable.causality in ("parameter", "input") or variable.initial in ("exact", "approx")
    ) and variable.variability != "constant"
    if not settable:
        raise FmuError(
            f"{variable.name!r} cannot be set ({variable.causality}, {variable.variability}): "
            "expected a parameter, a start value or an input"
        )


def check_tunable(description: FmuDescription, name: str, numbers: Collection[str]) -> None:
    """Refuse what is not set between steps: all but tunable parameters and inputs of other types.

    `numbers` are the types of variable that hold numbers, which inputs `step` takes.
    """
    variable, _ = description.element(name)
    entered = variable.causality == "input"
    if entered and variable.type in numbers:
        raise FmuError(f"{name!r} is an input: give it to `step`")
    if not entered and variable.variability != "tunable":
        tunable = [v.name for v in description.variables if v.variability == "tunable"]
        raise FmuError(
            f"{name!r} is not a tunable parameter ({variable.causality}, "
            f"{variable.variability}): give it to load_fmu or reset"
            + (f"; tunable are {', '.join(tunable[:12])}" if tunable else "")
        )


def check_type(variable: FmuVariable, numbers: Collection[str]) -> None:
    """Refuse a variable of a type that has no values here, such as a clock."""
    if variable.type not in (*numbers, "String", "Binary"):
        raise FmuError(
            f"{variable.name!r} is of type {variable.type}, which has no value to be read or "
            "set here: leave it out"
        )
