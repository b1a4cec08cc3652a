"""The smallest discrete state space that has a given impulse response."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...shaping.pieces import FloatArray

_ROUNDING = 1e-13  # residuals below are all the same: what doubles leave of exact data
_SLACK = 10.0  # an order is enough if no higher one has a residual so many times smaller
_RANK = 1e-15  # singular values below, relative to the first, are rounding


@dataclass(frozen=True, eq=False)
class Realization:
    """x_{k+1} = A·x_k + B·u_k, y_k = C·x_k, and how well it has the response it was made from.

    `residual` is the largest |error| of a sample, relative to the largest sample so far, outputs
    and inputs scaled to equal peaks.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    residual: float

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)


def realize(response: FloatArray, max_order: int, *, noise: float = 0.0) -> Realization:
    """Return the smallest state space that has an impulse response.

    The eigensystem realisation: of the Hankel matrices H_0 = [h_{s(i+j)}], H_1 = [h_{s(i+j)+1}]
    and H_0 ≈ U·Σ·Vᵀ cut off at n singular values,

        A = Σ^(−1/2)·Uᵀ·H_1·V·Σ^(−1/2),   B = the first column of Σ^(1/2)·Vᵀ,
        C = the first row of U·Σ^(1/2).

    Strides s = 1, 2, 4, … let few rows span slow and fast modes alike. Every stride and every
    order n up to `max_order` is tried on the whole response; the smallest order is taken whose
    residual is within the noise, or that no other betters tenfold.

    Parameters
    ----------
    response : (N, outputs, inputs) array
        h_k = C·A^k·B, k = 0 … N − 1: what u_0 = 1 does to y_{k+1}. Finite.
    max_order : int
    noise : float, optional
        Relative error of the response, as in `Realization.residual`; rounding at least.

    Returns
    -------
    Realization
        Of order 0 for a response that is zero.

    References
    ----------
    Juang and Pappa, "An eigensystem realization algorithm for modal parameter identification and
    model reduction", Journal of Guidance, Control, and Dynamics 8(5), 1985, equations (8)–(16).

    Examples
    --------
    >>> double = realize(np.arange(0.5, 40.0)[:, None, None], 5)  # ÿ = u, sampled every 1
    >>> double.order, np.linalg.eigvals(double.A).real.round(6).tolist()
    (2, [1.0, 1.0])
    """
    _, p, m = response.shape
    scaled, rows, columns = _scaled(response)
    peaks = np.maximum.accumulate(np.abs(scaled).max(axis=(1, 2)))
    if not peaks.any():
        return Realization(np.zeros((0, 0)), np.zeros((0, m)), np.zeros((p, 0)), 0.0)
    peaks[peaks == 0.0] = peaks[peaks > 0.0][0]
    tried = list(_candidates(scaled, peaks, max_order))
    enough = max(_SLACK * min(found.residual for found in tried), _ROUNDING, noise)
    order = min(found.order for found in tried if found.residual <= enough)
    best = min((t for t in tried if t.order == order), key=lambda found: found.residual)
    return Realization(best.A, best.B * columns, best.C * rows[:, None], best.residual)


def _candidates(scaled: FloatArray, peaks: FloatArray, max_order: int) -> Iterator[Realization]:
    count = len(scaled)
    size = min(max_order + 1, count // 2)
    stride = 1
    while stride == 1 or 2 * (size - 1) * stride + 1 < count:
        yield from _of_stride(scaled, peaks, max_order, stride, size)
        stride *= 2


def _of_stride(
    scaled: FloatArray, peaks: FloatArray, max_order: int, stride: int, size: int
) -> Iterator[Realization]:
    _, p, m = scaled.shape
    here = stride * np.add.outer(np.arange(size), np.arange(size))
    blocks, shifted = (
        scaled[here + late].transpose(0, 2, 1, 3).reshape(size * p, size * m) for late in (0, 1)
    )
    left, values, right = np.linalg.svd(blocks, full_matrices=False)
    orders = int(np.count_nonzero(values > _RANK * values[0])) if values[0] > 0.0 else 0
    roots = np.sqrt(values[:orders])
    a = (left[:, :orders].T @ shifted @ right[:orders].T) / roots[:, None] / roots
    b, c = roots[:, None] * right[:orders, :m], left[:p, :orders] * roots
    for n in range(1, min(orders, max_order) + 1):
        found = a[:n, :n], b[:n], c[:, :n]
        with np.errstate(over="ignore", invalid="ignore"):
            error = np.abs(impulse_response(*found, len(scaled)) - scaled).max(axis=(1, 2)) / peaks
        residual = float(error.max())
        yield Realization(*found, residual if np.isfinite(residual) else np.inf)


def impulse_response(a: FloatArray, b: FloatArray, c: FloatArray, count: int) -> FloatArray:
    """Return C·A^k·B for k = 0 … count − 1, (count, outputs, inputs), by doubling."""
    states, power = b[None], a
    with np.errstate(over="ignore", invalid="ignore"):
        while len(states) < count:
            states = np.concatenate([states, power @ states])
            power = power @ power
        found: FloatArray = c @ states[:count]
    return found


def _scaled(response: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the response with outputs and inputs of equal peaks, and their factors."""
    rows = np.abs(response).max(axis=(0, 2), initial=0.0)
    rows[rows == 0.0] = 1.0
    columns = np.abs(response / rows[:, None]).max(axis=(0, 1), initial=0.0)
    columns[columns == 0.0] = 1.0
    return response / rows[:, None] / columns, rows, columns
