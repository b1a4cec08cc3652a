"""Names of the derivatives of position, and how a caller may say which one is meant."""

from __future__ import annotations

from operator import index

from .real_numbers import shown

DERIVATIVE_NAMES = ("position", "velocity", "acceleration", "jerk", "snap", "crackle", "pop")
"""Names by derivative number: 0 position, 1 velocity, … 6 pop."""


def derivative_number(derivative: int | str) -> int:
    """Return the number of a derivative given by number or by name.

    Parameters
    ----------
    derivative : int or str
        A number ≥ 0, or one of `DERIVATIVE_NAMES`.

    Raises
    ------
    ValueError
        For an unknown name or a negative number.
    TypeError
        For anything that is neither a name nor a whole number.
    """
    if isinstance(derivative, str):
        if derivative not in DERIVATIVE_NAMES:
            raise ValueError(
                f"unknown derivative {derivative!r}: expected a number or one of "
                f"{', '.join(DERIVATIVE_NAMES)}"
            )
        return DERIVATIVE_NAMES.index(derivative)
    try:
        if isinstance(derivative, bool):
            raise TypeError
        number = index(derivative)
    except TypeError:
        raise TypeError(
            f"derivative {shown(derivative)}: expected a whole number or one of "
            f"{', '.join(DERIVATIVE_NAMES)}"
        ) from None
    if number < 0:
        raise ValueError(f"derivative {number}: expected 0 (position) or more")
    return number


def derivative_name(number: int) -> str:
    """Return the field's name of derivative `number`, or "derivative 7" beyond pop."""
    return DERIVATIVE_NAMES[number] if number < len(DERIVATIVE_NAMES) else f"derivative {number}"
