"""The margins of a measured loop as labelled numbers with error bars and worst cases."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite, isnan, nan
from typing import Any

from ...shaping.frozen import Frozen
from ...shaping.told import Told

BARRED = (
    "crossover_hz",
    "phase_margin_deg",
    "delay_margin_s",
    "lower_gain_margin_db",
    "upper_gain_margin_db",
    "modulus_margin",
    "disk_margin",
    "sensitivity_peak",
    "complementary_peak",
    "bandwidth_hz",
)
"""The margins that have a standard deviation, `<name>_sigma`."""


@dataclass(frozen=True, repr=False)
class MeasuredMargins(Told, Frozen):
    """Margins of a loop as far as it was measured: nothing is extrapolated.

    Names and units are those of `LoopMargins`. A margin that the data cannot give is nan, never
    inf: none may be there, or it lies where no line is; `warnings` says which. `…_sigma` is the
    standard deviation of a margin, `…_worst` what it is at the worst within circles around L that
    hold it with a probability of 95 %, each point for itself. An unstable loop has no margins;
    where stability cannot be told they are those of the lines there are.

    Attributes
    ----------
    stable : bool or None
        None: cannot be told, `reasons` say why.
    reasons : tuple of str
        Of the verdict.
    warnings : tuple of str
        What else a reader has to know: margins that were not measured, resonances narrower than
        the lines, gaps, what was taken for granted.
    crossovers_hz, crossovers_hz_sigma : tuple of float
        All frequencies with |L| = 1, ascending, one for each cluster of lines that noise puts on
        it.
    phase_crossovers_hz : tuple of float
        Where L is real and negative, but where |L| is below −40 dB or half of it is noise.
    crossover_hz, phase_margin_deg, delay_margin_s, lower_gain_margin_db, … : float
        The margins of `LoopMargins`, with `…_hz` where each is taken.
    dt : float or None
        Sample time.
    """

    stable: bool | None
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]
    crossovers_hz: tuple[float, ...] = ()
    crossovers_hz_sigma: tuple[float, ...] = ()
    phase_crossovers_hz: tuple[float, ...] = ()
    crossover_hz: float = nan
    crossover_hz_sigma: float = nan
    phase_margin_deg: float = nan
    phase_margin_deg_sigma: float = nan
    phase_margin_deg_worst: float = nan
    delay_margin_s: float = nan
    delay_margin_s_sigma: float = nan
    delay_margin_s_worst: float = nan
    delay_margin_hz: float = nan
    lower_gain_margin_db: float = nan
    lower_gain_margin_db_sigma: float = nan
    lower_gain_margin_db_worst: float = nan
    lower_gain_margin_hz: float = nan
    upper_gain_margin_db: float = nan
    upper_gain_margin_db_sigma: float = nan
    upper_gain_margin_db_worst: float = nan
    upper_gain_margin_hz: float = nan
    modulus_margin: float = nan
    modulus_margin_sigma: float = nan
    modulus_margin_worst: float = nan
    modulus_margin_hz: float = nan
    disk_margin: float = nan
    disk_margin_sigma: float = nan
    disk_margin_worst: float = nan
    disk_margin_hz: float = nan
    sensitivity_peak: float = nan
    sensitivity_peak_sigma: float = nan
    sensitivity_peak_worst: float = nan
    sensitivity_peak_hz: float = nan
    complementary_peak: float = nan
    complementary_peak_sigma: float = nan
    complementary_peak_worst: float = nan
    complementary_peak_hz: float = nan
    bandwidth_hz: float = nan
    bandwidth_hz_sigma: float = nan
    dt: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain numbers and lists, ready for JSON; what is not is None."""
        return {field.name: _plain(getattr(self, field.name)) for field in fields(self)}

    def rows(self) -> list[tuple[str, float, float, float, str, float]]:
        """Return (name, value, sigma, worst, unit, frequency in Hz or nan) for a table."""
        return [
            (
                label,
                getattr(self, name),
                getattr(self, f"{name}_sigma"),
                getattr(self, f"{name}_worst", nan),
                unit,
                getattr(self, place) if place else nan,
            )
            for label, name, unit, place in _ROWS
        ]

    def summary(self) -> str:
        """Return verdict, margins with error bars, reasons and warnings as text."""
        lines = [_VERDICTS[self.stable], *(f"  {reason}" for reason in self.reasons)]
        lines += [_line(*row) for row in self.rows() if not isnan(row[1])]
        crossovers = ", ".join(f"{hz:.4g}" for hz in self.crossovers_hz) or "none"
        return "\n".join(
            [
                *lines,
                f"gain crossovers (Hz): {crossovers}",
                *(f"note: {warning}" for warning in self.warnings),
            ]
        )

    def __str__(self) -> str:
        return self.summary()


_VERDICTS = {True: "stable", False: "UNSTABLE", None: "STABILITY CANNOT BE TOLD"}
_ROWS = (
    ("phase margin", "phase_margin_deg", "deg", "crossover_hz"),
    ("lower gain margin", "lower_gain_margin_db", "dB", "lower_gain_margin_hz"),
    ("upper gain margin", "upper_gain_margin_db", "dB", "upper_gain_margin_hz"),
    ("delay margin", "delay_margin_s", "s", "delay_margin_hz"),
    ("modulus margin", "modulus_margin", "", "modulus_margin_hz"),
    ("disk margin", "disk_margin", "", "disk_margin_hz"),
    ("peak of S", "sensitivity_peak", "", "sensitivity_peak_hz"),
    ("peak of T", "complementary_peak", "", "complementary_peak_hz"),
    ("bandwidth", "bandwidth_hz", "Hz", ""),
)


def _line(label: str, value: float, sigma: float, worst: float, unit: str, hz: float) -> str:
    shown = f"{value:.4g} ± {sigma:.2g} {unit}".strip()
    place = "" if isnan(hz) else f" at {hz:.4g} Hz"
    least = "" if isnan(worst) else f", at worst {worst:.4g}"
    return f"{label:<18} {shown:>24}{place}{least}"


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return value
