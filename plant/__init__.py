"""Plants, controllers and loops as python-control systems, and their exact responses."""

from .exact_response import respond
from .feedforward import InertiaFeedforward
from .flexible_inertia import FlexibleInertia
from .inertia import Inertia
from .pid import PID, design_pid
from .sampled import zero_order_hold
from .servo_loop import LoopResponse, ServoLoop
from .shaper_systems import filter_system

__all__ = [
    "PID",
    "FlexibleInertia",
    "Inertia",
    "InertiaFeedforward",
    "LoopResponse",
    "ServoLoop",
    "design_pid",
    "filter_system",
    "respond",
    "zero_order_hold",
]


def __dir__() -> list[str]:
    return sorted(__all__)
