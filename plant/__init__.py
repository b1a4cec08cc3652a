"""Plants, controllers and loops as python-control systems, and their exact responses."""

from importlib import import_module
from typing import TYPE_CHECKING

from .blocks import filter_system
from .feedforward import InertiaFeedforward
from .flexible_inertia import FlexibleInertia
from .inertia import Inertia
from .pid import PID, design_pid, printed_pid
from .respond import respond
from .sampled import zero_order_hold
from .servo_loop import LoopResponse, ServoLoop

if TYPE_CHECKING:
    from . import fmu

__all__ = [
    "PID",
    "FlexibleInertia",
    "Inertia",
    "InertiaFeedforward",
    "LoopResponse",
    "ServoLoop",
    "design_pid",
    "filter_system",
    "fmu",
    "printed_pid",
    "respond",
    "zero_order_hold",
]


def __getattr__(name: str) -> object:
    if name != "fmu":  # imported when it is first asked for
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(".fmu", __name__)


def __dir__() -> list[str]:
    return sorted(__all__)
