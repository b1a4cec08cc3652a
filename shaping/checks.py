"""Checks of numbers given by a caller: one clear error, naming value and remedy."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from operator import index
from typing import TypeVar

_Result = TypeVar("_Result")


def _number(name: str, value: float) -> float:
    try:
        if isinstance(value, str):
            raise TypeError
        return float(value)
    except TypeError:
        raise TypeError(f"{name} = {value!r}: expected a number") from None
    except OverflowError:
        raise ValueError(f"{name} is beyond the range of a double") from None


def finite(name: str, value: float) -> float:
    """Return `value` as a float; ValueError unless it is finite."""
    number = _number(name, value)
    if not isfinite(number):
        raise ValueError(f"{name} = {value!r}: expected a finite number")
    return number


def positive(name: str, value: float) -> float:
    """Return `value` as a float; ValueError unless it is positive and finite."""
    number = _number(name, value)
    if not 0.0 < number < inf:
        raise ValueError(f"{name} = {value!r}: expected a positive, finite number")
    return number


def whole(name: str, value: int, least: int, most: int) -> int:
    """Return `value` as an int; ValueError unless it is whole and within least…most."""
    try:
        number = index(value)
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        raise ValueError(f"{name} = {value!r}: expected a whole number from {least} to {most}")
    return number


def range_error() -> ValueError:
    """Return the error for a plan in numbers that no double holds."""
    return ValueError(
        "the duration or a state leaves the range of a double: choose distance and time units "
        "nearer to the problem's own"
    )


def in_range(plan: Callable[[], _Result]) -> _Result:
    """Return plan(), its arithmetic errors told as numbers that leave the range of a double."""
    try:
        return plan()
    except ArithmeticError:
        raise range_error() from None
