"""Plans between any states as callers see them: checked, told why there is none, or how sure."""

from __future__ import annotations

import warnings
from math import inf

import numpy as np

from ...derivatives import derivative_name
from ...limits import Limits, check_both_sides
from ...transfers.infeasible import InfeasibleError, inside
from ..proof import CostateLink, TaylorLink
from .planner import DEFAULT_RTOL, HIGHEST_ORDER, Numbers, Plan, planned

_NOTABLE = 0.05  # of the largest contribution to a proof: a bound that it rests on


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
    plan = planned(begin, finish, limits, rtol)
    if plan.impossible:
        raise impossible(plan)
    if plan.search.best is None:
        raise InfeasibleError(
            f"no motion was found: every duration up to {plan.lower_bound:.10g} is impossible, of "
            "longer ones nothing is known; move the states away from their bounds",
            "",
            None,
        )
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
            raise InfeasibleError(
                f"no motion within the limits leads from rest to rest: with a bound of 0 on {name} "
                f"the {below} never comes back to zero; raise that bound",
                name,
                None,
            )


def warn_if_far(plan: Plan, rtol: float, duration: float, stacklevel: int = 4) -> None:
    """Warn where the gap that was asked for is not reached: what is known holds."""
    gap = duration / plan.lower_bound - 1.0
    if gap > rtol * (1.0 + 1e-9):
        warnings.warn(
            f"this motion takes at most {100.0 * gap:.2g} % more than the minimum time, which is "
            f"proven to be at least {plan.lower_bound:.10g}: the search ended before the gap of "
            f"{rtol:g} that was asked for",
            RuntimeWarning,
            stacklevel=stacklevel,
        )


def impossible(plan: Plan) -> InfeasibleError:
    """Return the error for a problem that is proven to have no motion: which bound, and when."""
    link = plan.proof.links[-1]
    if isinstance(link, TaylorLink):
        name = derivative_name(link.remainder)
        return InfeasibleError(
            f"no motion within the limits leads to the end, in whatever time: the {name} bound "
            f"{_side(plan, link.remainder, link.sign):g} stands in the way; raise it, or choose "
            f"another {derivative_name(link.derivative)} at the end",
            name,
            None,
        )
    assert isinstance(link, CostateLink)
    k, sign, share = _violated(plan, link)
    name, highest = derivative_name(k), derivative_name(plan.problem.order)
    bound = _side(plan, k, sign)
    if link.free:
        time = link.low * share
        side, when = ("start", "after it") if link.free == "start" else ("end", "before it")
        verb = "leaves" if link.free == "start" else "leads to"
        return InfeasibleError(
            f"no motion within the limits {verb} the {side}: {name} would exceed its bound "
            f"{bound:g} about {time:.3g} {when}, whatever the {highest}; raise that bound, or "
            "choose smaller derivatives there",
            name,
            None,
            time if link.free == "start" else -time,
        )
    return InfeasibleError(
        f"no motion within the limits leads from the start to the end, in whatever time: the "
        f"{name} bound {bound:g} stands in the way; raise it",
        name,
        None,
    )


def _side(plan: Plan, k: int, sign: int) -> float:
    return float((plan.problem.upper if sign > 0 else plan.problem.lower)[k])


def _violated(plan: Plan, link: CostateLink) -> tuple[int, int, float]:
    """Return the lowest derivative whose bound a proof rests on, its side, and the mean time."""
    cells = np.array(link.cells)
    rights = np.cumsum(cells)
    atoms, densities = dict(link.atoms), dict(link.densities)
    problem = plan.problem.reversed() if link.free == "end" else plan.problem
    found: list[tuple[float, int, int, float]] = []
    for k, row in atoms.items():
        mass = np.array(row) + np.array(densities[k]).sum(axis=0) * cells / len(densities[k])
        for sign, part in ((1, np.maximum(-mass, 0.0)), (-1, np.maximum(mass, 0.0))):
            bound = (problem.upper if sign > 0 else problem.lower)[k]
            if part.any():
                size = max(abs(float(bound)), abs(float(problem.start[k])))
                weight = float(part.sum()) * size * link.low**k
                when = float(part @ (rights - 0.5 * cells) / part.sum())
                found.append((weight, k, sign, when))
    most = max((weight for weight, *_ in found), default=inf)
    found.sort(key=lambda told: told[1])
    last = (most, problem.order, 1, 0.0)
    _, k, sign, when = next((told for told in found if told[0] >= _NOTABLE * most), last)
    if link.free == "end" and k % 2:
        sign = -sign
    return k, sign, when
