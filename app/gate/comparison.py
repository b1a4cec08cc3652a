"""A loop's numbers beside their baseline and their bounds: what was, is and may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite, isnan
from typing import Literal

from ..scenario_messages import key_path
from .baseline import Baseline, Stored
from .check_file import Checks, Requirement
from .conditions import Conditions
from .numbers import RTOL, Better, Key, Number, absent

Verdict = Literal[
    "outside", "worse", "changed", "gone", "better", "new", "unsure", "same", "within", "unchecked"
]

FAILURES: tuple[Verdict, ...] = ("outside", "worse", "changed", "gone")
"""Verdicts that fail a check."""

NOTES: tuple[Verdict, ...] = ("better", "new")
"""Verdicts that pass, but that a new baseline would settle."""

_SIGMAS = 3.0  # by how many standard deviations a measured number differs for sure
_DIGITS = 7
_MOST_DIGITS = 17


@dataclass(frozen=True)
class Row:
    """One number: what it was and is, what it may be, and what that comes to.

    Attributes
    ----------
    key : tuple of str
        Its name in parts.
    was, now : float or None
        None where the baseline, or the loop, has no such number; inf or nan where it has the
        number but no value: nothing limits the margin, the response never settles.
    least, most : float
        The smallest and largest value that would pass.
    verdict : str
        "outside" a bound of the check file, or beside the baseline: "worse", "better",
        "changed" (beyond tolerance, for a number without a better side), "same" (within
        tolerance), "gone" (only in the baseline) or "new" (not in it). Without a baseline:
        "within" the bounds, or "unchecked" for want of any. "unsure": a measured one that is not
        outside a bound for sure, nor within.
    """

    key: Key
    was: float | None
    now: float | None
    least: float
    most: float
    verdict: Verdict

    @property
    def name(self) -> str:
        """The key as the check file writes it."""
        return key_path(self.key)

    @property
    def was_shown(self) -> str:
        """What was, as text; empty where there was nothing."""
        return _shown(self.was, self._digits)

    @property
    def now_shown(self) -> str:
        """What is, as text; empty where there is nothing."""
        return _shown(self.now, self._digits)

    @property
    def allowed(self) -> str:
        """What may be, as text; empty where anything may."""
        if self.least == inf or isnan(self.least):
            return "none"
        least, most = (f"{bound:.{self._digits}g}" for bound in (self.least, self.most))
        if self.least == -inf:
            return "" if self.most == inf else f"<= {most}"
        return f">= {least}" if self.most == inf else f"{least} to {most}"

    @property
    def message(self) -> str:
        """The row as a sentence."""
        if self.now is None:
            return f"{self.name} was {self.was_shown} and is measured no more"
        was = f", was {self.was_shown}" if self.was is not None else ""
        allowed = f"; allowed {self.allowed}" if self.allowed else ""
        return f"{self.name} is {self.now_shown}{was}: {self.verdict}{allowed}"

    @property
    def _digits(self) -> int:
        """Digits that tell a change from what was and may be."""
        if self.verdict not in (*FAILURES, "better") or self.now is None:
            return _DIGITS
        edges = [x for x in (self.was, self.least, self.most) if x is not None and isfinite(x)]
        for digits in range(_DIGITS, _MOST_DIGITS):
            now = _shown(self.now, digits)
            if all(now != _shown(edge, digits) for edge in edges if edge != self.now):
                return digits
        return _MOST_DIGITS


def compare(
    numbers: Sequence[Number],
    baseline: Baseline | None,
    checks: Checks,
    *,
    two_sided: bool = False,
) -> tuple[Row, ...]:
    """Return a row for every number, measured or stored.

    A number is the same as in its baseline where they differ by no more than
    max(rtol·|was|, atol), of measured ones 3 standard deviations of the difference, or where
    neither has a value. Tolerances are those that the check file gives to the number itself, else
    those of the baseline: the check file's `rtol` of all numbers counts where a baseline is stored
    (see `measured_baseline`), not here. With `two_sided`, what a
    row allows ends on the better side, too.
    """
    rows = [_row(number, baseline, checks, two_sided=two_sided) for number in numbers]
    known = {number.key for number in numbers}
    stored = {} if baseline is None else baseline.numbers
    gone = [_gone(key, entry) for key, entry in stored.items() if key not in known]
    return (*rows, *gone)


def measured_baseline(
    numbers: Sequence[Number],
    previous: Baseline | None,
    checks: Checks,
    *,
    scenario: str | None = None,
    position_unit: str | None = None,
    conditions: Conditions | None = None,
) -> Baseline:
    """Return numbers as a baseline, each with its tolerances, and with what they depend on.

    The tolerances are those that the check file gives to the number itself, else those of the
    previous baseline; for a number that is new, or whose relative tolerance was stored as the
    usual 1e-6, that is the check file's `rtol` of all numbers, if it has one.
    """
    before = {} if previous is None else previous.numbers
    stored = {}
    for number in numbers:
        entry = before.get(number.key, Stored(None, RTOL, number.atol))
        if entry.rtol == RTOL and checks.rtol is not None:
            entry = replace(entry, rtol=checks.rtol)
        rtol, atol = _tolerance(entry, checks.of(number.key))
        value = number.value if isfinite(number.value) else None
        stored[number.key] = Stored(value, rtol, atol, number.sigma)
    return Baseline(scenario, position_unit, stored, conditions)


def _row(number: Number, baseline: Baseline | None, checks: Checks, *, two_sided: bool) -> Row:
    asked = checks.of(number.key)
    stored = None if baseline is None else baseline.numbers.get(number.key)
    was, least, most = None, asked.least, asked.most
    verdict: Verdict = "new" if baseline is not None else _unstored(asked)
    if stored is not None:
        was = absent(number.better) if stored.value is None else stored.value
        rtol, atol = _tolerance(stored, asked)
        noise = hypot(number.sigma, stored.sigma)
        room = (_SIGMAS if asked.sigmas is None else asked.sigmas) * noise
        width = max(rtol * abs(was), atol, room) if isfinite(was) else 0.0
        verdict = _beside(was, number, width)
        least, most = _allowed(was, None if two_sided else number.better, width, asked)
    if verdict not in FAILURES and not asked.is_sure_of(number.value, number.sigma):
        verdict = "unsure"
    if not asked.admits(number.value, number.sigma):
        verdict, least, most = "outside", asked.least, asked.most
    return Row(number.key, was, number.value, least, most, verdict)


def _unstored(asked: Requirement) -> Verdict:
    return "unchecked" if asked.least == -inf and asked.most == inf else "within"


def _gone(key: Key, stored: Stored) -> Row:
    was = inf if stored.value is None else stored.value
    return Row(key, was, None, -inf, inf, "gone")


def _tolerance(stored: Stored, asked: Requirement) -> tuple[float, float]:
    """Return rtol and atol: those asked of the number itself, else those stored with it."""
    rtol = stored.rtol if asked.rtol is None else asked.rtol
    return rtol, stored.atol if asked.atol is None else asked.atol


def _beside(was: float, number: Number, width: float) -> Verdict:
    now = number.value
    neither = isnan(was) and isnan(now)
    if now == was or neither or abs(now - was) <= width:
        return "same"
    if number.better is None:
        return "changed"
    return "better" if (now > was) == (number.better == "higher") else "worse"


def _allowed(was: float, better: Better, width: float, asked: Requirement) -> tuple[float, float]:
    """Return the interval that passes; that of the baseline where none passes both."""
    least = -inf if better == "lower" else was - width
    most = inf if better == "higher" else was + width
    both = max(least, asked.least), min(most, asked.most)
    return (least, most) if both[0] > both[1] else both


def _shown(value: float | None, digits: int) -> str:
    if value is None:
        return ""
    return f"{value + 0.0:.{digits}g}" if isfinite(value) else "none"
