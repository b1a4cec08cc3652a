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

_TURN = 0.35  # rad or nepers, of L and of 1 + L, from one point to the next
_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """L = fitted·C at any frequency between the first and the last line."""

    fits: LocalFits
    controller: ControllerValues

    def value(self, frequency_hz: Real) -> Complex:
        """Return L alone."""
        return np.asarray(self.fits.value(frequency_hz) * self.controller.at(frequency_hz))

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
    """Return the grid of a loop, fine enough for other controllers on the same plant, too.

    What does not depend on the controllers is found once for each response, `LocalFits.among`.
    """
    fits = parts.fitted.fits
    controllers = [parts.controller, *others]
    low, high = fits.lines[[0, -1]]
    narrow = np.unique(np.concatenate([c.places(low, high) for c in controllers]))
    frequency, inner = _with(fits, *fits.among, narrow[~fits.in_hole(narrow)])
    values = [c.at(frequency) for c in controllers]
    for _ in range(_ROUNDS):
        coarse = np.any([_coarse(inner.value * c) for c in values], axis=0)
        middle = (0.5 * (frequency[:-1] + frequency[1:]))[coarse & _joined(fits, frequency)]
        if not middle.size:
            break
        at = np.searchsorted(frequency, middle)
        values = [
            np.insert(c, at, own.at(middle)) for c, own in zip(values, controllers, strict=True)
        ]
        frequency, inner = _with(fits, frequency, inner, middle)
    return LoopGrid(
        MeasuredLoop(fits, parts.controller),
        frequency,
        inner.value * values[0],
        inner.sigma * abs(values[0]),
        _joined(fits, frequency),
    )


def _with(fits: LocalFits, frequency: Real, inner: Place, more: Real) -> tuple[Real, Place]:
    """Return a grid and the response on it with more points, ascending, put in."""
    more = more[~np.isin(more, frequency)]
    at, found = np.searchsorted(frequency, more), fits.at(more)
    whole = (np.insert(own, at, new) for own, new in zip(inner, found, strict=True))
    return np.insert(frequency, at, more), Place(*whole)


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
