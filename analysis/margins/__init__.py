"""Stability margins of feedback loops, read off L(jω) itself."""

from .one_loop import LoopMargins, loop_margins

__all__ = ["LoopMargins", "loop_margins"]
