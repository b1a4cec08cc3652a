"""Loops that are discrete in time, brought to a plane whose imaginary axis is the unit circle.

With w = (z − 1)/(z + 1) the unit circle becomes the imaginary axis and its inside the left half
plane, so that everything said of L(s) holds of L(w). On the way stands z − 1, in which integrators
and slow modes, crowded around z = 1, keep their digits.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from .factored_loop import HIGHEST, Complex, FactoredLoop, Real

_ROUNDING = 8 * np.finfo(float).eps
_AT_MINUS_ONE = 1e-13


def around_one(*parts: Any) -> tuple[Real, ...]:
    """Return the coefficients of a system in z, (A, B, C, D) or two polynomials, in z − 1."""
    if len(parts) == 4:
        return (parts[0] - np.eye(len(parts[0])), *parts[1:])
    return tuple(_shifted(polynomial) for polynomial in parts)


def without_samples(*parts: Any) -> tuple[tuple[Real, ...], int]:
    """Return a system in z without the whole samples of delay at its input, and how many.

    L(z) = z^(−m)·L'(z): in (A, b, c, d) the input enters one state alone, which hands it on and
    follows nothing else; of two polynomials the denominator has m roots at z = 0.
    """
    if len(parts) == 2:
        return _without_roots_at_zero(*parts)
    (a, b, c, d), count = parts, 0
    while d == 0.0 and np.count_nonzero(b) == 1:
        [[line]] = np.nonzero(b)
        if a[line].any():
            break
        others = np.arange(len(a)) != line
        a, b, c, d = (
            a[np.ix_(others, others)],
            b[line] * a[others, line],
            c[others],
            b[line] * c[line],
        )
        count += 1
    return (a, b, c, d), count


def _without_roots_at_zero(numerator: Real, denominator: Real) -> tuple[tuple[Real, ...], int]:
    above, below = np.trim_zeros(numerator, "f"), np.trim_zeros(denominator, "f")
    rooted = len(below) - len(np.trim_zeros(below, "b"))
    count = max(min(rooted, len(below) - len(above)), 0)
    return (numerator, below[: len(below) - count]), count


def _shifted(polynomial: Real) -> Real:
    """Return the coefficients of p(1 + x), those that are nothing but rounding set to 0."""
    shifted, sizes = polynomial.copy(), abs(polynomial)
    for end in range(len(shifted), 1, -1):
        for i in range(1, end):
            shifted[i] += shifted[i - 1]
            sizes[i] += sizes[i - 1]
    return np.where(abs(shifted) <= _ROUNDING * sizes, 0.0, shifted)


def on_w_plane(loop: FactoredLoop, dt: float) -> FactoredLoop:
    """Return a loop given by roots in z − 1 on the plane of w = (z − 1)/(z + 1).

    Raises
    ------
    ValueError
        If it has more zeros than poles.
    """
    order = loop.poles.size
    if loop.zeros.size > order:
        raise ValueError(
            f"system has {loop.zeros.size} zeros and {order} poles: it needs samples yet to come; "
            "loop_margins takes at most as many zeros as poles: put the delay of the loop in, "
            "one pole at z = 0 for each sample"
        )
    zeros, zeros_factor = _mapped(loop.zeros, order)
    poles, poles_factor = _mapped(loop.poles, order)
    whole = order + loop.samples
    closed, hidden = _mapped(loop.closed, whole)[0], _mapped(loop.hidden, loop.hidden.size)[0]
    # A pole at z = −1 has no finite w.
    lost = np.full(whole - closed.size + loop.hidden.size - hidden.size, 1j * HIGHEST)
    return replace(
        loop,
        zeros=zeros,
        poles=poles,
        gain=float((loop.gain * zeros_factor / poles_factor).real),
        closed=closed,
        hidden=np.concatenate([hidden, lost]),
        dt=dt,
    )


def _mapped(roots: Complex, degree: int) -> tuple[Complex, complex]:
    """Return the roots in w of a polynomial of a degree given by its roots in z − 1, and a factor.

    The polynomial in z is the factor times that in w over (1 − w)^degree; what it lacks in roots
    lies at z = ∞, w = 1, and z = −1 has none.
    """
    behind = roots + 2.0
    finite = abs(behind) > _AT_MINUS_ONE
    missing = degree - roots.size
    mapped = np.concatenate([roots[finite] / behind[finite], np.ones(missing)])
    factor = np.prod(np.where(finite, behind, -roots)) * (-1.0) ** missing
    return mapped, complex(factor)
