"""Symmetric banded matrices, kept by their lower diagonals: products, and band of the inverse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

_BLOCK = 8  # unknowns taken together; at least the half-bandwidth


def banded(band: FloatArray) -> Any:
    """Return a symmetric matrix as a sparse array.

    Parameters
    ----------
    band : (w + 1, K) array
        Element [i, j] is that of row j + i and column j, as in scipy.linalg.cholesky_banded.
    """
    from scipy.sparse import dia_array

    count = band.shape[1]
    upper = [np.roll(diagonal, i) for i, diagonal in enumerate(band)]
    offsets = [*range(0, -len(band), -1), *range(1, len(band))]
    return dia_array((np.vstack([band, upper[1:]]), offsets), shape=(count, count)).tocsr()


def band_of(matrix: Any, width: int) -> FloatArray:
    """Return the diagonal and `width` lower diagonals of a sparse array."""
    band = np.zeros((width + 1, matrix.shape[1]))
    for i in range(width + 1):
        diagonal = matrix.diagonal(-i)
        band[i, : len(diagonal)] = diagonal
    return band


def times_vector(band: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the product of a symmetric banded matrix and a vector."""
    product = band[0] * vector
    for i, diagonal in enumerate(band[1:], start=1):
        product[i:] += diagonal[:-i] * vector[:-i]
        product[:-i] += diagonal[:-i] * vector[i:]
    return np.asarray(product)


def inverse_band(factor: FloatArray) -> FloatArray:
    """Return the band of (L·Lᵀ)⁻¹ from the band of its Cholesky factor L.

    With L in blocks, Lᵢ on the diagonal and Mᵢ below it, and Fᵢ = Mᵢ·Lᵢ⁻¹, from the last on

        Zᵢ₊₁,ᵢ = −Zᵢ₊₁,ᵢ₊₁·Fᵢ,   Zᵢᵢ = (Lᵢ·Lᵢᵀ)⁻¹ + Fᵢᵀ·Zᵢ₊₁,ᵢ₊₁·Fᵢ

    Parameters
    ----------
    factor : (w + 1, K) array
        Lower form, w ≤ 8.

    References
    ----------
    Takahashi, Fagan & Chen, "Formation of a sparse bus impedance matrix and its application to
    short circuit study", PICA (1973); Hutchinson & de Hoog, "Smoothing noisy data with spline
    functions", Numer. Math. 47 (1985).
    """
    width, count = factor.shape
    blocks = -(-count // _BLOCK)
    padded = np.zeros((width, blocks * _BLOCK))
    padded[0] = 1.0
    for i in range(width):
        padded[i, : count - i] = factor[i, : count - i]
    diagonal, below = _blocks(padded, blocks)
    inverse = np.linalg.inv(diagonal)
    steps = below @ inverse
    middle = inverse.transpose(0, 2, 1) @ inverse
    beside = np.zeros_like(middle)
    for i in range(blocks - 2, -1, -1):
        beside[i] = -middle[i + 1] @ steps[i]
        middle[i] -= steps[i].T @ beside[i]
    band = np.empty_like(padded)
    for i in range(width):
        for j in range(_BLOCK):
            block, row = (middle, j + i) if j + i < _BLOCK else (beside, j + i - _BLOCK)
            band[i, j::_BLOCK] = block[:, row, j]
    return band[:, :count]


def _blocks(band: FloatArray, blocks: int) -> tuple[FloatArray, FloatArray]:
    """Return the square blocks on the diagonal and below it of a lower banded matrix."""
    diagonal, below = np.zeros((2, blocks, _BLOCK, _BLOCK))
    for i, values in enumerate(band):
        for j in range(_BLOCK):
            block, row = (diagonal, j + i) if j + i < _BLOCK else (below, j + i - _BLOCK)
            block[:, row, j] = values[j::_BLOCK]
    return diagonal, below
