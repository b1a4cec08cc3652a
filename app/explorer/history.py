"""Undo and redo: states in the order in which they were, a gesture being one of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .state import State

_MOST = 200


@dataclass(frozen=True, eq=False)
class History:
    """The present state with those before it and those that were undone, nearest last.

    Parameters
    ----------
    present : State
    past, future : tuple of State
    gesture : str
        Name of what made the present; the next change of this name replaces it.
    """

    present: State
    past: tuple[State, ...] = ()
    future: tuple[State, ...] = ()
    gesture: str = ""

    @property
    def before(self) -> State:
        """The state that the gesture began from."""
        return self.past[-1] if self.gesture else self.present


def changed(history: History, state: State, gesture: str = "") -> History:
    """Return the history with a new present; what was undone is forgotten."""
    if gesture and gesture == history.gesture:
        return replace(history, present=state, future=())
    return History(state, (*history.past, history.present)[-_MOST:], (), gesture)


def undone(history: History) -> History:
    """Return the history one state earlier; as it is, where there is none."""
    if not history.past:
        return history
    *past, present = history.past
    return History(present, tuple(past), (*history.future, history.present))


def redone(history: History) -> History:
    """Return the history with what was undone last; as it is, where nothing was."""
    if not history.future:
        return history
    *future, present = history.future
    return History(present, (*history.past, history.present), tuple(future))


def began(history: History, gesture: str) -> State:
    """Return the state that changes of a gesture are relative to."""
    return history.before if gesture and gesture == history.gesture else history.present
