"""Where gain and phase of a factored loop turn, and where they cross a level.

Where the slope of the logarithm of a gain, or of a phase, vanishes on the imaginary axis is a
secular equation in ω²,

    Σ wᵢ/(ω² + rᵢ²) + c = 0,    rᵢ the zeros and poles, c the delay for the phase, else 0,

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


def stationary_points(zeros: Complex, poles: Complex) -> Real:
    """Return frequencies, among them all where ln |Π(jω − z)/Π(jω − p)| turns."""
    return _turning_points(zeros, poles, lambda signs, _: signs.astype(complex), 0.0)


def phase_points(loop: FactoredLoop) -> Real:
    """Return frequencies, among them all where the phase of L turns or jumps; these from beside."""
    axis = _on_axis(loop)
    turning = _turning_points(loop.zeros, loop.poles, np.multiply, loop.delay)
    return np.unique(np.concatenate([turning, axis * (1 - _BESIDE), axis * (1 + _BESIDE)]))


def _on_axis(loop: FactoredLoop) -> Real:
    roots = np.concatenate([loop.zeros, loop.poles])
    return np.asarray(roots[(roots.real == 0) & (roots.imag > 0)].imag)


def _turning_points(
    zeros: Complex, poles: Complex, weigh: Callable[[Real, Complex], Complex], constant: float
) -> Real:
    roots = np.concatenate([zeros, poles])
    signs = np.repeat([1.0, -1.0], [zeros.size, poles.size])
    squares = _secular_roots(-(roots**2), weigh(signs, roots), constant)
    # Across gaps too wide for eigenvalues to keep digits on both sides, any point within will do.
    sizes = np.unique(abs(roots[roots != 0]))
    wide = sizes[1:] > _WIDE * sizes[:-1]
    return np.unique(np.concatenate([np.sqrt(squares), np.sqrt(sizes[1:] * sizes[:-1])[wide]]))


def gain_crossings(loop: FactoredLoop) -> list[float]:
    """Return all ω with |L(jω)| = 1, the limits included."""
    return level_crossings(loop.log_gain, stationary_points(loop.zeros, loop.poles))


def phase_crossings(loop: FactoredLoop) -> list[float]:
    """Return all ω where L(jω) is finite, nonzero, real and negative, the limits included.

    With a delay, which turns the phase for ever: the first and the last of them in each stretch
    where gain and phase are monotone, between which |L| only has values between; and the limit.
    """
    axis, points = _on_axis(loop), phase_points(loop)
    found = _turned_crossings(loop, points) if loop.delay else _all_crossings(loop, points)
    # On a zero or pole on the axis the phase jumps across −π; L is 0 or unbounded there.
    roots = np.sort(found)
    jumps = np.any(abs(roots[:, None] - axis) <= 2 * _BESIDE * axis, axis=1)
    return list(roots[~jumps & (abs(loop.log_gain(roots)) < UNBOUNDED)].tolist())


def _all_crossings(loop: FactoredLoop, points: Real) -> Real:
    phases = loop.phase(np.concatenate([[LOWEST], points, [HIGHEST]])) / np.pi
    turns = np.arange(np.floor(phases.min()) - 1, np.ceil(phases.max()) + 2)
    levels = np.pi * turns[turns % 2 == 1]
    found = [
        level_crossings(partial(_phase_above, loop, level), points) for level in levels.tolist()
    ]
    return np.concatenate([np.empty(0), *found])


def _turned_crossings(loop: FactoredLoop, points: Real) -> Real:
    end = last_frequency(loop)
    turning = np.concatenate([points, stationary_points(loop.zeros, loop.poles)])
    edges = np.unique(np.concatenate([[LOWEST], turning, gain_crossings(loop), [end]]))
    edges = edges[edges <= end]
    phases = loop.phase(edges)
    turns = (phases / np.pi - 1.0) / 2.0  # whole where L is real and negative
    found = [HIGHEST]
    for i in range(edges.size - 1):
        low, high = np.sort(turns[i : i + 2])
        for whole in {np.ceil(low), np.floor(high)}:
            if low <= whole <= high:
                above = partial(_phase_above, loop, np.pi * (2.0 * whole + 1.0))
                logs = np.log(edges[i : i + 2])
                values = np.pi * 2.0 * (turns[i : i + 2] - whole)
                found.append(_root_between(above, logs, values))
    return np.array(found)


def last_frequency(loop: FactoredLoop) -> float:
    """Return ω up to which a loop with delay has to be looked at.

    From somewhere before it on, |L| < 1 goes monotonically to its limit while the phase falls, a
    full turn at the least, so that nothing further is nearer to −1 than what lies before.
    """
    crossovers = [omega for omega in gain_crossings(loop) if omega < HIGHEST]
    turning = np.concatenate(
        [stationary_points(loop.zeros, loop.poles), phase_points(loop), crossovers]
    )
    start = float(turning.max(initial=1e-3 / loop.delay))
    target = loop.phase(np.array([start]))[0] - 2 * np.pi
    end = 2.0 * start
    while loop.phase(np.array([end]))[0] > target:
        end *= 2.0
    return end


def _phase_above(loop: FactoredLoop, level: float, omega: Real) -> Real:
    return loop.phase(omega) - level


def level_crossings(function: Function, points: Real, end: float = HIGHEST) -> list[float]:
    """Return the zeros of a function that is monotone between ascending points, ascending.

    There is one for each change of sign from the lowest frequency to the end, and one at each
    point or limit where the function touches zero.
    """
    points = np.concatenate([[LOWEST], points, [end]])
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


def _secular_roots(places: Complex, weights: Complex, constant: float) -> Real:
    """Positive roots x of Σ wᵢ/(x − xᵢ) + c = 0.

    With y = 1/(x − q) they are eigenvalues of a diagonal matrix less one of rank one. These are
    accurate for x near the pivot q, so there is a pivot for every few decades of the places.
    """
    scales = abs(places)
    if constant:
        scales = np.append(scales, abs(weights).sum() / constant)
    sizes = np.log10(scales[scales != 0])
    if scales.size < 2 or not sizes.size:
        return np.empty(0)
    count = 1 + int((sizes.max() - sizes.min()) / _DECADES)
    with np.errstate(all="ignore"):
        starts = [
            _pivoted(places, weights, constant, -np.exp(0.5j) * 10**exponent)
            for exponent in np.linspace(sizes.min(), sizes.max(), 2 * count + 1)[1::2]
        ]
        x = np.concatenate(starts)
        for _ in range(3):
            near = 1 / (x[:, None] - places)
            step = ((near @ weights + constant) / (near**2 @ weights)).real
            x = x + step
        # Newton's step stays large beside roots at infinity and poles at the origin.
        x = np.sort(x[(x > 0) & np.isfinite(x) & (abs(step) <= 1e-3 * x)])
    return x[np.diff(x, prepend=0.0) > 1e-9 * x]


def _pivoted(places: Complex, weights: Complex, constant: float, pivot: complex) -> Real:
    diagonal = 1 / (places - pivot)
    total = weights @ diagonal - constant
    if total == 0:
        return np.empty(0)
    inverse = np.linalg.eigvals(np.diag(diagonal) - weights * diagonal**2 / total)
    return np.asarray((pivot + 1 / inverse).real)
