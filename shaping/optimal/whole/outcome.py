"""Plans between any states as callers see them: checked, told why there is none, or how sure."""

from __future__ import annotations

from dataclasses import replace
from math import inf, ldexp
from typing import Protocol

import numpy as np

from ...derivatives import derivative_name
from ...limits import Limits, check_both_sides
from ...transfers.infeasible import InfeasibleError, LaterReason, Reason, inside
from ...warned import warn_caller
from ..proof import CostateLink, TaylorLink
from .dead_end import DeadEnd, kept_until
from .nearest_state import comes_to_rest, nearest_end, nearest_starts
from .planner import (
    DEFAULT_RTOL,
    HIGHEST_ORDER,
    ROUGHLY_RTOL,
    Numbers,
    Plan,
    planned,
    roughly_planned,
)
from .problem import WholeProblem
from .warm_program import EFFORT, Effort


class _Bounded(Protocol):
    @property
    def lower_bound(self) -> float: ...


_NOTABLE = 0.05  # of the largest contribution to a proof: a bound that it rests on
_TO_TELL = 0.5 * EFFORT  # for the nearest state with a motion


def check_whole(limits: Limits) -> None:
    """Refuse limits that nothing is planned with over the whole horizon."""
    if not 2 <= limits.order <= HIGHEST_ORDER:
        raise ValueError(
            f"limits of order {limits.order}: expected order 2 (acceleration) to {HIGHEST_ORDER} "
            "for a motion between states, or within bounds on position"
        )
    check_both_sides(limits)


def found_plan(start: Numbers, end: Numbers, limits: Limits, *, rtol: float = DEFAULT_RTOL) -> Plan:
    """Return a plan that has a motion.

    Raises
    ------
    InfeasibleError
        Where there is no motion, or none was found in the time allowed.
    """
    begin, finish = (
        inside_bounds(name, state, limits) for name, state in (("start", start), ("end", end))
    )
    _check_not_one_way(begin, finish, limits)
    _check_not_too_near(begin, finish, limits)
    plan = planned(begin, finish, limits, rtol)
    if plan.impossible:
        raise impossible(plan)
    if plan.search.best is None:
        raise InfeasibleError(LaterReason(lambda: _not_found(plan)), "")
    return plan


def inside_bounds(name: str, state: Numbers, limits: Limits) -> Numbers:
    """Return a state, roundings beyond a bound cut off; refuse one that is outside."""
    kept = []
    for k, value in enumerate(state):
        low, high = limits.bounds(k)
        kept.append(inside(value, low, high))
        if not low <= kept[-1] <= high:
            nearest = min(max(value, low), high) + 0.0
            raise InfeasibleError(
                f"{name} {derivative_name(k)} = {value!r} is outside its bounds ({low:g}, "
                f"{high:g}): the nearest that can be is {nearest!r}",
                derivative_name(k),
                nearest,
            )
    return tuple(kept)


def _check_not_one_way(start: Numbers, end: Numbers, limits: Limits) -> None:
    """Refuse a move from rest to rest on which a derivative above velocity keeps its sign.

    The one below could not come back to zero.
    """
    if any((*start[1:], *end[1:])) or start[0] == end[0]:
        return
    for k in range(2, limits.order):
        if 0.0 in limits.bounds(k):
            name, below = derivative_name(k), derivative_name(k - 1)
            sign = 1 if limits.bounds(k)[1] == 0.0 else -1
            raise InfeasibleError(
                f"no motion within the limits leads from rest to rest: with a bound of 0 on {name} "
                f"the {below} never comes back to zero; {_widen(sign)} that bound",
                name,
                None,
            )


