"""Units that a scenario file defines itself: a count of its encoder, a sample of its controller."""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal, DecimalException

from .units import UnitError, factor, parted, show

_WORD = re.compile(
    r"(?<![A-Za-z_])(count|sample)s?(?![A-Za-z_])(?:\s*(?:\^|\*\*)\s*(-?[0-9]{1,2})|([²³]))?"
)
_WHERE = {
    "count": 'of an encoder that is not given; write encoder_step = "0.1 arcsec" into [plant]',
    "sample": 'that are not given; write sample_time = "1 ms" into [controller]',
}


def spelled_out(unit: str, counted: Mapping[str, str]) -> tuple[Decimal, str]:
    """Return a unit without counts and samples, and by what it is to be multiplied.

    Parameters
    ----------
    unit : str
        Such as "count/s" or "count^2/Hz".
    counted : mapping
        What a count and a sample are, "0.1 arcsec" and "1 ms".

    Raises
    ------
    UnitError
        For a count or a sample that is not known.
    """
    size, parts, end = Decimal(1), [], 0
    for match in _WORD.finditer(unit):
        word = match[1]
        if word not in counted:
            raise UnitError(f"{show(unit)} is in {word}s {_WHERE[word]}, or another unit")
        power = int(match[2] or "0²³".find(match[3] or "0") + 1)
        one = parted(counted[word])
        assert one is not None  # what reads the file has checked it
        number, of = one
        try:
            below = _is_below(unit[: match.start()])
            size *= Decimal(number) ** (-power if below else power)
        except DecimalException:
            raise UnitError(f"{show(unit)} is outside the range of numbers") from None
        parts += [unit[end : match.start()], of if power == 1 else f"{of}^{power}"]
        end = match.end()
    return size, "".join([*parts, unit[end:]])


def _is_below(before: str) -> bool:
    """Whether what comes behind this text is below a solidus, alone or in parentheses."""
    if before.count("(") > before.count(")"):
        before = before[: before.rindex("(")]
    return before.rstrip().endswith("/")


def counted_factor(unit: str, counted: Mapping[str, str]) -> float:
    """Return the SI value of a unit, in which there may be counts, as `units.factor` does."""
    size, plain = spelled_out(unit, counted)
    return factor(plain) if size == 1 else float(size) * factor(plain)
