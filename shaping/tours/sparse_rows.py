"""Rows of a sparse matrix with their right-hand sides, as they come."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..pieces import FloatArray

Columns = NDArray[np.intp]


class SparseRows:
    """Rows of a linear program, each divided by its largest coefficient."""

    def __init__(self) -> None:
        self._parts: list[tuple[FloatArray, Columns, Columns]] = []
        self._sides: list[FloatArray] = []
        self._count = 0

    def add(self, columns: Columns, values: FloatArray, sides: FloatArray) -> None:
        """Add rows (m, N) over these N columns, and their right-hand sides (m,)."""
        size = np.abs(values).max(axis=1, initial=1e-300)
        rows = np.repeat(np.arange(self._count, self._count + len(sides)), len(columns))
        values = (values / size[:, None]).ravel()
        self._parts.append((values, rows, np.tile(columns, len(sides))))
        self._sides.append(sides / size)
        self._count += len(sides)

    def matrix(self, columns: int) -> Any:
        """Return the sparse matrix with so many columns, None where there is no row."""
        if not self._parts:
            return None
        from scipy.sparse import csr_matrix

        values, rows, across = map(np.concatenate, zip(*self._parts, strict=True))
        return csr_matrix((values, (rows, across)), shape=(self._count, columns))

    def sides(self) -> FloatArray | None:
        """Return the right-hand sides."""
        return np.concatenate(self._sides) if self._sides else None
