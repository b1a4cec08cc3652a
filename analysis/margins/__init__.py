"""Stability margins of feedback loops, read off L(jω) itself."""

from .many_margins import ManyMargins, many_loop_margins, servo_margins
from .one_loop import loop_margins
from .result import LoopMargins

__all__ = ["LoopMargins", "ManyMargins", "loop_margins", "many_loop_margins", "servo_margins"]
