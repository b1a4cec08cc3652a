"""Weighted vector fitting: the poles of modes in a measured response.

With starting poles p_k the response is written as G = N/D, both with these poles; the zeros of D
are the poles of the next round (Gustavsen and Semlyen, IEEE Trans. Power Delivery 14 (1999)
1052-1061).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .rational_fits import Complex, Real

_ROUNDS = 15
_STILL = 1e-4  # relative: a pole that has settled
_STARTING_DAMPING = 0.01


def mode_poles(
    s: Complex, response: Complex, weight: Real, rigid: Complex, count: int, *, surplus: int = 0
) -> Complex:
    """Return the poles of so many modes, those with positive imaginary part, (count,).

    Parameters
    ----------
    s : (N,) complex array
        jω, ascending.
    response : (N,) complex array
    weight : (N,) array
        One over the standard deviations.
    rigid : (N, k) complex array
        What the axis has besides modes, such as 1/s² and a constant.
    count : int
    surplus : int, optional
        So many more are looked for first, of which those that matter most are kept.
    """
    if not count:
        return np.empty(0, dtype=complex)
    low, high = np.log(s.imag[[0, -1]])
    places = np.arange(1.0, count + surplus + 1.0) / (count + surplus + 1.0)
    poles = np.exp(low + (high - low) * places) * (1j - _STARTING_DAMPING)
    poles = _settled(s, response, weight, rigid, poles)
    if surplus:
        parts = _parts(s, response, weight, rigid, poles)[rigid.shape[1] :]
        loud = np.linalg.norm(pair_basis(s, poles) * weight[:, None] * parts, axis=0)
        kept = np.argsort(-(loud[::2] ** 2 + loud[1::2] ** 2))[:count]
        poles = _settled(s, response, weight, rigid, poles[kept])
    return np.asarray(poles[np.argsort(poles.imag)])


def residues(
    s: Complex, response: Complex, weight: Real, rigid: Complex, poles: Complex
) -> tuple[float, Real]:
    """Return the first coefficient of the rigid part, and g of each mode's g/(s² + …)."""
    found = _parts(s, response, weight, rigid, poles)
    return float(found[0]), -2.0 * found[rigid.shape[1] + 1 :: 2] * poles.imag


def _settled(
    s: Complex, response: Complex, weight: Real, rigid: Complex, poles: Complex
) -> Complex:
    for _ in range(_ROUNDS):
        before, poles = poles, _relocated(s, response, weight, rigid, poles)
        if (abs(poles - before) < _STILL * abs(poles)).all():
            break
    return poles


def _parts(s: Complex, response: Complex, weight: Real, rigid: Complex, poles: Complex) -> Real:
    """Return the coefficients of the rigid part and of the modes with given poles."""
    rows = np.concatenate([rigid, pair_basis(s, poles)], axis=1)
    return real_least_squares(rows * weight[:, None], response * weight)


def real_least_squares(rows: Any, right: Any) -> Real:
    """Return the real coefficients of complex columns that come nearest to the right side."""
    stacked = np.concatenate([rows.real, rows.imag])
    scale = np.maximum(np.linalg.norm(stacked, axis=0), 1e-300)
    solved = np.linalg.lstsq(stacked / scale, np.concatenate([right.real, right.imag]), rcond=None)
    return np.asarray(solved[0] / scale)


def pair_basis(s: Complex, poles: Complex) -> Complex:
    """Return 1/(s − p) + 1/(s − p*) and j/(s − p) − j/(s − p*) of each pole, (N, 2·count)."""
    one, other = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    return np.stack([one + other, 1j * (one - other)], axis=2).reshape(len(s), -1)


def _relocated(
    s: Complex, response: Complex, weight: Real, rigid: Complex, poles: Complex
) -> Complex:
    basis = pair_basis(s, poles)
    above = np.concatenate([rigid, basis], axis=1)
    rows = np.concatenate([above, -response[:, None] * basis], axis=1) * weight[:, None]
    weights = real_least_squares(rows, response * weight)[above.shape[1] :]
    matrix = np.zeros((2 * len(poles), 2 * len(poles)))
    column = np.zeros(2 * len(poles))
    for k, pole in enumerate(poles):
        block = slice(2 * k, 2 * k + 2)
        matrix[block, block] = [[pole.real, pole.imag], [-pole.imag, pole.real]]
        column[2 * k] = 2.0
    moved = np.linalg.eigvals(matrix - np.outer(column, weights)).astype(complex)
    return _as_modes(moved, len(poles), float(s.imag[-1]))


def _as_modes(moved: Complex, count: int, highest: float) -> Complex:
    """Return poles of modes, mirrored into the left half plane; real ones become a pair."""
    upper = moved[moved.imag > 0.0]
    real = np.sort(moved[moved.imag == 0.0].real)
    pairs = np.abs(real[: 2 * (len(real) // 2) : 2]) + 1e-6 * highest
    made = np.concatenate([upper, pairs * (1j - 0.1)])[:count]
    return np.asarray(-abs(made.real) + 1j * made.imag)
