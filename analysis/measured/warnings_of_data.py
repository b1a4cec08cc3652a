"""What a reader of measured margins has to know: what was not measured, and what is too coarse."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .crossings import Crossings
from .loop_grid import LoopGrid

_POOR = 3.0  # mean square misfit of a fit that does not follow its lines
_MATTERS = 0.1  # |L| below which a resonance decides nothing
_NAMES = {
    "phase_margin_deg": "phase and delay margin",
    "lower_gain_margin_db": "lower gain margin",
    "upper_gain_margin_db": "upper gain margin",
    "modulus_margin": "modulus margin and the peak of S",
    "complementary_peak": "peak of T",
}


def warnings_of(
    grid: LoopGrid, gains: Crossings, phases: Crossings, values: Mapping[str, float]
) -> list[str]:
    """Return one line for each, in the order of importance."""
    return [
        *_not_measured(grid, values),
        *_narrow_resonances(grid),
        *_holes(grid),
        *(f"|L| comes within its error of 1 near {hz:.4g} Hz" for hz in gains.unsure.tolist()),
        *(
            f"arg L comes within its error of −180° near {hz:.4g} Hz"
            for hz in phases.unsure.tolist()[:3]
        ),
        *_poor_fits(grid),
    ]


def _not_measured(grid: LoopGrid, values: Mapping[str, float]) -> list[str]:
    if not values:
        return []
    low, high = grid.frequency_hz[[0, -1]]
    return [
        f"{name}: none was measured from {low:.4g} to {high:.4g} Hz"
        for key, name in _NAMES.items()
        if key not in values
    ]


def _narrow_resonances(grid: LoopGrid) -> list[str]:
    """Return the resonances whose half-power width is less than the distance of the lines."""
    fits = grid.loop.fits
    poles = fits.curves.poles()
    low, high = fits.lines[:-1, None], fits.lines[1:, None]
    with np.errstate(invalid="ignore"):
        width = 2.0 * abs(poles.imag)
        inside = (poles.real >= low) & (poles.real < high) & (width < high - low)
    told: list[str] = []
    for gap, which in np.argwhere(inside).tolist():
        place = float(poles.real[gap, which])
        here = grid.loop.at(np.array([place]))
        lines = fits.lines[gap : gap + 2]
        beside = abs(grid.loop.at(lines).value).max()
        size = abs(here.value[0])
        sure = here.sigma[0] < 0.5 * size
        if sure and size > max(_MATTERS, 1.1 * beside):
            told.append(
                f"resonance near {place:.4g} Hz is narrower than the lines "
                f"({width[gap, which]:.2g} against {lines[1] - lines[0]:.2g} Hz): measure finer"
            )
    return told


def _holes(grid: LoopGrid) -> list[str]:
    lines, hole = grid.loop.fits.lines, np.flatnonzero(grid.loop.fits.hole)
    return [
        f"no line from {lines[at]:.4g} to {lines[at + 1]:.4g} Hz: what lies there is not told"
        for at in hole.tolist()
    ]


def _poor_fits(grid: LoopGrid) -> list[str]:
    """Return where lines scatter more than their error bars allow, and L matters."""
    fits = grid.loop.fits
    middle = 0.5 * (fits.lines[:-1] + fits.lines[1:])[fits.curves.misfit > _POOR]
    poor = middle[abs(grid.loop.value(middle)) > _MATTERS]
    if not poor.size:
        return []
    return [
        f"{poor.size} of {len(fits.hole)} gaps, {poor[0]:.4g} to {poor[-1]:.4g} Hz, have lines off "
        "smooth curves by more than their error bars, which are widened: look for drift, "
        "distortion or too coarse lines"
    ]
