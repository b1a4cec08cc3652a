"""Plants, controllers and loops as python-control systems, and their exact responses."""

from .blocks import filter_system
from .feedforward import InertiaFeedforward
from .inertia import Inertia
from .pid import PID, design_pid, printed_pid
from .respond import respond
from .servo_loop import LoopResponse, ServoLoop

__all__ = [
    "PID",
    "Inertia",
    "InertiaFeedforward",
    "LoopResponse",
    "ServoLoop",
    "design_pid",
    "filter_system",
    "printed_pid",
    "respond",
]
