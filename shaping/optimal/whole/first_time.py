"""What bounds alone leave impossible: durations up to the least by Taylor's formula."""

from __future__ import annotations

from math import factorial, inf

import numpy as np

from ...pieces import FloatArray
from ..proof import TaylorLink
from .polynomials import first_root, is_positive, value
from .problem import WholeProblem


def taylor_chain(problem: WholeProblem) -> list[TaylorLink]:
    """Return links that cover (0, T_0], T_0 the largest to which such links lead; maybe inf."""
    candidates = [
        (polynomial, k, m, sign)
        for m in range(1, problem.order + 1)
        for k in range(m)
        for sign in (1, -1)
        if (polynomial := taylor_polynomial(problem, k, m, sign)) is not None
    ]
    chain: list[TaylorLink] = []
    time = 0.0
    while time < inf:
        reached, best = time, None
        for candidate in candidates:
            polynomial = candidate[0]
            if reached > time and not value(polynomial, reached) > 0.0:
                continue  # it leads less far
            at = _reached(polynomial, time)
            if at > reached:
                reached, best = at, candidate
            if reached == inf:
                break
        if best is None or not reached > time * (1.0 + 1e-9):
            break
        chain.append(TaylorLink(time, reached, *best[1:]))
        time = reached
    return chain


def _reached(polynomial: FloatArray, time: float) -> float:
    """Return up to where a polynomial is positive from a time on; just after 0 will do there."""
    if time > 0.0:
        return first_root(polynomial, time)
    lowest = int(np.flatnonzero(polynomial)[0]) if polynomial.any() else len(polynomial)
    rest = polynomial[lowest:]
    if not len(rest) or not rest[0] > 0.0:
        return 0.0
    roots = np.polynomial.polynomial.polyroots(np.trim_zeros(rest, "b"))
    real = roots.real[(np.abs(roots.imag) <= 1e-7 * np.abs(roots)) & (roots.real > 0.0)]
    if not len(real):
        return inf if (rest >= 0.0).all() else 0.0
    for backward in (1e-12, 1e-9, 1e-6, 1e-3):
        at = float(real.min()) * (1.0 - backward)
        if value(rest, at) > 0.0 and is_positive(rest, 0.0, at):
            return at
    return 0.0


def taylor_polynomial(
    problem: WholeProblem, derivative: int, remainder: int, sign: int
) -> FloatArray | None:
    """Return the polynomial in T of `TaylorLink`, positive where it excludes, or None."""
    k, m = derivative, remainder
    bound = problem.upper[m] if sign > 0 else -problem.lower[m]
    if not np.isfinite(bound):
        return None
    polynomial = np.zeros(problem.order + 1)
    polynomial[0] = sign * problem.end[k]
    for q in range(k, m):
        polynomial[q - k] -= sign * problem.start[q] / factorial(q - k)
    polynomial[m - k] -= bound / factorial(m - k)
    return polynomial


def taylor_slopes(problem: WholeProblem, link: TaylorLink) -> FloatArray:
    """Return dT/dlo_k and dT/dhi_k of the time T that a link leads to, (2, n + 1)."""
    found = np.zeros((2, problem.order + 1))
    polynomial = taylor_polynomial(problem, link.derivative, link.remainder, link.sign)
    assert polynomial is not None
    d, degrees = link.remainder - link.derivative, np.arange(len(polynomial))
    slope = float(degrees @ (polynomial * link.high**degrees)) / link.high
    side = int(link.sign > 0)
    found[side, link.remainder] = link.sign * link.high**d / (factorial(d) * slope)
    return found
