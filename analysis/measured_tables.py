"""What was measured of a loop as text: margins with error bars."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING

from .tables import plain_table

if TYPE_CHECKING:
    from rich.table import Table

    from .measured import MeasuredMargins, MeasuredResponse


def margins_report(measured: MeasuredResponse, margins: MeasuredMargins) -> list[Table | str]:
    """Return a table of margins with error bars, crossovers, the verdict with reasons, notes."""
    table = plain_table(repr(measured), "margin", "value", "sigma", "at worst", "at [Hz]")
    for name, value, sigma, worst, unit, place in margins.rows():
        cells = (_shown(number) for number in (value, sigma, worst, place))
        table.add_row(f"{name} [{unit}]" if unit else name, *cells)
    crossovers = [
        f"{hz:.5g} ± {sigma:.2g}"
        for hz, sigma in zip(margins.crossovers_hz, margins.crossovers_hz_sigma, strict=True)
    ]
    verdict = {True: "stable", False: "UNSTABLE", None: "STABILITY CANNOT BE TOLD"}
    return [
        table,
        f"gain crossovers [Hz]: {', '.join(crossovers) or 'none'}",
        verdict[margins.stable],
        *(f"  {reason}" for reason in margins.reasons),
    ]


def _shown(value: float) -> str:
    return "–" if isnan(value) else f"{value:.4g}"
