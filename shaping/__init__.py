"""Trajectories with bounded derivatives: limits in, exact piecewise polynomials out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..later import later
from .jerk_filter import FilterResponse, JerkFilter
from .limits import Limits
from .min_jerk import min_jerk_move
from .moves import bound_for_rise_time, min_time_move, perfect_spline
from .rise import switch_fractions
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .batch import MotionBatch
    from .batches.moves import min_time_moves
    from .batches.transfers import min_time_transfers
    from .followers import CommandFollower, FollowerResponse
    from .input_shapers import InputShaper, input_shaper
    from .optimal.binding import binding_limits
    from .optimal.certificate import Certificate, certify
    from .scans import Scan, scan_move
    from .transfers.infeasible import InfeasibleError
    from .transfers.problem import Transfer
    from .transfers.s_curve import SCurveMove, s_curve_move
    from .transfers.synchronize import synchronize
    from .transfers.tracking import tracking_transfer
    from .transfers.transfer import min_time_transfer, velocity_transfer

# Imported when they are first asked for, so that `import jounce.shaping` costs little beside numpy.
_LATER = {
    "Certificate": "optimal.certificate",
    "CommandFollower": "followers",
    "FollowerResponse": "followers",
    "InfeasibleError": "transfers.infeasible",
    "InputShaper": "input_shapers",
    "MotionBatch": "batch",
    "SCurveMove": "transfers.s_curve",
    "Scan": "scans",
    "Transfer": "transfers.problem",
    "binding_limits": "optimal.binding",
    "certify": "optimal.certificate",
    "input_shaper": "input_shapers",
    "min_time_moves": "batches.moves",
    "min_time_transfer": "transfers.transfer",
    "min_time_transfers": "batches.transfers",
    "s_curve_move": "transfers.s_curve",
    "scan_move": "scans",
    "synchronize": "transfers.synchronize",
    "tracking_transfer": "transfers.tracking",
    "velocity_transfer": "transfers.transfer",
}

__all__ = [
    "Certificate",
    "CommandFollower",
    "FilterResponse",
    "FollowerResponse",
    "InfeasibleError",
    "InputShaper",
    "JerkFilter",
    "Limits",
    "MotionBatch",
    "SCurveMove",
    "Scan",
    "Trajectory",
    "Transfer",
    "binding_limits",
    "bound_for_rise_time",
    "certify",
    "input_shaper",
    "min_jerk_move",
    "min_time_move",
    "min_time_moves",
    "min_time_transfer",
    "min_time_transfers",
    "perfect_spline",
    "s_curve_move",
    "scan_move",
    "switch_fractions",
    "synchronize",
    "tracking_transfer",
    "velocity_transfer",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
