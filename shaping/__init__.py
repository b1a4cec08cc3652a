"""Trajectories with bounded derivatives: limits in, exact piecewise polynomials out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..later import later
from .limits import Limits
from .moves import bound_for_rise_time, min_time_move, perfect_spline
from .rise import switch_fractions
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .batch import MotionBatch
    from .batches.moves import min_time_moves
    from .batches.transfers import min_time_transfers
    from .followed import follow_commands
    from .followers import CommandFollower, FollowerResponse
    from .input_shapers import InputShaper, input_shaper
    from .jerk_filter import FilterResponse, JerkFilter
    from .min_jerk import min_jerk_move
    from .optimal.binding import binding_limits
    from .optimal.certificate import Certificate, certify, proven_excess
    from .passage import Passage, Tour
    from .scans import Scan, scan_move
    from .tours.through import through
    from .transfers.infeasible import InfeasibleError
    from .transfers.problem import Transfer
    from .transfers.s_curve import SCurveMove, s_curve_move
    from .transfers.synchronize import synchronize
    from .transfers.synchronized import Synchronized
    from .transfers.tracking import tracking_transfer
    from .transfers.transfer import min_time_transfer, velocity_transfer
    from .transfers.velocity_move import VelocityMove, velocity_move

# Imported when they are first asked for, so that `import jounce.shaping` costs little beside numpy.
_LATER = {
    "Certificate": "optimal.certificate",
    "CommandFollower": "followers",
    "FilterResponse": "jerk_filter",
    "FollowerResponse": "followers",
    "InfeasibleError": "transfers.infeasible",
    "InputShaper": "input_shapers",
    "JerkFilter": "jerk_filter",
    "MotionBatch": "batch",
    "Passage": "passage",
    "SCurveMove": "transfers.s_curve",
    "Synchronized": "transfers.synchronized",
    "Scan": "scans",
    "Tour": "passage",
    "Transfer": "transfers.problem",
    "VelocityMove": "transfers.velocity_move",
    "binding_limits": "optimal.binding",
    "certify": "optimal.certificate",
    "proven_excess": "optimal.certificate",
    "follow_commands": "followed",
    "input_shaper": "input_shapers",
    "min_jerk_move": "min_jerk",
    "min_time_moves": "batches.moves",
    "min_time_transfer": "transfers.transfer",
    "min_time_transfers": "batches.transfers",
    "s_curve_move": "transfers.s_curve",
    "scan_move": "scans",
    "synchronize": "transfers.synchronize",
    "through": "tours.through",
    "velocity_move": "transfers.velocity_move",
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
    "Passage",
    "SCurveMove",
    "Scan",
    "Synchronized",
    "Tour",
    "Trajectory",
    "Transfer",
    "VelocityMove",
    "binding_limits",
    "bound_for_rise_time",
    "certify",
    "follow_commands",
    "input_shaper",
    "min_jerk_move",
    "min_time_move",
    "min_time_moves",
    "min_time_transfer",
    "min_time_transfers",
    "perfect_spline",
    "proven_excess",
    "s_curve_move",
    "scan_move",
    "switch_fractions",
    "synchronize",
    "through",
    "tracking_transfer",
    "velocity_move",
    "velocity_transfer",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
