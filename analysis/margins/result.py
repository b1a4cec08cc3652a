"""The margins of a loop as labelled numbers, as text and as plain data."""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...shaping.frozen import Frozen
from ...shaping.told import Told
from .factored_loop import Complex


@dataclass(frozen=True, eq=False, repr=False)
class LoopMargins(Told, Frozen):
    """Margins of a negative-feedback loop with open-loop transfer L.

    With S = 1/(1 + L) and T = L/(1 + L). A margin that nothing limits is inf and its frequency
    nan. A frequency is 0 or inf where the value is a limit, reached at DC or as ω → ∞; in a
    discrete loop half the sampling frequency takes the place of ∞. An unstable loop has no
    margins: all are nan, while the crossings of L stay listed.

    Attributes
    ----------
    stable : bool
        Whether every closed-loop pole has a damping ratio above 1e-10; of a discrete loop that
        of w = (z − 1)/(z + 1).
    closed_loop_poles : ndarray of complex, shape (n,)
        The slowest decay first, hidden modes included; read-only. In rad/s; of a discrete loop
        as z; of a loop with delay, which has infinitely many, the slowest.
    crossover_hz : float
        Gain crossover where the phase margin is taken.
    crossovers_hz : tuple of float
        All frequencies with |L| = 1, ascending, tangential touches included.
    phase_margin_deg : float
        Smallest angle, in either direction, from L to −1 over all crossovers.
    lower_gain_margin_db, upper_gain_margin_db : float
        How far the gain may fall, and rise, before the loop is unstable; both positive.
    lower_gain_margin_hz, upper_gain_margin_hz : float
        Where L is real and negative at those gains.
    phase_crossovers_hz : tuple of float
        All frequencies where L is finite, real and negative, ascending. With a delay, which
        turns the phase for ever: those that can limit a margin.
    stabilizing_gains : tuple of (float, float)
        Intervals of k > 0, without their ends, ascending, for which k·L is a stable loop; empty
        if there is none. A stable loop has 1 in one of them. Where poles touch the axis and turn
        back, one ends and the next begins.
    stabilizing_delays_s : tuple of (float, float)
        Intervals of added delay in the same way, of the delay that comes on top of that which
        the loop has; a stable loop has one that begins at 0, which is ((0, 0),) where |L| ≥ 1 as
        ω → ∞ lets it stand none at all. Of a discrete loop: whole samples, in seconds, and the
        ends belong to them, as in (0, 3·dt). Beyond 10,000 passages of the axis, or samples,
        nothing is listed.
    delay_margin_s, delay_margin_hz : float
        Smallest added delay that destabilises, and its crossover. The delay is 0 where
        |L| ≥ 1 as ω → ∞. Of a discrete loop: the delay whose phase lag uses up the margin.
    modulus_margin, modulus_margin_hz : float
        min |1 + L|, the distance from −1.
    disk_margin, disk_margin_hz : float
        2·min |(1 + L)/(1 − L)|, the symmetric disk margin (skew 0).
    sensitivity_peak, sensitivity_peak_hz : float
        max |S|.
    complementary_peak, complementary_peak_hz : float
        max |T|.
    bandwidth_hz : float
        Where |T| first falls to |T(0)|/√2; nan if it never does, or if T(0) = 0.
    dt : float or None
        Sampling time of a discrete loop in seconds, None in continuous time.
    """

    stable: bool
    closed_loop_poles: Complex
    crossovers_hz: tuple[float, ...]
    phase_crossovers_hz: tuple[float, ...]
    stabilizing_gains: tuple[tuple[float, float], ...] = ()
    stabilizing_delays_s: tuple[tuple[float, float], ...] = ()
    crossover_hz: float = math.nan
    phase_margin_deg: float = math.nan
    lower_gain_margin_db: float = math.nan
    lower_gain_margin_hz: float = math.nan
    upper_gain_margin_db: float = math.nan
    upper_gain_margin_hz: float = math.nan
    delay_margin_s: float = math.nan
    delay_margin_hz: float = math.nan
    modulus_margin: float = math.nan
    modulus_margin_hz: float = math.nan
    disk_margin: float = math.nan
    disk_margin_hz: float = math.nan
    sensitivity_peak: float = math.nan
    sensitivity_peak_hz: float = math.nan
    complementary_peak: float = math.nan
    complementary_peak_hz: float = math.nan
    bandwidth_hz: float = math.nan
    dt: float | None = None

    def __post_init__(self) -> None:
        """Keep a read-only copy of the poles."""
        poles = np.array(self.closed_loop_poles, dtype=complex)
        poles.setflags(write=False)
        object.__setattr__(self, "closed_loop_poles", poles)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain numbers and lists, ready for JSON.

        inf and nan, which JSON lacks, become None; a pole becomes [real part, imaginary part].
        """
        plain = {field.name: _plain(getattr(self, field.name)) for field in fields(self)}
        poles = self.closed_loop_poles
        return plain | {"closed_loop_poles": [[pole.real, pole.imag] for pole in poles.tolist()]}

    def summary(self) -> str:
        """Return the margins as text, one to a line; an unstable loop names its worst pole."""
        if not self.stable:
            return _unstable_summary(self)
        lines = [*(_line(*row) for row in self.rows()), *_stabilizing_lines(self)]
        return "\n".join(["stable", *lines])

    def rows(self) -> list[tuple[str, float, str, float]]:
        """Return (name, value, unit, frequency in Hz or nan) of each margin, for a table."""
        return [
            ("phase margin", self.phase_margin_deg, "deg", self.crossover_hz),
            ("lower gain margin", self.lower_gain_margin_db, "dB", self.lower_gain_margin_hz),
            ("upper gain margin", self.upper_gain_margin_db, "dB", self.upper_gain_margin_hz),
            ("delay margin", self.delay_margin_s, "s", self.delay_margin_hz),
            ("modulus margin", self.modulus_margin, "", self.modulus_margin_hz),
            ("disk margin", self.disk_margin, "", self.disk_margin_hz),
            ("peak of S", self.sensitivity_peak, "", self.sensitivity_peak_hz),
            ("peak of T", self.complementary_peak, "", self.complementary_peak_hz),
            ("bandwidth", self.bandwidth_hz, "Hz", math.nan),
        ]

    def __str__(self) -> str:
        return self.summary()


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _line(name: str, value: float, unit: str, hz: float) -> str:
    shown = "none" if math.isnan(value) else f"{value:.4g} {unit}".strip()
    place = "" if math.isnan(hz) else " as f → ∞" if math.isinf(hz) else f" at {hz:.4g} Hz"
    return f"{name:<18} {shown:>12}{place}"


def shown_intervals(intervals: tuple[tuple[float, float], ...]) -> str:
    """Return intervals for reading, the first three of many."""
    shown = [
        f"above {low:.4g}"
        if math.isinf(high)
        else f"{low:.4g} to {high:.4g}"
        if high > low
        else f"{low:.4g} only"
        for low, high in intervals[:3]
    ]
    left = len(intervals) - len(shown)
    return ", ".join(shown + [f"{left} more"] * (left > 0)) or "none"


def in_samples(margins: LoopMargins) -> str:
    """Return what a heading adds where added delays are whole samples."""
    return "" if margins.dt is None else ", whole samples"


def _stabilizing_lines(margins: LoopMargins) -> list[str]:
    gains, delays = margins.stabilizing_gains, margins.stabilizing_delays_s
    return [
        f"stable at gain times {shown_intervals(gains)}",
        f"stable with added delay (s{in_samples(margins)}): {shown_intervals(delays)}",
    ]


def _unstable_summary(margins: LoopMargins) -> str:
    crossovers = ", ".join(f"{hz:.4g}" for hz in margins.crossovers_hz) or "none"
    lines = [f"gain crossovers (Hz): {crossovers}", *_stabilizing_lines(margins)]
    return "\n".join([f"UNSTABLE: closed-loop pole at {worst_pole(margins)}", *lines])


def worst_pole(margins: LoopMargins) -> str:
    """Return the slowest closed-loop pole for reading, of a discrete loop as z."""
    pole = complex(margins.closed_loop_poles[0]) + 0.0
    return f"{pole:.4g} rad/s" if margins.dt is None else f"z = {pole:.4g}"
