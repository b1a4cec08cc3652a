"""Ripple of the torque over position: cogging."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, pi

import numpy as np

from ..shaping.checks import finite, positive
from ..shaping.pieces import FloatArray

PIECES = 16
"""Straight pieces of a period in a simulation, which is exact for them."""


@dataclass(frozen=True)
class Ripple:
    """A torque on the motor that goes with its position, amplitude·sin(2π·(y − offset)/period).

    In simulations the sine is a chain of 16 straight pieces, within 1 % of its amplitude; linear
    analysis leaves the ripple out.

    Parameters
    ----------
    amplitude : float
        Torque.
    period : float
        Position from one pole to the next, positive.
    offset : float, optional
        Position at which the torque rises through 0.
    """

    amplitude: float
    period: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "amplitude", finite("amplitude", self.amplitude))
        object.__setattr__(self, "period", positive("period", self.period))
        object.__setattr__(self, "offset", finite("offset", self.offset))

    def values(self) -> FloatArray:
        """Return the torque at the ends of the straight pieces, as far off outside as inside."""
        nodes = np.sin(2.0 * pi * np.arange(PIECES + 1.0) / PIECES)
        nodes[[0, PIECES // 2, PIECES]] = 0.0
        return np.asarray(self.amplitude * nodes * 2.0 / (1.0 + np.cos(pi / PIECES)))

    def piece_at(self, position: float) -> tuple[int, float]:
        """Return the piece that a position is on, and where that begins."""
        width = self.period / PIECES
        count = floor((position - self.offset) / width)
        return count % PIECES, self.offset + count * width

    def torque(self, position: float) -> float:
        """Return the torque at a position, of the straight pieces."""
        piece, begin = self.piece_at(position)
        left, right = self.values()[piece : piece + 2].tolist()
        return float(left + (right - left) * (position - begin) * PIECES / self.period)
