"""Where the gains and phases of many loops turn: real roots of polynomials in ω²."""

from __future__ import annotations

import numpy as np

from .factored_loop import Real
from .many_roots import product, roots, summed

_REAL = 1e-2


def turning_points(
    numerator: Real, denominator: Real, power: Real, delay: Real
) -> tuple[Real, Real]:
    """Return ω, nan for none, among them all where the gain turns, and where the phase does."""
    of_gain, of_phase = map(_real_roots, _turning(numerator, denominator, power, delay))
    return of_gain, of_phase


def _turning(numerator: Real, denominator: Real, power: Real, delay: Real) -> tuple[Real, Real]:
    """Return polynomials in ω², of all frequencies where the gain turns, and where the phase."""
    (n, n_turn), (d, d_turn) = (_squares(part) for part in (numerator, denominator))
    of_gain = product(n, d, lambda i, j: power + (i - j))
    of_phase = summed(
        product(n_turn, d),
        product(-d_turn, n),
        -delay[:, None] * product(n, d),
    )
    return of_gain, of_phase


def _squares(rows: Real) -> tuple[Real, Real]:
    """Return |P|² and |P|²·d(arg P)/dω as polynomials of x = ω².

    With P = e(x) + jω·o(x) they are e² + x·o² and e·o + 2x·(o'e − o·e').
    """
    signs = (-1.0) ** np.arange(rows.shape[1])
    even, odd = rows[:, 0::2] * signs[: -(-rows.shape[1] // 2)], rows[:, 1::2]
    odd = odd * signs[: odd.shape[1]]
    shifted = np.concatenate([np.zeros((len(rows), 1)), product(odd, odd)], axis=1)
    turn = product(odd, even, lambda i, j: 1.0 + 2.0 * (i - j))
    return summed(product(even, even), shifted), turn


def _real_roots(rows: Real) -> Real:
    """Return ω of the positive real roots in ω², nan for none."""
    squares = roots(rows)
    real = (squares.real > 0.0) & (abs(squares.imag) <= _REAL * squares.real)
    return packed(np.sqrt(np.where(real, squares.real, np.nan)))


def packed(omega: Real) -> Real:
    """Return rows with all nan at their ends, and no column of nothing else."""
    omega = np.sort(omega, axis=1)
    return omega[:, np.isfinite(omega).any(axis=0)]
