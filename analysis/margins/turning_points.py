"""Where gain and phase of a factored loop turn.

Where the slope of the logarithm of a gain, or of a phase, vanishes on the imaginary axis is a
secular equation in ω²,

    Σ wᵢ/(ω² + rᵢ²) + c = 0,    rᵢ the zeros and poles, c the delay for the phase, else 0,

whose roots, and those on the axis, cut it into pieces on which that quantity is monotone. No
frequency grid is laid, so no narrow peak falls between two points, and no product of polynomials
is expanded.
"""

import numpy as np

from .factored_loop import Complex, Real

TOUCH_TOLERANCE = 1e-12
"""A gain (nepers) or phase (rad) extremum this near a level is said to touch it."""

_WIDE = 1e4
_DECADES = 2.0
_BEYOND = 0.25
_SHARES = np.linspace(0.1, 0.9, 5)


def stationary_points(zeros: Complex, poles: Complex) -> Real:
    """Return frequencies, among them all where ln |Π(jω − z)/Π(jω − p)| turns."""
    roots, signs = _signed(zeros, poles)
    return _turning_points(roots, signs.astype(complex), 0.0)


def phase_points(
    zeros: Complex, poles: Complex, delay: float, samples: tuple[int, float] = (0, 1.0)
) -> Real:
    """Return frequencies, among them all where the phase of Π(s − z)/Π(s − p)·e^(−s·delay) turns.

    With `samples` (m, scale) there is a factor ((1 − s·scale)/(1 + s·scale))^m too: m poles at
    −1/scale and as many zeros at 1/scale, which weigh alike.
    """
    roots, signs = _signed(zeros, poles)
    count, scale = samples
    if count:
        roots, signs = np.append(roots, 1.0 / scale), np.append(signs, 2.0 * count)
    return _turning_points(roots, signs * roots, delay)


def _signed(zeros: Complex, poles: Complex) -> tuple[Complex, Real]:
    return np.concatenate([zeros, poles]), np.repeat([1.0, -1.0], [zeros.size, poles.size])


def _turning_points(roots: Complex, weights: Complex, constant: float) -> Real:
    squares = _secular_roots(-(roots**2), weights, constant)
    # Across gaps too wide for eigenvalues to keep digits on both sides, any point within will do.
    sizes = np.unique(abs(roots[roots != 0]))
    wide = sizes[1:] > _WIDE * sizes[:-1]
    return np.unique(np.concatenate([np.sqrt(squares), np.sqrt(sizes[1:] * sizes[:-1])[wide]]))


def _secular_roots(places: Complex, weights: Complex, constant: float) -> Real:
    """Positive roots x of Σ wᵢ/(x − xᵢ) + c = 0, places and weights in conjugate pairs.

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
    places, weights = _real_and_upper(places, weights)
    with np.errstate(all="ignore"):
        edges = np.linspace(sizes.min() - _BEYOND, sizes.max() + _BEYOND, count + 1)
        x = _pivoted(places, weights, constant, _pivots(places, edges))
        for _ in range(3):
            near = 1 / (x[:, None] - places)
            step = ((near @ weights).real + constant) / ((near**2) @ weights).real
            x = x + step
        # Newton's step stays large beside roots at infinity and poles at the origin.
        x = np.sort(x[(x > 0) & np.isfinite(x) & (abs(step) <= 1e-3 * x)])
    return x[np.diff(x, prepend=0.0) > 1e-9 * x]


def _real_and_upper(places: Complex, weights: Complex) -> tuple[Complex, Complex]:
    """Return real places, each once, then the upper ones of pairs, weighed for both of a pair."""
    on_axis, above = places.imag == 0.0, places.imag > 0.0
    real, which = np.unique(places[on_axis].real, return_inverse=True)
    total = np.bincount(which, weights[on_axis].real, len(real))
    counts = total != 0.0
    places = np.concatenate([real[counts], places[above]])
    return places, np.concatenate([total[counts], 2.0 * weights[above]])


def _pivots(places: Complex, edges: Real) -> Real:
    """Return negative numbers, one of a size between two edges, each far from all places."""
    sizes = edges[:-1, None] + np.diff(edges)[:, None] * _SHARES
    tried = -(10**sizes)
    apart = abs(places / tried[..., None] - 1.0).min(axis=2, initial=np.inf)
    return np.take_along_axis(tried, apart.argmax(axis=1)[:, None], axis=1)[:, 0]


def _pivoted(places: Complex, weights: Complex, constant: float, pivots: Real) -> Real:
    """Return q + 1/y for all eigenvalues y of all pivots; a pair of places is a block of two rows.

    Of d ± j·b it is [[d, b], [−b, d]], and of the matrix of rank one it has a single row.
    """
    inverse = 1 / (places - pivots[:, None])
    total = (inverse @ weights).real - constant
    pivots, inverse, total = (part[total != 0] for part in (pivots, inverse, total))
    pull = weights * inverse**2 / total[:, None]
    pairs = int(np.count_nonzero(places.imag))
    size, first = places.size + pairs, places.size - pairs
    upper, lower = first + np.arange(pairs), places.size + np.arange(pairs)
    row = np.concatenate([pull.real, pull.imag[:, first:]], axis=1)
    matrices = np.zeros((len(pivots), size, size))
    matrices[:, : places.size] = -row[:, None]
    whole = np.concatenate([inverse.real, inverse.real[:, first:]], axis=1)
    matrices[:, np.arange(size), np.arange(size)] += whole
    matrices[:, upper, lower] += inverse.imag[:, first:]
    matrices[:, lower, upper] -= inverse.imag[:, first:]
    found = np.linalg.eigvals(matrices)
    return np.asarray((pivots[:, None] + 1 / found).real.ravel())
