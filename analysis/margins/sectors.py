"""Peaks of S, T and their like over all frequencies, found by bounds.

Between the places where gain and phase turn both are monotone, so that over any interval of
frequency L stays within a sector of a ring, given by its values at the two ends. A bound of |S| or
|T| over that sector holds over the interval: intervals whose bound does not reach the largest
value found are dropped, the others are halved. Nothing is lost between the points of a grid.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from .crossings import last_frequency, phase_points, stationary_points
from .factored_loop import HIGHEST, LOWEST, FactoredLoop, Real

Mask = npt.NDArray[np.bool_]
Bound = Callable[[Real, Real, Real], Real]
"""Largest value over sectors: least and largest ln |L|, least cos²(φ/2) of its phase φ."""

_ROUNDING = 1e-13
_LARGEST = 300.0  # nepers: twice that exp would not give
_NARROW = 1e-3  # nepers and radians
_CLOSE = 1e-9
_SPAN = 1e-4


def sensitivity(low: Real, high: Real, square: Real) -> Real:
    """Return the largest |1/(1 + L)|, with |1 + L|² = (1 − |L|)² + 4·|L|·cos²(φ/2)."""
    with np.errstate(divide="ignore"):
        nearest = np.clip(np.log(np.maximum(1.0 - 2.0 * square, 0.0)), low, high)
    distance = np.expm1(nearest) ** 2 + 4.0 * np.exp(nearest) * square
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / np.sqrt(distance))


def complementary(low: Real, high: Real, square: Real) -> Real:
    """Return the largest |L/(1 + L)|, which is |1/(1 + 1/L)|."""
    return sensitivity(-high, -low, square)


def disk(low: Real, high: Real, square: Real) -> Real:
    """Return the largest |(1 − L)/(1 + L)|, with sinh²(ln |L|/2) for |L|."""
    ends = np.sinh(0.5 * np.array([low, high])) ** 2
    nearest = np.where((low < 0.0) & (high > 0.0), 0.0, ends.min(axis=0))
    with np.errstate(divide="ignore"):
        ratios = [(x + (1.0 - square)) / (x + square) for x in (nearest, ends.max(axis=0))]
    return np.asarray(np.sqrt(np.maximum(*ratios)))


def peak(loop: FactoredLoop, bound: Bound) -> tuple[float, float]:
    """Return the largest value over all ω, and where.

    Parameters
    ----------
    loop : FactoredLoop
        Stable.
    bound : callable
        `sensitivity`, `complementary` or `disk`.
    """
    edges = _edges(loop)
    low, high = edges[:-1], edges[1:]
    best, place = _limit(loop, bound)
    narrow = [np.empty((2, 0))]
    while low.size:
        places = np.concatenate([low, high])
        values = sizes(loop, bound, places)
        if values.max() > best * (1.0 + _ROUNDING):
            best, place = float(values.max()), float(places[values.argmax()])
        reaching = _over(loop, bound, low, high) > best * (1.0 + _ROUNDING)
        wide = _is_wide(loop, low, high)
        narrow.append(np.array([low, high])[:, reaching & ~wide])
        low, high = low[reaching & wide], high[reaching & wide]
        middle = np.sqrt(low) * np.sqrt(high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    for start in [*_highest_of_runs(loop, bound, *np.concatenate(narrow, axis=1)), place]:
        found, at = climbed(loop, bound, start)
        if found > best:
            best, place = found, at
    return best, place


def _is_wide(loop: FactoredLoop, low: Real, high: Real) -> Mask:
    """Whether L covers more of a sector than a single maximum needs."""
    gain = abs(_log_gain(loop, high) - _log_gain(loop, low))
    turn = abs(loop.phase(high) - loop.phase(low))
    return np.asarray((gain + turn > _NARROW) & (high > low * (1.0 + 1e-14)))


def _highest_of_runs(loop: FactoredLoop, bound: Bound, low: Real, high: Real) -> list[float]:
    """Return the best of the places in each run of intervals that join."""
    order = np.argsort(low)
    low, high = low[order], high[order]
    values = sizes(loop, bound, low)
    starts = np.flatnonzero(np.append(True, low[1:] > high[:-1] * (1.0 + 1e-14)))
    runs = np.split(np.arange(low.size), starts[1:])
    return [float(low[run[values[run].argmax()]]) for run in runs if run.size]


def first_below(loop: FactoredLoop, level: float) -> float:
    """Return the lowest ω at which |T| falls through a level that it starts above, or inf."""
    from scipy.optimize import brentq

    def excess(log: float) -> float:
        return float(sizes(loop, complementary, np.exp([log]))[0]) - level

    edges = _edges(loop)
    waiting = list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))[::-1]
    while waiting:
        low, high = waiting.pop()
        if _under(loop, np.array([low]), np.array([high]))[0] > level:
            continue
        ends = np.log([low, high])
        if high > low * (1.0 + _SPAN):
            middle = float(np.exp(ends.mean()))
            waiting += [(middle, high), (low, middle)]
        elif excess(ends[0]) > 0.0 >= excess(ends[1]):
            return float(np.exp(brentq(excess, *ends, xtol=1e-16, rtol=1e-15)))
    return np.inf


def _edges(loop: FactoredLoop) -> Real:
    end = last_frequency(loop) if loop.delay else HIGHEST
    points = np.concatenate([stationary_points(loop.zeros, loop.poles), phase_points(loop)])
    return np.unique(np.concatenate([[LOWEST], points[points < end], [end]]))


def _limit(loop: FactoredLoop, bound: Bound) -> tuple[float, float]:
    """Return the upper limit as ω → ∞; with a delay the phase comes by −π again and again."""
    end = np.array([HIGHEST])
    gain = _log_gain(loop, end)
    limit = bound(gain, gain, np.zeros(1)) if loop.delay else sizes(loop, bound, end)
    return float(limit[0]), HIGHEST


def _log_gain(loop: FactoredLoop, omega: Real) -> Real:
    return np.clip(loop.log_gain(omega), -_LARGEST, _LARGEST)


def sizes(loop: FactoredLoop, bound: Bound, omega: Real) -> Real:
    """Return the value itself at frequencies."""
    gain = _log_gain(loop, omega)
    return bound(gain, gain, np.cos(0.5 * loop.phase(omega)) ** 2)


def _over(loop: FactoredLoop, bound: Bound, low: Real, high: Real) -> Real:
    """Return a bound over each interval."""
    gains = np.sort([_log_gain(loop, low), _log_gain(loop, high)], axis=0)
    halves = 0.5 * np.sort([loop.phase(low), loop.phase(high)], axis=0)
    # The half phase passes an odd multiple of π/2, or its ends are the nearest to one.
    passed = np.floor(halves[1] / np.pi - 0.5) > np.floor(halves[0] / np.pi - 0.5)
    square = np.where(passed, 0.0, (np.cos(halves) ** 2).min(axis=0))
    return bound(gains[0], gains[1], square)


def _under(loop: FactoredLoop, low: Real, high: Real) -> Real:
    """Return a bound from below of |T| over each interval."""
    gains = np.array([_log_gain(loop, low), _log_gain(loop, high)])
    halves = 0.5 * np.sort([loop.phase(low), loop.phase(high)], axis=0)
    passed = np.floor(halves[1] / np.pi) > np.floor(halves[0] / np.pi)
    square = np.where(passed, 1.0, (np.cos(halves) ** 2).max(axis=0))
    return np.asarray(complementary(gains, gains, square).min(axis=0))


def climbed(loop: FactoredLoop, bound: Bound, start: float) -> tuple[float, float]:
    """Return the maximum beside a place, and where; nothing of the limits."""
    from scipy.optimize import minimize_scalar

    if start in (LOWEST, HIGHEST):
        return 0.0, start

    def depth(log: float) -> float:
        return -float(sizes(loop, bound, np.exp([log]))[0])

    sides = [np.log(start) + side * _descent(depth, np.log(start), side) for side in (-1.0, 1.0)]
    found = minimize_scalar(depth, bounds=sides, method="bounded", options={"xatol": 1e-13})
    return float(-found.fun), float(np.exp(found.x))


def _descent(depth: Callable[[float], float], start: float, side: float) -> float:
    """Return how far from a place its value has begun to fall."""
    reach = _CLOSE
    while depth(start + side * reach) < depth(start) and reach < 1.0:
        reach *= 2.0
    return reach
