"""What a log of an encoder shows: peaks, verdicts, error bars, and the table of them."""

from __future__ import annotations

from dataclasses import dataclass
from io import StringIO
from math import inf, isnan
from textwrap import wrap
from typing import TYPE_CHECKING, Literal

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ...shaping import Limits
from ...shaping.derivatives import derivative_name, derivative_number
from ...shaping.drawing import draw
from .bands import OVERSHOOT, Band

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table


MEASURED = 3
"""Highest derivative that is taken from a log."""

Verdict = Literal["kept", "broken", "cannot tell", "no limit"]


@dataclass(frozen=True)
class Peak:
    """The largest value of a derivative in one direction, or in both.

    Attributes
    ----------
    derivative : int
    direction : int
        1 forward, −1 backward (the value is then that of −x^(k)), 0 whichever is larger.
    used : float
        Peak of the fit, not negative.
    least, most : float
        Between these the true peak lies with probability 0.95: largest lower, and largest upper
        end of the error bars. `most` is infinite where the log is too coarse to exclude a higher
        peak, or the derivative cannot be measured.
    time : float
        When the peak of the fit is reached.
    limit : float
        Bound in this direction; infinite where there is none.
    tolerance : float
        Excess over the limit that still keeps it, relative.
    """

    derivative: int
    direction: int
    used: float
    least: float
    most: float
    time: float
    limit: float
    tolerance: float

    @property
    def name(self) -> str:
        """Name of the derivative, with its sign if it has only one."""
        return derivative_name(self.derivative) + ("", " +", " −")[self.direction]

    @property
    def verdict(self) -> Verdict:
        """Whether all, none or some of the error bar keeps the limit."""
        allowed = self.limit * (1.0 + self.tolerance)
        if allowed == inf:
            return "no limit"
        if self.most <= allowed:
            return "kept"
        return "broken" if self.least > allowed else "cannot tell"


@dataclass(frozen=True, eq=False)
class Conformance:
    """What a log says of the limits.

    Attributes
    ----------
    peaks : tuple of Peak
        One per derivative where the limit is the same in both directions, else two.
    bands : tuple of Band
        Velocity, acceleration and jerk over time, with error bars.
    limits : Limits
    readings : int
        Length of the log.
    left_out : int
        Readings in parts too short to check, or at rest without a known resolution.
    resolution : float
        Of the encoder, given or found in the log; zero where unknown.
    noise : float
        Standard deviation of a reading, in the noisiest part of the log.
    longest_gap : float
        Longest time from one reading to the next.
    resolved_time : float
        Shortest pulse of velocity, acceleration or jerk that the fit shows to 90 %: a shorter
        excess may not be seen.
    """

    peaks: tuple[Peak, ...]
    bands: tuple[Band, ...]
    limits: Limits
    readings: int
    left_out: int
    resolution: float
    noise: float
    longest_gap: float
    resolved_time: float

    @property
    def kept(self) -> bool | None:
        """True if every limit was kept, False if one was broken, None if one cannot tell."""
        verdicts = {peak.verdict for peak in self.peaks}
        if "broken" in verdicts:
            return False
        return None if "cannot tell" in verdicts else True

    def band(self, derivative: int | str) -> Band:
        """Return velocity, acceleration or jerk over time, given by number or name."""
        k = derivative_number(derivative)
        if not 1 <= k <= MEASURED:
            raise ValueError(f"derivative {derivative!r}: expected velocity, acceleration or jerk")
        return self.bands[k - 1]

    def table(self) -> Table:
        """Return the peaks, error bars and verdicts as a table for the terminal."""
        return conformance_table(self)

    def plot(self, *, unit: str = "", time_unit: str = "s") -> Figure:
        """Return the picture: each derivative with its error bars and limits."""
        drawn: Figure = draw(self, unit=unit, time_unit=time_unit)
        return drawn

    def __str__(self) -> str:
        return conformance_text(self)

    def __repr__(self) -> str:
        verdicts = ", ".join(f"{peak.name}: {peak.verdict}" for peak in self.peaks)
        return f"Conformance(readings={self.readings}, {verdicts})"


