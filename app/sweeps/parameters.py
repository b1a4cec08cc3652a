"""What a sweep varies: ranges and lists of values, with units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import exp, isfinite, log
from typing import Any

import numpy as np

from ...shaping.frozen import Frozen
from ..units import conversion, parted, show


@dataclass(frozen=True)
class Uniform(Frozen):
    """Every value between two is as likely, `Uniform("0.9 kg m^2", "1.1 kg m^2")`.

    Raises
    ------
    ValueError
        Where the ends are no numbers, with or without a unit, or do not increase.
    """

    low: str | float
    high: str | float

    def __post_init__(self) -> None:
        _check_increasing(self)

    def at(self, fraction: float) -> float:
        """Return the value below which a fraction of all values lies, in `low`'s unit."""
        low, high = _ends(self)
        return low + fraction * (high - low)


@dataclass(frozen=True)
class LogUniform(Frozen):
    """The logarithm is uniform between two positive values: as many in each decade."""

    low: str | float
    high: str | float

    def __post_init__(self) -> None:
        _check_increasing(self)
        if _ends(self)[0] <= 0.0:
            raise ValueError(f"low = {show(self.low)}: expected a positive value; use Uniform")

    def at(self, fraction: float) -> float:
        """Return the value below which a fraction of all values lies, in `low`'s unit."""
        low, high = map(log, _ends(self))
        return exp(low + fraction * (high - low))


@dataclass(frozen=True)
class Normal(Frozen):
    """Normally distributed: `Normal("6 Hz", "0.2 Hz")` has this mean and standard deviation."""

    mean: str | float
    deviation: str | float

    def __post_init__(self) -> None:
        if not _ends(self)[1] > 0.0:
            raise ValueError(f"deviation = {show(self.deviation)}: expected a positive one")

    def at(self, fraction: float) -> float:
        """Return the value below which a fraction of all values lies, in `mean`'s unit."""
        from scipy.special import ndtri

        mean, deviation = _ends(self)
        return mean + deviation * float(ndtri(fraction))


Range = Uniform | LogUniform | Normal


class Parameter:
    """One key of a scenario that varies: its values as the file has them, and as numbers.

    `unit` is that of the numbers; empty where there is none. Values that are no quantities, such
    as the names of shapers, are kept as text.
    """

    def __init__(self, key: str, given: object) -> None:
        self.key = key
        self.range = given if isinstance(given, Range) else None
        self.choices: tuple[Any, ...] = ()
        self.unit = ""
        if self.range is not None:
            self.unit = _split(next(_values(self.range)))[1]
        else:
            self.choices = _listed(key, given)
            self._name_units()

    def _name_units(self) -> None:
        parts = [_try_split(choice) for choice in self.choices]
        if all(part is not None for part in parts):
            self.unit = parts[0][1] if parts[0] else ""

    def at(self, fraction: float) -> object:
        """Return the value at a fraction of its distribution, as a scenario file has it."""
        if self.range is None:
            return self.choices[min(int(fraction * len(self.choices)), len(self.choices) - 1)]
        value = self.range.at(fraction)
        return f"{value!r} {self.unit}" if self.unit else value

    def number(self, value: object) -> float | str:
        """Return a value as a number in the parameter's unit, or as text where it is none."""
        part = _try_split(value)
        if part is None or isinstance(value, bool):
            return str(value)
        if _singular(part[1]) == _singular(self.unit):
            return part[0]
        try:
            return part[0] * conversion(part[1], self.unit)
        except ValueError:
            first = f"as {show(self.choices[0])} is" if self.choices else f"in {self.unit!r}"
            raise ValueError(
                f"parameter {self.key} = {show(value)}: expected a value of one kind with the "
                f"others, {first}"
            ) from None

    @property
    def ends(self) -> tuple[object, ...]:
        """The extreme values: both ends of a range, 2 deviations from a mean, or all of a list."""
        if self.range is None:
            return self.choices
        if isinstance(self.range, Normal):
            low, high = 0.0227501319481792, 0.977249868051821  # of a normal distribution
            return self.at(low), self.at(high)
        return self.at(0.0), self.at(1.0)


def parameters_of(given: Mapping[str, object]) -> tuple[Parameter, ...]:
    """Return the parameters of a sweep.

    Raises
    ------
    TypeError, ValueError
        For what is no mapping, or has no parameter, naming what a value may be.
    """
    if not isinstance(given, Mapping):
        raise TypeError(
            f"parameters = {show(given)}: expected a mapping of keys to ranges or lists, such as "
            '{"plant.inertia": Uniform("0.9 kg m^2", "1.1 kg m^2")}'
        )
    if not given:
        raise ValueError(
            'parameters = {}: nothing varies; give at least one, such as {"limits.axis.jerk": '
            '["1 deg/s^3", "2 deg/s^3"]}'
        )
    for key in given:
        if not isinstance(key, str):
            raise TypeError(f"parameter {show(key)}: expected a key as text, such as plant.inertia")
    return tuple(Parameter(key, value) for key, value in given.items())


def _listed(key: str, given: object) -> tuple[Any, ...]:
    if isinstance(given, np.ndarray):
        given = given.tolist()
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise ValueError(
            f"parameter {key} = {show(given)}: expected a list of values, or Uniform(low, high), "
            "LogUniform(low, high) or Normal(mean, deviation)"
        )
    return tuple(given)


def _singular(unit: str) -> str:
    """Return a unit with its counts and samples, which stand for no number here, in one form."""
    return re.sub(r"\b(count|sample)s\b", r"\1", unit)


def _check_increasing(given: Uniform | LogUniform) -> None:
    low, high = _ends(given)
    if not low < high:
        raise ValueError(
            f"low = {show(given.low)}, high = {show(given.high)}: the range does not increase; "
            "exchange the two, or give a list of one value"
        )


def _ends(given: Range) -> tuple[float, float]:
    """Return both numbers of a range in the unit of the first."""
    (first, unit), (second, other) = (_split(value) for value in _values(given))
    try:
        same = _singular(other) == _singular(unit)
        return first, second if same else second * conversion(other, unit)
    except ValueError:
        raise ValueError(
            f"{' and '.join(map(show, _values(given)))} in a range: expected two of one kind; give "
            "both in the same unit"
        ) from None


def _values(given: Range) -> Iterator[object]:
    yield from (vars(given)[name] for name in given.__dataclass_fields__)


def _split(value: object) -> tuple[float, str]:
    part = _try_split(value)
    if part is None or not isfinite(part[0]):
        raise ValueError(
            f'{show(value)} in a range: expected a number, with its unit as text, such as "6 Hz"'
        )
    return part


def _try_split(value: object) -> tuple[float, str] | None:
    """Return number and unit of a quantity; None for what is none."""
    if isinstance(value, int | float | np.number) and not isinstance(value, bool):
        return float(value), ""
    parts = parted(value) if isinstance(value, str) else None
    return None if parts is None else (float(parts[0]), parts[1])
