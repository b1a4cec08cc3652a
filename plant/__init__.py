"""Plants, controllers and loops as python-control systems, and their exact responses."""

from .blocks import filter_system
from .feedforward import InertiaFeedforward
from .flexible_inertia import FlexibleInertia
from .inertia import Inertia
from .pid import PID, design_pid, printed_pid
from .respond import respond
from .sampled import zero_order_hold
from .servo_loop import LoopResponse, ServoLoop

__all__ = [
    "PID",
    "FlexibleInertia",
    "Inertia",
    "InertiaFeedforward",
    "LoopResponse",
    "ServoLoop",
    "design_pid",
    "filter_system",
    "printed_pid",
    "respond",
    "zero_order_hold",
]


def __dir__() -> list[str]:
    return sorted(__all__)