def _check_not_too_near(start: Numbers, end: Numbers, limits: Limits) -> None:
    """Refuse moving states too near to one another, where there is no turning back.

    No position beyond the end's can be left again then: positions are bounded by both.
    """
    moving = any((*start[1:], *end[1:]))
    if not moving or 0.0 not in limits.bounds(1) or start[0] == end[0]:
        return
    (low, high), ends = limits.position, (start[0], end[0])
    between = max(low, min(ends)), min(high, max(ends))
    pairs = zip(limits.lower, limits.upper, strict=True)
    nearer = Limits.from_bounds(pairs, position=between)
    plan = planned(start, end, nearer, ROUGHLY_RTOL, effort=_TO_TELL)
    if plan.search.dead_end is not None:
        error = impossible(plan, limits.position)
        raise error.headed("with a bound of 0 on velocity there is no turning back: ")


def warn_if_far(plan: _Bounded, rtol: float, duration: float) -> None:
    """Warn where the gap that was asked for is not reached: what is known holds."""
    if not plan.lower_bound > 0.0:
        warn_caller(
            "nothing is proven of how near this motion is to the minimum time: its numbers end "
            "where doubles do; choose units in which they are larger"
        )
        return
    gap = duration / plan.lower_bound - 1.0
    if gap > rtol * (1.0 + 1e-9):
        warn_caller(
            f"this motion takes at most {100.0 * gap:.2g} % more than the minimum time, which is "
            f"proven to be at least {plan.lower_bound:.10g}: the search ended before the gap of "
            f"{rtol:g} that was asked for"
        )


def impossible(plan: Plan, position: tuple[float, float] | None = None) -> InfeasibleError:
    """Return the error for a problem that is proven to have no motion: which bound, and when.

    `position` are the caller's bounds where the plan has the two ends in their place.
    """
    link, dead = plan.proof.links[-1], plan.search.dead_end
    if isinstance(link, TaylorLink):
        k, sign, wrong = link.remainder, link.sign, link.derivative
    else:
        assert isinstance(link, CostateLink)
        k, sign = _violated(plan, link)
        wrong = 0
    bound = k, sign
    if dead is None:
        later = LaterReason(lambda: _no_way(plan, bound, wrong))
    else:
        passed = position is not None and k == 0 and _side(plan, k, sign) not in position
        later = LaterReason(lambda: _of_dead_end(plan, bound, dead, passed))
        k = 1 if passed else k
    return InfeasibleError(later, derivative_name(k))


@np.errstate(all="ignore")
def _no_way(plan: Plan, bound: tuple[int, int], wrong: int) -> Reason:
    """Return the reason where the end cannot be reached: a derivative of it that is wrong."""
    k, sign = bound
    effort = Effort(_TO_TELL)
    value = nearest_end(plan.search.problem, wrong, effort)
    nearest = None if value is None else _working(plan, "end", wrong, value, effort=effort)
    other = derivative_name(wrong)
    end = f"choose another {other} at the end"
    if nearest is not None:
        end = f"end with {other} = {nearest[0]!r}, the nearest that was found"
    return Reason(
        "no motion within the limits leads from the start to the end, in whatever time: the "
        f"{derivative_name(k)} bound {_side(plan, k, sign):g} stands in the way; "
        f"{_widen(sign)} it, or {end}",
        *_attributes(nearest, None),
    )


@np.errstate(all="ignore")
def _not_found(plan: Plan) -> Reason:
    """Return what is told where neither a motion nor a proof of none was found."""
    effort = Effort(_TO_TELL)
    value = nearest_end(plan.search.problem, 0, effort)
    nearest = None if value is None else _working(plan, "end", 0, value, effort=effort)
    remedy = "move the states away from their bounds"
    if nearest is not None:
        remedy = f"end with position = {nearest[0]!r}, the nearest that was found"
    return Reason(
        f"no motion was found: every duration up to {plan.lower_bound:.10g} is impossible, of "
        f"longer ones nothing is known; {remedy}",
        *_attributes(nearest, None),
    )


