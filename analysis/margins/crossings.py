"""Where gain and phase of a factored loop turn, and where they cross a level.

Where the slope of the logarithm of a gain, or of a phase, vanishes on the imaginary axis is a
secular equation in ω²,

    Σ wᵢ/(ω² + rᵢ²) = 0,    rᵢ the zeros and poles,

whose roots cut the axis into pieces on which that quantity is monotone. Each piece is then
searched for the one crossing it can hold, on L(jω) itself. No frequency grid is laid, so no
narrow peak falls between two points, and no product of polynomials is expanded.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from .factored_loop import HIGHEST, LOWEST, UNBOUNDED, Complex, FactoredLoop, Real

TOUCH_TOLERANCE = 1e-12
"""A gain (nepers) or phase (rad) extremum this near a level is said to touch it."""

Function = Callable[[Real], Real]

_BESIDE = 1e-9
_WIDE = 1e4
_DECADES = 2.0


def stationary_points(zeros: Complex, poles: Complex, *, of_phase: bool = False) -> Real:
    """Return frequencies, among them all where ln |Π(jω − z)/Π(jω − p)| or its phase turns."""
    roots = np.concatenate([zeros, poles])
    signs = np.repeat([1.0, -1.0], [zeros.size, poles.size])
    squares = _secular_roots(-(roots**2), signs * roots if of_phase else signs.astype(complex))
    # Across gaps too wide for eigenvalues to keep digits on both sides, any point within will do.
    sizes = np.unique(abs(roots[roots != 0]))
    wide = sizes[1:] > _WIDE * sizes[:-1]
    return np.unique(np.concatenate([np.sqrt(squares), np.sqrt(sizes[1:] * sizes[:-1])[wide]]))


def gain_crossings(loop: FactoredLoop) -> list[float]:
    """Return all ω with |L(jω)| = 1, the limits included."""
    return level_crossings(loop.log_gain, stationary_points(loop.zeros, loop.poles))


def phase_crossings(loop: FactoredLoop) -> list[float]:
    """Return all ω where L(jω) is finite, nonzero, real and negative, the limits included."""
    axis = np.concatenate([loop.zeros, loop.poles])
    axis = axis[(axis.real == 0) & (axis.imag > 0)].imag
    points = stationary_points(loop.zeros, loop.poles, of_phase=True)
    points = np.unique(np.concatenate([points, axis * (1 - _BESIDE), axis * (1 + _BESIDE)]))
    phases = loop.phase(np.concatenate([[LOWEST], points, [HIGHEST]])) / np.pi
    turns = np.arange(np.floor(phases.min()) - 1, np.ceil(phases.max()) + 2)
    levels = np.pi * turns[turns % 2 == 1]
    found = [
        level_crossings(partial(_phase_above, loop, level), points) for level in levels.tolist()
    ]
    # On a zero or pole on the axis the phase jumps across −π; L is 0 or unbounded there.
    roots = np.sort(np.concatenate([np.empty(0), *found]))
    jumps = np.any(abs(roots[:, None] - axis) <= 2 * _BESIDE * axis, axis=1)
    return list(roots[~jumps & (abs(loop.log_gain(roots)) < UNBOUNDED)].tolist())


def _phase_above(loop: FactoredLoop, level: float, omega: Real) -> Real:
    return loop.phase(omega) - level


def level_crossings(function: Function, points: Real) -> list[float]:
    """Return the zeros of a function that is monotone between ascending points, ascending.

    There is one for each change of sign from the lowest to the highest frequency, and one at
    each point or limit where the function touches zero.
    """
    points = np.concatenate([[LOWEST], points, [HIGHEST]])
    logs = np.log(points)
    values = function(np.exp(logs))
    sides = np.sign(values)
    touching = abs(values) <= TOUCH_TOLERANCE
    touching[1:-1] &= sides[:-2] == sides[2:]
    sides[touching] = 0
    changes = np.flatnonzero(sides[:-1] * sides[1:] < 0)
    roots = [_root_between(function, logs[i : i + 2], values[i : i + 2]) for i in changes]
    return sorted(roots + points[sides == 0].tolist())


def _root_between(function: Function, logs: Real, values: Real) -> float:
    from scipy.optimize import brentq

    # The ends keep their signs: evaluated again alone they might round to the other one.
    ends = dict(zip(logs.tolist(), values.tolist(), strict=True))

    def at(log: float) -> float:
        return ends[log] if log in ends else float(function(np.exp([log]))[0])

    return float(np.exp(brentq(at, *ends, xtol=1e-16, rtol=1e-15)))


def _secular_roots(places: Complex, weights: Complex) -> Real:
    """Positive roots x of Σ wᵢ/(x − xᵢ) = 0.

    With y = 1/(x − q) they are eigenvalues of a diagonal matrix less one of rank one. These are
    accurate for x near the pivot q, so there is a pivot for every few decades of the places.
    """
    sizes = np.log10(abs(places[places != 0]))
    if places.size < 2 or not sizes.size:
        return np.empty(0)
    count = 1 + int((sizes.max() - sizes.min()) / _DECADES)
    with np.errstate(all="ignore"):
        starts = [
            _pivoted(places, weights, -np.exp(0.5j) * 10**exponent)
            for exponent in np.linspace(sizes.min(), sizes.max(), 2 * count + 1)[1::2]
        ]
        x = np.concatenate(starts)
        for _ in range(3):
            near = 1 / (x[:, None] - places)
            step = (near @ weights / (near**2 @ weights)).real
            x = x + step
        # Newton's step stays large beside roots at infinity and poles at the origin.
        x = np.sort(x[(x > 0) & (abs(step) <= 1e-3 * x)])
    return x[np.diff(x, prepend=0.0) > 1e-9 * x]


def _pivoted(places: Complex, weights: Complex, pivot: complex) -> Real:
    diagonal = 1 / (places - pivot)
    total = weights @ diagonal
    if total == 0:
        return np.empty(0)
    inverse = np.linalg.eigvals(np.diag(diagonal) - weights * diagonal**2 / total)
    return np.asarray((pivot + 1 / inverse).real)
