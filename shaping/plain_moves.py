"""Moves that core, closed forms and half horizon know the minimum time of: positions free."""

from __future__ import annotations

from typing import Literal

from .. import core
from .limits import Limits
from .trajectory import Trajectory, within_range

Method = Literal["optimal", "closed-form"]
"""How `min_time_move` plans from order 4 on."""

OPTIMAL: Method = "optimal"


def move_at_once(distance: float, limits: Limits, start: float) -> Trajectory | None:
    """Return the move of plain numbers that the core plans, to order 3; None for others."""
    try:
        found = core.move(distance, limits.flat, start, Trajectory, None)
    except (AttributeError, TypeError, ValueError):  # of another order, told, or converted, later
        return None
    return found if type(found) is Trajectory else None


def plain_move(distance: float, limits: Limits, start: float, method: Method) -> Trajectory:
    """Return the fastest move that core, closed forms and half horizon know, positions free."""
    found = move_at_once(distance, limits, start)
    return formed_move(distance, limits, start, method) if found is None else found


def formed_move(distance: float, limits: Limits, start: float, method: Method) -> Trajectory:
    """Return the move that the core does not plan at once; errors are told here."""
    from .closed_moves import check_kept, fastest, planned  # which most moves go without

    def plan(length: float, forward: Limits) -> Trajectory:
        move = within_range(lambda: fastest(length, forward))
        check_kept(move, forward)
        if method == "closed-form" or forward.order <= 3:
            return move
        from .optimal.minimum_time import faster_or_warn  # which is built on the closed forms

        return faster_or_warn(move, forward)

    return planned(distance, limits, start, plan)