@np.errstate(all="ignore")
def _of_dead_end(plan: Plan, bound: tuple[int, int], dead: DeadEnd, passed: bool) -> Reason:
    """Return the reason where the start or the end is a dead end, or would pass the other one."""
    (k, sign), effort = bound, Effort(_TO_TELL)
    name, highest = derivative_name(k), derivative_name(plan.problem.order)
    time = ldexp(kept_until(plan.search.problem, dead, effort), plan.time)
    side, when, verb = (
        ("end", "before it", "leads to") if dead.backwards else ("start", "after it", "leaves")
    )
    seen = plan.search.problem.reversed() if dead.backwards else plan.search.problem
    remedy, nearest = "choose smaller derivatives there", None
    for derivative, value in nearest_starts(seen, dead.time, effort):
        sign_there = -1.0 if dead.backwards and derivative % 2 else 1.0
        nearest = _working(plan, side, derivative, sign_there * value, effort=effort)
        if nearest is not None:
            named = f"{derivative_name(derivative)} = {nearest[0]!r}"
            remedy = f"{side} with {named}, the nearest that was found"
            break
    limit, other = f"{_side(plan, k, sign):g}", "start" if dead.backwards else "end"
    broken, way = f"{name} would exceed its bound {limit}", f"{_widen(sign)} that bound"
    if passed:
        broken, way = f"position would pass {limit}, the {other},", f"{other} further away"
    return Reason(
        f"no motion within the limits {verb} the {side}: {broken} about {time:.3g} {when}, "
        f"whatever the {highest}; {way}, or {remedy}",
        *_attributes(nearest, -time if dead.backwards else time),
    )


def _attributes(
    nearest: tuple[float, Numbers] | None, time: float | None
) -> tuple[float | None, float | None, Numbers | None]:
    value, state = (None, None) if nearest is None else nearest
    return value, time, state


def _working(
    plan: Plan, side: str, derivative: int, own: float, *, effort: Effort
) -> tuple[float, Numbers] | None:
    """Return a value in the caller's units and the state with it, if there is a motion then."""
    value = float(f"{plan.told_value(derivative, own):.6g}")
    state = np.array(plan.problem.end if side == "end" else plan.problem.start)
    state[derivative] = value
    problem = (
        replace(plan.problem, end=state) if side == "end" else replace(plan.problem, start=state)
    )
    numbers = tuple(map(float, state))
    return (value, numbers) if _has_motion(plan, problem, side, effort) else None


def _has_motion(plan: Plan, problem: WholeProblem, mended: str, effort: Effort) -> bool:
    """Tell whether a problem with a start or end from which rest can be reached has a motion.

    Between states of rest there is one where no bound is zero on a side.
    """
    if (problem.start == problem.end).all():
        return True
    own = problem.scaled(plan.length, plan.time)
    other = own if mended == "end" else own.reversed()
    both_ways = not (problem.lower[1:] * problem.upper[1:] == 0.0).any()
    if both_ways and comes_to_rest(other, effort):
        return True
    found = roughly_planned(problem, effort)
    return not found.impossible and found.search.best is not None


def _widen(sign: int) -> str:
    """Return what is to be done to an upper or a lower bound."""
    return "raise" if sign > 0 else "lower"


def _side(plan: Plan, k: int, sign: int) -> float:
    return float((plan.problem.upper if sign > 0 else plan.problem.lower)[k])


def _violated(plan: Plan, link: CostateLink) -> tuple[int, int]:
    """Return the lowest derivative whose bound a proof rests on, and its side."""
    cells = np.array(link.cells)
    atoms, densities = dict(link.atoms), dict(link.densities)
    problem = plan.problem.reversed() if link.free == "end" else plan.problem
    found: list[tuple[int, int, float]] = []
    for k, row in atoms.items():
        mass = np.array(row) + np.array(densities[k]).sum(axis=0) * cells / len(densities[k])
        for sign, part in ((1, np.maximum(-mass, 0.0)), (-1, np.maximum(mass, 0.0))):
            bound = (problem.upper if sign > 0 else problem.lower)[k]
            if part.any():
                size = max(abs(float(bound)), abs(float(problem.start[k])))
                found.append((k, sign, float(part.sum()) * size * link.low**k))
    most = max((weight for *_, weight in found), default=inf)
    notable = ((k, sign) for k, sign, weight in sorted(found) if weight >= _NOTABLE * most)
    k, sign = next(notable, (len(link.ends), 1))
    return k, -sign if link.free == "end" and k % 2 else sign
