"""The explorer: a loop and its moves on a page, shaped by hand, all computed here."""

from .session import Session
from .state import State, opened
from .widget import Explorer, explore

__all__ = ["Explorer", "Session", "State", "explore", "opened"]
