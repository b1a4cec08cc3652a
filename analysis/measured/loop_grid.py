"""A measured loop on a grid fine enough that nothing turns far from one point to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .controller_values import ControllerValues
from .conversions import Factored
from .local_fits import LocalFits
from .rational_fits import Complex, Place, Real

_PER_GAP = 8
_TURN = 0.35  # rad or nepers, of L and of 1 + L, from one point to the next
_ROUNDS = 8
_BESIDE = np.sinh(np.linspace(-3.0, 3.0, 13))


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """L = fitted·C at any frequency between the first and the last line."""

    fits: LocalFits
    controller: ControllerValues

    def at(self, frequency_hz: Real) -> Place:
        """Return L, its complex standard deviation and C·dG/df."""
        inner = self.fits.at(frequency_hz)
        c = self.controller.at(frequency_hz)
        return Place(inner.value * c, inner.sigma * abs(c), inner.slope * c)

    def logarithmic_slope(self, frequency_hz: Real) -> Complex:
        """Return d ln L/d ln f: that of the gain, and the phase's in rad as imaginary part."""
        inner = self.fits.at(frequency_hz)
        c = self.controller.at(frequency_hz)
        slopes = inner.slope / inner.value + self.controller.slope(frequency_hz) / c
        return np.asarray(frequency_hz * slopes)


@dataclass(frozen=True, eq=False)
class LoopGrid:
    """Points of a loop, ascending.

    Attributes
    ----------
    loop : MeasuredLoop
    frequency_hz, value, sigma : (M,) arrays
    joined : (M − 1,) array of bool
        Whether what lies between a point and the next was measured: no hole in the lines.
    """

    loop: MeasuredLoop
    frequency_hz: Real
    value: Complex
    sigma: Real
    joined: NDArray[np.bool_]

    @property
    def radius(self) -> Real:
        """Radius of the circle that holds L with a probability of 95 %."""
        return self.sigma * RADIUS


RADIUS = float(np.sqrt(-np.log(0.05)))
"""Of a circle of probability 95 %, in complex standard deviations."""


def loop_grid(parts: Factored, *others: ControllerValues) -> LoopGrid:
    """Return the grid of a loop, fine enough for other controllers on the same plant, too."""
    fits = parts.fitted.fits
    loop = MeasuredLoop(fits, parts.controller)
    lines = fits.lines
    shares = (np.arange(_PER_GAP) + 0.5) / _PER_GAP
    inner = lines[:-1, None] + np.diff(lines)[:, None] * shares
    places = [
        lines[[0, -1]],
        inner[~fits.hole].ravel(),
        *(c.places(lines[0], lines[-1]) for c in (parts.controller, *others)),
        _beside_poles(fits),
    ]
    frequency = np.unique(np.concatenate(places))
    inside = (frequency >= lines[0]) & (frequency <= lines[-1])
    frequency = frequency[inside & ~_in_hole(fits, frequency)]
    return _refined(loop, frequency, [MeasuredLoop(fits, other) for other in others])


def _in_hole(fits: LocalFits, frequency: Real) -> NDArray[np.bool_]:
    gap = fits.gap_of(frequency)
    return np.asarray(fits.hole[gap] & (frequency > fits.lines[gap]) & (frequency < fits.lines[-1]))


def _beside_poles(fits: LocalFits) -> Real:
    """Return places at and beside the poles that lie in the gaps of their fits."""
    poles = fits.curves.poles()
    low, high = fits.lines[:-1, None], fits.lines[1:, None]
    with np.errstate(invalid="ignore"):
        inside = (poles.real > low) & (poles.real < high) & (abs(poles.imag) < high - low)
    some = poles[inside]
    return np.asarray((some.real[:, None] + abs(some.imag)[:, None] * _BESIDE).ravel())


def _refined(loop: MeasuredLoop, frequency: Real, others: list[MeasuredLoop]) -> LoopGrid:
    """Return the grid with points put in where L or 1 + L changes much."""
    value, sigma, _ = loop.at(frequency)
    for _ in range(_ROUNDS):
        coarse = _coarse(value) & _joined(loop.fits, frequency)
        for other in others:
            coarse |= _coarse(other.at(frequency).value)
        if not coarse.any():
            break
        middle = 0.5 * (frequency[:-1] + frequency[1:])[coarse]
        new = loop.at(middle)
        after = np.flatnonzero(coarse) + 1
        frequency = np.insert(frequency, after, middle)
        value, sigma = np.insert(value, after, new.value), np.insert(sigma, after, new.sigma)
    return LoopGrid(loop, frequency, value, sigma, _joined(loop.fits, frequency))


def _coarse(value: Complex) -> NDArray[np.bool_]:
    """Return after which points L turns or grows much where it matters, or 1 + L does."""
    big = np.maximum(abs(value[:-1]), abs(value[1:])) > 0.03
    return np.asarray((_step(value) > _TURN) & big | (_step(1.0 + value) > _TURN))


def _step(value: Complex) -> Any:
    size = np.maximum(abs(value), 1e-300)
    ratio = value[1:] / size[1:] * (value[:-1] / size[:-1]).conj()
    return np.maximum(abs(np.angle(ratio)), abs(np.diff(np.log(size))))


def _joined(fits: LocalFits, frequency: Real) -> NDArray[np.bool_]:
    """Return whether no hole is between a point and the next."""
    holes = fits.lines[:-1][fits.hole]
    low = np.searchsorted(holes, frequency[:-1], side="left")
    high = np.searchsorted(holes, frequency[1:], side="left")
    return np.asarray(low == high)
