"""A root of a function of one number between two places, to rounding."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

_ROUNDING = 2.3e-16
_MOST = 200


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a continuous function that changes its sign between two places is 0.

    By inverse quadratic interpolation where that is sure to get nearer, else by halving.

    References
    ----------
    Chandrupatla, Advances in Engineering Software 28 (1997) 145-149.

    Examples
    --------
    >>> round(root_between(lambda x: x * x - 2.0, 0.0, 2.0), 12)
    1.414213562373
    """
    a, b = high, low
    at_a, at_b = function(a), function(b)
    c, at_c, share, best = a, at_a, 0.5, a if abs(at_a) < abs(at_b) else b
    if min(abs(at_a), abs(at_b)) == 0.0:
        return best
    for _ in range(_MOST):
        x = a + share * (b - a)
        at_x = function(x)
        if (at_x > 0.0) == (at_a > 0.0):
            c, at_c = a, at_a
        else:
            c, b, at_c, at_b = b, a, at_b, at_a
        a, at_a = x, at_x
        best = a if abs(at_a) < abs(at_b) else b
        least = 2.0 * _ROUNDING * abs(best) / (abs(b - a) or 1.0)
        if least > 0.5 or a == b or min(abs(at_a), abs(at_b)) == 0.0:
            return best
        share = min(max(_share(a, b, c, (at_a, at_b, at_c)), least), 1.0 - least)
    return best


def _share(a: float, b: float, c: float, values: tuple[float, float, float]) -> float:
    """Return where between a and b to look next: 0.5 where interpolation may lead astray."""
    at_a, at_b, at_c = values
    if at_c == at_b or at_a == at_b or c == b:
        return 0.5
    xi, phi = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
    if not (0.0 <= phi <= 1.0 and 1.0 - sqrt(1.0 - phi) < xi < sqrt(phi)):
        return 0.5
    first = at_a / (at_b - at_a) * at_c / (at_b - at_c)
    return first + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
