"""Margins beside those of the last revision and what a check file asks of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite, nan
from types import MappingProxyType
from typing import Any

from ...analysis.margins import LoopMargins
from ...analysis.measured import MeasuredMargins
from ...analysis.specification import Requirement
from ..gate.baseline import Baseline, load_baseline
from ..gate.check import baseline_beside, checks_beside
from ..gate.check_file import Checks, checks_of, read_check_file, with_bounds
from ..gate.comparison import FAILURES, compare, measured_baseline
from ..gate.numbers import Key, Number, loop_numbers, measured_numbers
from .state import State

Margins = LoopMargins | MeasuredMargins

_ROWS = (
    ("crossover_hz", "gain crossover", "Hz", ""),
    ("phase_margin_deg", "phase margin", "deg", "crossover_hz"),
    ("lower_gain_margin_db", "lower gain margin", "dB", "lower_gain_margin_hz"),
    ("upper_gain_margin_db", "upper gain margin", "dB", "upper_gain_margin_hz"),
    ("delay_margin_s", "delay margin", "s", "delay_margin_hz"),
    ("modulus_margin", "modulus margin", "", "modulus_margin_hz"),
    ("disk_margin", "disk margin", "", "disk_margin_hz"),
    ("sensitivity_peak", "peak of S", "", "sensitivity_peak_hz"),
    ("complementary_peak", "peak of T", "", "complementary_peak_hz"),
    ("bandwidth_hz", "bandwidth", "Hz", ""),
)


@dataclass(frozen=True, eq=False)
class Revision:
    """What margins are judged by.

    Attributes
    ----------
    name : str
        Where the margins before come from: a file, or the scenario as it was opened.
    before : Baseline
    stored : bool
        Whether that is a file, so that what is worse fails. Else bounds alone judge.
    checks : Checks
        Of the check file, and with `asked` what the scenario requires.
    """

    name: str
    before: Baseline
    stored: bool
    checks: Checks

    def asked(self, requirements: tuple[Requirement, ...]) -> Revision:
        """Return the revision with the bounds that a scenario requires."""
        return replace(self, checks=with_bounds(self.checks, dict(_of_margins(requirements))))


def revision_of(state: State, margins: LoopMargins) -> Revision:
    """Return what the margins of a scenario are judged by.

    Parameters
    ----------
    state : State
        As it was opened.
    margins : LoopMargins
        Of its model, taken for the last revision where no baseline is stored.

    Raises
    ------
    CheckError
        For a check file or a baseline beside the scenario that cannot be used.
    """
    numbers = loop_numbers(margins)
    checks = _written(state, numbers)
    stored = baseline_beside(state.path)
    if not stored.exists():
        return Revision("as opened", measured_baseline(numbers, None, checks), False, checks)
    known = {number.key for number in numbers}
    kept = {key: one for key, one in load_baseline(stored).numbers.items() if key in known}
    return Revision(stored.name, Baseline(None, None, MappingProxyType(kept)), True, checks)


def judged(margins: Margins, revision: Revision) -> list[dict[str, Any]]:
    """Return a row for each margin: value, error bar, worst, place, what was, what may be."""
    before = revision.before if revision.stored else None
    rows = {row.key[-1]: row for row in compare(numbers_of(margins), before, revision.checks)}
    was = {key[-1]: one.value for key, one in revision.before.numbers.items()}
    found = []
    for name, label, unit, place in _ROWS:
        row = rows.get(name)
        value = getattr(margins, name)
        found.append(
            {
                "name": name,
                "label": label,
                "unit": unit,
                "value": finite_or_none(value),
                "shown": _shown(margins, name),
                "worst": finite_or_none(getattr(margins, f"{name}_worst", nan)),
                "at_hz": finite_or_none(getattr(margins, place) if place else nan),
                "was": _short(was.get(name)),
                "allowed": "" if row is None else _allowed(revision, row.key),
                "verdict": "unmeasured" if row is None or row.now is None else row.verdict,
                "fails": row is not None and row.now is not None and row.verdict in FAILURES,
            }
        )
    return found


def numbers_of(margins: Margins) -> tuple[Number, ...]:
    """Return the margins as the gate has them."""
    if isinstance(margins, MeasuredMargins):
        return measured_numbers(margins)
    return loop_numbers(margins)


def bound_of(revision: Revision, name: str) -> tuple[float, float]:
    """Return the least and the largest value that a margin may have."""
    asked = revision.checks.of(("margins", name))
    return asked.least, asked.most


def finite_or_none(value: float) -> float | None:
    """Return a number as JSON has it: None where it is not finite."""
    return float(value) if isfinite(value) else None


def _shown(margins: Margins, name: str) -> str:
    value, sigma = getattr(margins, name), getattr(margins, f"{name}_sigma", nan)
    text = f"{value:.4g}" if isfinite(value) else "none"
    return f"{text} ± {sigma:.2g}" if isfinite(sigma) else text


def _short(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if isfinite(value) else "none"


def _allowed(revision: Revision, key: Key) -> str:
    least, most = bound_of(revision, key[-1])
    if least == -inf:
        return "" if most == inf else f"≤ {most:.4g}"
    return f"≥ {least:.4g}" if most == inf else f"{least:.4g} to {most:.4g}"


def _written(state: State, numbers: tuple[Number, ...]) -> Checks:
    """Return what the check file beside a scenario asks of margins."""
    path = checks_beside(state.path)
    if not path.exists():
        return Checks()
    names = {number.key[-1] for number in numbers}
    content = read_check_file(path)
    own = {key: value for key, value in content.items() if key in names or key == "margins"}
    return checks_of(path, own, numbers)


def _of_margins(
    requirements: tuple[Requirement, ...],
) -> Iterator[tuple[Key, tuple[float, float]]]:
    for requirement in requirements:
        for name, *_ in _ROWS:
            if name.rpartition("_")[0] == requirement.name or name == requirement.name:
                yield ("margins", name), requirement.bounds
