"""Checks of numbers given by a caller: one clear error, naming value and remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import inf, isfinite
from operator import index
from typing import Any, TypeVar

import numpy as np

from .real_numbers import real_array, real_number, shown

_Noun = TypeVar("_Noun")
_Result = TypeVar("_Result")


def finite(name: str, value: float) -> float:
    """Return `value` as a float; ValueError unless it is finite."""
    number = real_number(name, value)
    if not isfinite(number):
        raise ValueError(f"{name} = {shown(value)}: expected a finite number")
    return number


def positive(name: str, value: float) -> float:
    """Return `value` as a float; ValueError unless it is positive and finite."""
    number = real_number(name, value)
    if not 0.0 < number < inf:
        raise ValueError(f"{name} = {shown(value)}: expected a positive, finite number")
    return number


def whole(name: str, value: int, least: int, most: int) -> int:
    """Return `value` as an int; ValueError unless it is whole and within least…most."""
    try:
        number = least - 1 if isinstance(value, bool) else index(value)
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        raise ValueError(f"{name} = {shown(value)}: expected a whole number from {least} to {most}")
    return number


def range_error(of: str = "") -> ValueError:
    """Return the error for a plan, " of move 3", in numbers that no double holds."""
    return ValueError(
        f"the duration or a state{of} leaves the range of a double: choose distance and time units "
        "nearer to the problem's own"
    )


def of_kind(name: str, value: Any, kind: type[_Noun], expected: str) -> _Noun:
    """Return `value`; TypeError unless it is of a kind, which `expected` says in words."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} = {shown(value)}: expected {expected}")
    return value


def one_of(name: str, value: Any, choices: tuple[str, ...]) -> None:
    """Refuse what is not one of two or more words: ValueError."""
    if not isinstance(value, str) or value not in choices:
        words = [repr(choice) for choice in choices]
        told = f"{', '.join(words[:-1])} or {words[-1]}"
        raise ValueError(f"{name} = {shown(value)}: expected {told}")


def state_numbers(name: str, given: Any) -> list[Any]:
    """Return the numbers that a state is given by, unchecked; one alone is a position."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        return [given]
    return entries(name, given if isinstance(given, list | tuple) else real_array(name, given))


def entries(name: str, given: Iterable[Any]) -> list[Any]:
    """Return what a list, an iterator or an array of real numbers holds, in order.

    Raises
    ------
    TypeError
        For another iterable, of which the names or an order of its own would be taken.
    """
    if isinstance(given, list | tuple | Iterator):
        return list(given)
    array = np.atleast_1d(real_array(name, given))
    pairs_or_numbers = array.ndim == 1 or array.shape[1:] == (2,)
    return array.tolist() if pairs_or_numbers else list(array)


def in_range(plan: Callable[[], _Result]) -> _Result:
    """Return plan(), its overflows told as numbers that leave the range of a double."""
    try:
        return plan()
    except (OverflowError, FloatingPointError) as error:
        raise range_error() from error
