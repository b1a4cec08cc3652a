"""A motion and its limits in units of its own, in which it takes and covers about 1."""

from __future__ import annotations

from math import frexp

import numpy as np

from ..limits import Limits
from ..move_units import MoveUnits
from ..pieces import FloatArray
from ..trajectory import Trajectory


def of_order_one(trajectory: Trajectory, limits: Limits) -> tuple[Trajectory, Limits, int]:
    """Return a motion and its limits in units of powers of two, and the exponent of that of time.

    Powers of two round nothing, so that what is found does not depend on the caller's units.
    """
    low, high = trajectory.extremes(0)
    time, length = frexp(trajectory.duration)[1], frexp(high - low)[1]
    units = MoveUnits(np.array(-time), np.array(-length))
    position, *pairs = (
        (_bound(units, low, k), _bound(units, high, k))
        for k, (low, high) in enumerate(map(limits.bounds, range(limits.order + 1)))
    )
    within = position if limits.bounds_position else None
    return units.trajectory(trajectory), Limits.from_bounds(pairs, position=within), time


def _bound(units: MoveUnits, bound: float, k: int) -> float:
    """Return a bound on derivative k; one that is not zero stays so."""
    scaled: FloatArray = units.derivative(np.array(bound), k)
    return float(np.copysign(np.maximum(np.abs(scaled), np.abs(bound) and 5e-324), bound))
