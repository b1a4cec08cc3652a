"""Trajectories with bounded derivatives: limits in, exact piecewise polynomials out."""

from .jerk_filter import FilterResponse, JerkFilter
from .limits import Limits
from .min_jerk import min_jerk_move
from .moves import bound_for_rise_time, min_time_move, perfect_spline
from .rise import switch_fractions
from .trajectory import Trajectory

__all__ = [
    "FilterResponse",
    "JerkFilter",
    "Limits",
    "Trajectory",
    "bound_for_rise_time",
    "min_jerk_move",
    "min_time_move",
    "perfect_spline",
    "switch_fractions",
]
