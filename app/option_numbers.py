"""Numbers given to options of the command line: read from text, which a refusal names."""

from __future__ import annotations

import math


def whole_number(option: str, text: str | None, least: int, example: int) -> int | None:
    """Return a whole number from `least` on, such as the example; None of None."""
    if text is None:
        return None
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if number < least:
        raise ValueError(
            f"{option} {text!r}: expected a whole number from {least} on, such as {example}"
        )
    return number


def positive_number(option: str, text: str | None, example: float) -> float | None:
    """Return a positive finite number, such as the example; None of None."""
    if text is None:
        return None
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise ValueError(f"{option} {text!r}: expected a positive number, such as {example}")
    return number
