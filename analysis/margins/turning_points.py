"""Where gain and phase of a factored loop turn.

Where the slope of the logarithm of a gain, or of a phase, vanishes on the imaginary axis is a
secular equation in ω²,

    Σ wᵢ/(ω² + rᵢ²) + c = 0,    rᵢ the zeros and poles, c the delay for the phase, else 0,

whose roots, and those on the axis, cut it into pieces on which that quantity is monotone. No
frequency grid is laid, so no narrow peak falls between two points, and no product of polynomials
is expanded.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .factored_loop import Complex, FactoredLoop, Real

TOUCH_TOLERANCE = 1e-12
"""A gain (nepers) or phase (rad) extremum this near a level is said to touch it."""

_WIDE = 1e4
_DECADES = 2.0
_BEYOND = 0.25
_SHARES = np.linspace(0.1, 0.9, 5)


def turning_points(loops: Sequence[FactoredLoop]) -> tuple[list[Real], list[Real]]:
    """Return frequencies of each loop, among them all where its gain turns, and its phase.

    What is found of one loop does not depend on the others.
    """
    equations = [_of_gain(loop.zeros, loop.poles) for loop in loops]
    equations += [
        _of_phase(loop.zeros, loop.poles, loop.delay, (loop.samples, loop.scale)) for loop in loops
    ]
    found = _turning_points(equations)
    return found[: len(loops)], found[len(loops) :]


def stationary_points(zeros: Complex, poles: Complex) -> Real:
    """Return frequencies, among them all where ln |Π(jω − z)/Π(jω − p)| turns."""
    return _turning_points([_of_gain(zeros, poles)])[0]


def phase_points(
    zeros: Complex, poles: Complex, delay: float, samples: tuple[int, float] = (0, 1.0)
) -> Real:
    """Return frequencies, among them all where the phase of Π(s − z)/Π(s − p)·e^(−s·delay) turns.

    With `samples` (m, scale) there is a factor ((1 − s·scale)/(1 + s·scale))^m too: m poles at
    −1/scale and as many zeros at 1/scale, which weigh alike.
    """
    return _turning_points([_of_phase(zeros, poles, delay, samples)])[0]


class _Equation(NamedTuple):
    """Σ wᵢ/(x − xᵢ) + c = 0: real places, then those above the real axis for their pairs.

    `edges` are the decades of x that have a pivot each, none where there is nothing to find.
    `roots` are those of the loop.
    """

    places: Complex
    weights: Complex
    constant: float
    edges: Real
    roots: Complex

    @property
    def kind(self) -> tuple[int, ...]:
        """What equations that are solved together have in common."""
        pairs = int(np.count_nonzero(self.places.imag))
        return self.places.size, pairs, self.edges.size


def _of_gain(zeros: Complex, poles: Complex) -> _Equation:
    roots, signs = _signed(zeros, poles)
    return _equation(roots, signs.astype(complex), 0.0)


def _of_phase(
    zeros: Complex, poles: Complex, delay: float, samples: tuple[int, float]
) -> _Equation:
    roots, signs = _signed(zeros, poles)
    count, scale = samples
    if count:
        roots, signs = np.append(roots, 1.0 / scale), np.append(signs, 2.0 * count)
    return _equation(roots, signs * roots, delay)


def _signed(zeros: Complex, poles: Complex) -> tuple[Complex, Real]:
    return np.concatenate([zeros, poles]), np.repeat([1.0, -1.0], [zeros.size, poles.size])


def _equation(roots: Complex, weights: Complex, constant: float) -> _Equation:
    places = -(roots**2)
    scales = abs(places)
    if constant:
        scales = np.append(scales, abs(weights).sum() / constant)
    sizes = np.log10(scales[scales != 0])
    edges = np.empty(0)
    if scales.size > 1 and sizes.size:
        low, high = sizes.min(), sizes.max()
        count = 1 + int((high - low) / _DECADES)
        edges = np.linspace(low - _BEYOND, high + _BEYOND, count + 1)
    return _Equation(*_real_and_upper(places, weights), constant, edges, roots)


def _real_and_upper(places: Complex, weights: Complex) -> tuple[Complex, Complex]:
    """Return real places, each once, then the upper ones of pairs, weighed for both of a pair."""
    on_axis, above = places.imag == 0.0, places.imag > 0.0
    real, which = np.unique(places[on_axis].real, return_inverse=True)
    total = np.bincount(which, weights[on_axis].real, len(real))
    counts = total != 0.0
    places = np.concatenate([real[counts], places[above]])
    return places, np.concatenate([total[counts], 2.0 * weights[above]])


def _turning_points(equations: Sequence[_Equation]) -> list[Real]:
    kinds: dict[tuple[int, ...], list[int]] = {}
    for k, each in enumerate(equations):
        kinds.setdefault(each.kind, []).append(k)
    found = [np.empty(0)] * len(equations)
    for (_, pairs, edges), members in kinds.items():
        if edges:
            for k, x in zip(members, _secular([equations[k] for k in members], pairs), strict=True):
                found[k] = x
    return [_with_gaps(each.roots, x) for each, x in zip(equations, found, strict=True)]


def _with_gaps(roots: Complex, squares: Real) -> Real:
    # Across gaps too wide for eigenvalues to keep digits on both sides, any point within will do.
    sizes = np.unique(abs(roots[roots != 0]))
    wide = sizes[1:] > _WIDE * sizes[:-1]
    return np.unique(np.concatenate([np.sqrt(squares), np.sqrt(sizes[1:] * sizes[:-1])[wide]]))


def _secular(equations: Sequence[_Equation], pairs: int) -> list[Real]:
    """Return the positive roots x of equations of one kind.

    With y = 1/(x − q) they are eigenvalues of a diagonal matrix less one of rank one. These are
    accurate for x near the pivot q, so there is a pivot for every few decades of the places.
    """
    places, weights, constant, edges = (
        np.array([each[k] for each in equations]) for k in range(len(_Equation._fields) - 1)
    )
    weights, constant = weights[..., None], constant[:, None]
    with np.errstate(all="ignore"):
        x = _pivoted(places, weights, constant, _pivots(places, edges), pairs)
        for _ in range(3):
            near = 1 / (x[..., None] - places[:, None])
            slope = (near**2 @ weights)[..., 0].real
            step = ((near @ weights)[..., 0].real + constant) / slope
            x = x + step
        # Newton's step stays large beside roots at infinity and poles at the origin.
        good = (x > 0) & np.isfinite(x) & (abs(step) <= 1e-3 * x)
    return [_distinct(row[kept]) for row, kept in zip(x, good, strict=True)]


def _distinct(x: Real) -> Real:
    x = np.sort(x)
    return x[np.diff(x, prepend=0.0) > 1e-9 * x]


def _pivots(places: Complex, edges: Real) -> Real:
    """Return negative numbers, one of a size between two edges, far from all places, (K, P)."""
    sizes = edges[:, :-1, None] + np.diff(edges)[..., None] * _SHARES
    tried = -(10**sizes)
    ratios = places[:, None, None] / tried[..., None]
    apart = abs(ratios - 1.0).min(axis=3, initial=np.inf)
    return np.take_along_axis(tried, apart.argmax(axis=2)[..., None], axis=2)[..., 0]


def _pivoted(places: Complex, weights: Any, constant: Any, pivots: Real, pairs: int) -> Real:
    """Return q + 1/y for all eigenvalues y of all pivots; a pair of places is a block of two rows.

    Of d ± j·b it is [[d, b], [−b, d]], and of the matrix of rank one it has a single row.
    """
    inverse = 1 / (places[:, None] - pivots[..., None])
    total = (inverse @ weights)[..., 0].real - constant
    none = total == 0.0
    total[none] = 1.0
    pull = weights.transpose(0, 2, 1) * inverse**2 / total[..., None]
    count = places.shape[1]
    size, first = count + pairs, count - pairs
    upper, lower = first + np.arange(pairs), count + np.arange(pairs)
    row = np.concatenate([pull.real, pull.imag[..., first:]], axis=2)
    whole = np.concatenate([inverse.real, inverse.real[..., first:]], axis=2)
    matrices = np.zeros((*pivots.shape, size, size))
    matrices[..., :count, :] = -row[..., None, :]
    matrices[..., np.arange(size), np.arange(size)] += whole
    matrices[..., upper, lower] += inverse.imag[..., first:]
    matrices[..., lower, upper] -= inverse.imag[..., first:]
    found = (pivots[..., None] + 1 / np.linalg.eigvals(matrices)).real
    found[none] = np.nan
    return np.asarray(found.reshape(len(places), -1))
