"""Trajectories with bounded derivatives: limits in, exact piecewise polynomials out."""

from .followers.follower import CommandFollower, FollowerResponse
from .jerk_filter import FilterResponse, JerkFilter
from .limits import Limits
from .min_jerk import min_jerk_move
from .moves import bound_for_rise_time, min_time_move, perfect_spline
from .rise import switch_fractions
from .trajectory import Trajectory
from .transfers.batch import TransferBatch, min_time_transfers
from .transfers.infeasible import InfeasibleError
from .transfers.problem import Transfer
from .transfers.s_curve import SCurveMove, s_curve_move
from .transfers.synchronize import synchronize
from .transfers.transfer import min_time_transfer, velocity_transfer

__all__ = [
    "CommandFollower",
    "FilterResponse",
    "FollowerResponse",
    "InfeasibleError",
    "JerkFilter",
    "Limits",
    "SCurveMove",
    "Trajectory",
    "Transfer",
    "TransferBatch",
    "bound_for_rise_time",
    "min_jerk_move",
    "min_time_move",
    "min_time_transfer",
    "min_time_transfers",
    "perfect_spline",
    "s_curve_move",
    "switch_fractions",
    "synchronize",
    "velocity_transfer",
]
