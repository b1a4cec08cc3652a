"""Stability margins of feedback loops, read off L(jω) itself."""

from typing import TYPE_CHECKING

from ...later import later

if TYPE_CHECKING:
    from .many_margins import ManyMargins, many_loop_margins, servo_margins
    from .one_loop import loop_margins
    from .result import LoopMargins

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "LoopMargins": "result",
    "ManyMargins": "many_margins",
    "loop_margins": "one_loop",
    "many_loop_margins": "many_margins",
    "servo_margins": "many_margins",
}

__all__ = ["LoopMargins", "ManyMargins", "loop_margins", "many_loop_margins", "servo_margins"]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
