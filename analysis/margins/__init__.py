"""Stability margins of feedback loops, read off L(jω) itself."""

from .one_loop import loop_margins
from .result import LoopMargins

__all__ = ["LoopMargins", "loop_margins"]
