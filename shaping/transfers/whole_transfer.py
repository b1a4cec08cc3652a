"""Transfers at orders 4 and above, and within bounds on position; of a given duration, too."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

from ..checks import finite, positive
from ..endings import ended
from ..limits import Limits, of_one
from ..moves import min_time_move
from ..optimal.long_plan import LongPlan, nearer_long_plan
from ..optimal.whole.lasting import lasting, next_duration
from ..optimal.whole.outcome import check_whole, found_plan, inside_bounds, warn_if_far
from ..optimal.whole.planner import Plan
from ..optimal.whole.warm_program import Effort
from ..trajectory import Trajectory, point
from .infeasible import InfeasibleError
from .problem import State, Transfer, checked_numbers


def whole_transfer(
    start: State,
    end: State,
    limits: Limits,
    lasts: tuple[float | None, float | None],
    rtol: float,
) -> Transfer:
    """Return the transfer of `min_time_transfer`; `lasts` is (duration, round_to)."""
    check_whole(of_one(limits))
    rtol = positive("rtol", rtol)
    begin, finish = (
        inside_bounds(name, checked_numbers(name, state, limits), limits)
        for name, state in (("start", start), ("end", end))
    )
    finite("the distance between start and end", finish[0] - begin[0])
    if lasts != (None, None):
        return Transfer(lasting(begin, finish, limits, *lasts, rtol=rtol), limits)
    if begin == finish:
        return Transfer(_standing(begin), limits)
    if not any((*begin[1:], *finish[1:])):
        move = min_time_move(finish[0] - begin[0], limits, start=begin[0], rtol=rtol)
        return Transfer(ended(move, finish), limits)
    plan: LongPlan | Plan | None = nearer_long_plan(begin, finish, limits, rtol=rtol)
    plan = plan or found_plan(begin, finish, limits, rtol=rtol)
    motion = plan.trajectory
    assert motion is not None
    warn_if_far(plan, rtol, motion.duration)
    return Transfer(motion, limits)


@dataclass(frozen=True)
class WholeProblem:
    """Two states between which an axis of order 4 or more moves, and its limits.

    All searches for its durations share one effort.
    """

    start: State
    end: State
    limits: Limits
    effort: Effort = field(default_factory=Effort)

    def next_duration(self, duration: float) -> float:
        """Return the shortest possible duration found that is no less; infinite for none."""
        start, end = (
            checked_numbers(name, state, self.limits)
            for name, state in (("start", self.start), ("end", self.end))
        )
        found = next_duration(start, end, self.limits, duration, self.effort)
        if found == inf and self.effort.left <= 0.0:
            raise InfeasibleError(
                f"no motion from {start!r} to {end!r} that takes {duration!r} or longer was found "
                "before the search ended, which is no proof that there is none; start or end one "
                "of the axes with less velocity",
                "velocity",
                0.0,
            )
        return found

    def lasting(self, duration: float) -> Transfer:
        """Return a transfer of a possible duration."""
        return whole_transfer(self.start, self.end, self.limits, (duration, None), 1e-4)


def _standing(state: tuple[float, ...]) -> Trajectory:
    """Return the trajectory of no duration at a state."""
    still = point(state[0], len(state))
    end = still.end_state.copy()
    end[: len(state)] = state
    return Trajectory(still.breaks, still.states, end_state=end)
