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
        exponents = np.linspace(sizes.min(), sizes.max(), 2 * count + 1)[1::2]
        x = _pivoted(places, weights, constant, -np.exp(0.5j) * 10**exponents)
        for _ in range(3):
            near = 1 / (x[:, None] - places)
            step = ((near @ weights + constant) / (near**2 @ weights)).real
            x = x + step
        # Newton's step stays large beside roots at infinity and poles at the origin.
        x = np.sort(x[(x > 0) & np.isfinite(x) & (abs(step) <= 1e-3 * x)])
    return x[np.diff(x, prepend=0.0) > 1e-9 * x]


def _pivoted(places: Complex, weights: Complex, constant: float, pivots: Complex) -> Real:
    diagonal = 1 / (places - pivots[:, None])
    total = diagonal @ weights - constant
    pivots, diagonal, total = (part[total != 0] for part in (pivots, diagonal, total))
    ranks_one = weights * diagonal**2 / total[:, None]
    matrices = np.eye(places.size) * diagonal[:, :, None] - ranks_one[:, None, :]
    inverse = np.linalg.eigvals(matrices)
    return np.asarray((pivots[:, None] + 1 / inverse).real.ravel())
