"""Trajectories with bounded derivatives: limits in, exact piecewise polynomials out."""

from .limits import Limits
from .moves import bound_for_rise_time, min_time_move, perfect_spline
from .rise import switch_fractions
from .trajectory import Trajectory

__all__ = [
    "Limits",
    "Trajectory",
    "bound_for_rise_time",
    "min_time_move",
    "perfect_spline",
    "switch_fractions",
]