_COLUMNS = ("", "peak used", "error bar", "of noise", "of smoothing", "limit", "verdict")
_COLOURS = {"kept": "green", "broken": "red", "cannot tell": "yellow", "no limit": "dim"}
_WIDTH = 100


def conformance_table(result: Conformance) -> Table:
    """Return peaks, error bars, limits and verdicts.

    "Of noise" and "of smoothing" are the half-widths of the error bar at the peak; the error bar
    itself goes from the largest lower end to the largest upper end at any time.
    """
    title = Text(f"Conformance of {result.readings} readings")
    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for i, column in enumerate(_COLUMNS):
        table.add_column(Text(column), justify="right" if i else "left", overflow="fold")
    for peak in result.peaks:
        limit = "none" if peak.limit == inf else f"{peak.limit:.6g}"
        verdict = Text(peak.verdict, _COLOURS[peak.verdict])
        table.add_row(peak.name, *_measured(result, peak), limit, verdict)
    return table


def conformance_text(result: Conformance) -> str:
    """Return the table and the notes as plain text."""
    page = StringIO()
    Console(file=page, width=_WIDTH, color_system=None).print(conformance_table(result))
    lines = [line.rstrip() for line in page.getvalue().splitlines()]
    for note in conformance_notes(result):
        lines += wrap(note, _WIDTH)
    return "\n".join(lines).strip("\n")


def conformance_notes(result: Conformance) -> list[str]:
    """Return sentences on noise, on what is too short to be seen, and on jerk."""
    known = f", resolution {result.resolution:.4g}" if result.resolution else ""
    notes = [
        f"Noise of a reading {result.noise:.3g}{known}; an excess that lasts a time "
        f"of less than {result.resolved_time:.3g} may not be seen.",
        *_hidden_note(result),
        _jerk_note(result),
    ]
    if len(result.bands[0].starts) > 1 or result.left_out:
        short = f", nor of {result.left_out} readings in parts too short or at rest"
        notes.append(
            f"Pauses of up to {result.longest_gap:.3g} part the log: nothing is said of what "
            f"happened meanwhile{short if result.left_out else ''}."
        )
    elif result.longest_gap > result.resolved_time:
        notes.append(
            f"Up to {result.longest_gap:.3g} go by without a reading: what happened meanwhile may "
            "not be seen."
        )
    tolerance = result.peaks[0].tolerance
    if tolerance:
        notes.append(f"A limit counts as kept up to {100.0 * tolerance:.3g} % above it.")
    if any(isnan(peak.used) for peak in result.peaks):
        notes.append("Snap and above cannot be taken from a log: leave their limits out.")
    return notes


def _hidden_note(result: Conformance) -> list[str]:
    measured = [peak for peak in result.peaks if not isnan(peak.used)]
    hidden = dict.fromkeys(peak.derivative for peak in measured if peak.most == inf)
    if not hidden:
        return []
    names = ", ".join(map(derivative_name, hidden))
    return [
        f"No upper end can be given for {names}: the derivative below could have changed by its "
        "whole peak in less than that time."
    ]


def _jerk_note(result: Conformance) -> str:
    band = result.band("jerk")
    peak, noise = float(np.abs(band.values).max()), float(np.median(band.noise))
    part = f"±{100.0 * noise / peak:.2g} % of the peak used" if peak else f"±{noise:.3g}"
    return (
        f"Jerk is unreliable: noise alone makes {part} (an error of the readings becomes "
        f"{band.amplification:.2g} times as much jerk), and beside a jump the fit overshoots by "
        f"{100.0 * OVERSHOOT:.2g} % of it."
    )


def _measured(result: Conformance, peak: Peak) -> tuple[str, str, str, str]:
    if isnan(peak.used):
        return "—", "—", "—", "—"
    band = result.band(peak.derivative)
    at = int(np.searchsorted(band.times, peak.time))
    above = "∞" if peak.most == inf else f"{peak.most - peak.used:.2g}"
    return (
        f"{peak.used:.5g}",
        f"−{peak.used - peak.least:.2g} +{above}",
        f"±{band.noise[at]:.2g}",
        f"±{band.smoothing[at]:.2g}",
    )
