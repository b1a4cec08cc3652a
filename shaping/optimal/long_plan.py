"""Plans much longer than their ramps: onto the velocity bound, a cruise, and to the end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from ..endings import ended
from ..limits import Limits
from ..trajectory import Trajectory
from ..transfers.infeasible import InfeasibleError
from .proof import CruisingLink, Numbers, Proof, Proven, TaylorLink
from .ramp_reach import Reach, reach, told_by_farthest, told_by_links
from .whole.outcome import found_plan
from .whole.planner import Plan, planned
from .whole.polynomials import first_root
from .whole.search import Link as Excluded
from .whole.warm_program import EFFORT

_RAMPS = 3.0  # times what a ramp may take: the way in which the program goes onto the bound, or off
_LONG = 2.0  # times both ways: a motion that is planned as these and a cruise
_ROUGHLY = 1e-3  # gap of a ramp that counts for little
_SHARES = (2.0 / 3.0, 0.5, 1.0)  # of that way: ends of a ramp that are tried
_EFFORT = 0.06 * EFFORT  # for each
_FURTHER = 3.0  # times the ways: the second trial
_ROUNDING = 1e-12  # of the lower bound, taken off it


@dataclass(frozen=True, eq=False)
class LongPlan:
    """A motion of two ramps and a cruise, and what is proven of the minimum time."""

    trajectory: Trajectory
    proven: Proven

    @property
    def lower_bound(self) -> float:
        """No motion takes less."""
        return self.proven.lower_bound

    @property
    def gap(self) -> float:
        """How much longer the motion takes than that at most, relative."""
        return self.trajectory.duration / self.lower_bound - 1.0


def long_plan(
    start: Numbers, end: Numbers, limits: Limits, *, rtol: float, speed: float | None = None
) -> LongPlan | None:
    """Return a plan that cruises for most of its way; None for one that is not as long.

    Programs over the whole horizon need cells as short as its ramps. The ramps are planned by
    themselves, in the least time to a place beyond them, and nothing changes in between. As the
    velocity is held there the costate is (1, 0, …, 0), so that the multipliers of both ramps
    bound the distance from the start, that to the end, and that of the cruise apart.

    `speed` is another velocity to cruise at, below the bound.

    Raises
    ------
    InfeasibleError
        For a start or an end that is a dead end.
    """
    if end[0] < start[0]:
        ahead = long_plan(_opposite(start), _opposite(end), limits.mirror(), rtol=rtol, speed=speed)
        return None if ahead is None else _mirrored(ahead)
    distance, bound = end[0] - start[0], limits.bounds(1)[1]
    turned = tuple((-1) ** (k + 1) * x for k, x in enumerate(end))
    ways = _way(start, limits), _way(turned, _backwards(limits))
    best: LongPlan | None = None
    for further in (1.0, _FURTHER):
        if not (0.0 < bound < inf and distance > _LONG * further * sum(ways)):
            break
        over = further * ways[0], further * ways[1]
        plan = _planned(start, end, limits, over, min(speed or bound, bound), rtol)
        if plan is None or speed is not None or plan.gap <= rtol:
            return plan or best
        best = plan if best is None or plan.gap < best.gap else best
    return best


def nearer_long_plan(
    start: Numbers, end: Numbers, limits: Limits, *, rtol: float
) -> LongPlan | None:
    """Return `long_plan`; None also where a short search over the whole horizon comes nearer."""
    plan = long_plan(start, end, limits, rtol=rtol)
    if plan is None or plan.gap <= rtol:
        return plan
    whole = planned(start, end, limits, rtol, effort=_EFFORT)
    return None if whole.search.gap < plan.gap else plan


def _planned(
    start: Numbers,
    end: Numbers,
    limits: Limits,
    ways: tuple[float, float],
    cruise: float,
    rtol: float,
) -> LongPlan | None:
    """Return the plan forwards whose ramps take no longer ways than these."""
    distance = end[0] - start[0]
    turned = tuple((-1) ** (k + 1) * x for k, x in enumerate(end))
    aim = min(max(rtol, rtol * distance / sum(ways) / _LONG), max(rtol, _ROUGHLY))
    onto = _ramp(start, ways[0], cruise, limits, aim)
    off = _off(turned, ways[1], cruise, limits, aim)
    if onto is None or off is None:
        return None
    dwell = (distance - float(onto.problem.end[0] + off.problem.end[0])) / cruise
    ridden = _motion(off).reverse().mirror()
    motion = ended(_motion(onto).shift(start[0]).then(ridden, dwell=dwell), end)
    if limits.bounds_position and motion.violation(limits) > _ROUNDING:
        return None
    order = min(_proving_order(onto), _proving_order(off))
    for told in (told_by_links, told_by_farthest):
        ahead = reach(onto, order, told), reach(off, order, told)
        plan = LongPlan(motion, _proven(start[:order], end[:order], limits, *ahead))
        if plan.gap <= rtol:
            break
    return plan


def _backwards(limits: Limits) -> Limits:
    """Return the limits of x(t) → −x(−t)."""
    swapped = [
        (low, high) if k % 2 else (-high, -low)
        for k, (low, high) in enumerate(map(limits.bounds, range(limits.order + 1)))
    ]
    return Limits.from_bounds(swapped[1:], position=swapped[0])


def _way(state: Numbers, limits: Limits) -> float:
    """Return more than the way onto the velocity bound; infinite where nothing tells."""
    bound, time = limits.bounds(1)[1], 0.0
    sizes = [abs(bound - state[1]), *map(abs, state[2:])]
    for k in range(2, limits.order + 1):
        least = min(abs(side) for side in limits.bounds(k))
        if 0.0 < least < inf:
            lower = enumerate(sizes[: k - 1], start=1)
            time += max((size / least) ** (1.0 / (k - below)) for below, size in lower)
    return _RAMPS * max(bound, abs(state[1])) * (time or inf)


def _ramp(state: Numbers, way: float, cruise: float, limits: Limits, rtol: float) -> Plan | None:
    """Return the plan from a state, its position 0, onto the velocity bound; None beside a stop.

    Where the search takes long for one place of its end it need not for another.
    """
    low, high = limits.position[0] - state[0], limits.position[1] - state[0]
    if way > high:
        return None
    pairs = zip(limits.lower, limits.upper, strict=True)
    within = Limits.from_bounds(pairs, position=(low, high) if limits.bounds_position else None)
    start, cruising = (0.0, *state[1:]), (cruise, *[0.0] * (limits.order - 2))
    best: Plan | None = None
    for share in _SHARES:
        plan = planned(start, (share * way, *cruising), within, rtol, effort=_EFFORT)
        if plan.impossible:
            break
        if best is None or plan.search.gap < best.search.gap:
            best = plan
        if plan.search.gap <= rtol:
            return plan
    if best is not None and best.search.best is not None:
        return best
    try:
        return found_plan(start, (way, *cruising), within, rtol=rtol)
    except InfeasibleError:
        if limits.bounds_position:
            return None
        raise


def _off(turned: Numbers, way: float, cruise: float, limits: Limits, rtol: float) -> Plan | None:
    """Return the plan of the way to the end, run backwards; errors tell of the end."""
    try:
        return _ramp(turned, way, cruise, _backwards(limits), rtol)
    except InfeasibleError:
        cruising = (cruise, *[0.0] * (limits.order - 2))
        end = tuple((-1) ** (k + 1) * x for k, x in enumerate(turned))
        found_plan((0.0, *cruising), (way, *end[1:]), limits, rtol=rtol)
        raise


def _motion(plan: Plan) -> Trajectory:
    assert plan.trajectory is not None  # of a plan that is found
    return plan.trajectory


def _proving_order(plan: Plan) -> int:
    """Return up to which derivative the bounds count in the last link of a plan's proof."""
    link = plan.search.chain[-1] if plan.search.chain else None
    return len(link.multipliers.ends) if isinstance(link, Excluded) else plan.problem.order


def _proven(start: Numbers, end: Numbers, limits: Limits, onto: Reach, off: Reach) -> Proven:
    """Return the bound of ramps and a cruise between them, for a motion forwards.

    As many bounds count as the states have derivatives.
    """
    n, distance, bound = len(start), end[0] - start[0], limits.bounds(1)[1]
    terms = onto.terms + off.terms
    cruise = (distance - float(terms.sum())) / bound
    time = onto.time + cruise + off.time
    terms[1] += bound * cruise
    masses = onto.masses + np.where(np.arange(n + 1) % 2, off.masses, -off.masses[::-1])
    masses[1, 1] += cruise
    slopes = -masses * time / float(np.arange(n + 1) @ terms)
    left = -terms / time ** np.arange(n + 1.0)
    left[0] += distance
    first = distance / bound * (1.0 - _ROUNDING)
    lower = max(first_root(left, first, time * (1.0 - _ROUNDING)), first)
    links: tuple[TaylorLink | CruisingLink, ...] = (TaylorLink(0.0, first, 0, 1, 1),)
    if lower > first:
        links += (CruisingLink(first, lower, 1, onto.ramp, off.ramp, cruise),)
    if not any((*start[1:], *end[1:])):
        links = links[-1:]
    sides = np.array([limits.bounds(k) for k in range(n + 1)]).T
    shares = (slopes * np.where(slopes == 0.0, 0.0, sides)).sum(axis=0)[1:] / time
    sides[:, 0] -= start[0]
    least, most = (tuple(side) for side in sides.tolist())
    ends = (0.0, *start[1:]), (distance, *end[1:])
    pairs = tuple((low, high) for low, high in (slopes.T + 0.0).tolist())
    return Proven(
        lower, tuple((shares + 0.0).tolist()), pairs, Proof(*ends, least, most, links, lower)
    )


def _opposite(numbers: Numbers) -> Numbers:
    return tuple(0.0 - x for x in numbers)


def _mirrored(plan: LongPlan) -> LongPlan:
    """Return the plan of the opposite direction."""
    proven, proof = plan.proven, plan.proven.proof
    sides = (_opposite(row) for row in (proof.start, proof.end, proof.upper, proof.lower))
    start, end, lower, upper = sides
    links = tuple(
        replace(link, sign=-1)
        for link in proof.links
        if isinstance(link, TaylorLink | CruisingLink)
    )
    opposite = Proof(start, end, lower, upper, links, proof.lower_bound)
    slopes = tuple((0.0 - high, 0.0 - low) for low, high in proven.slopes)
    mirrored = Proven(proven.lower_bound, proven.sensitivities, slopes, opposite)
    return LongPlan(plan.trajectory.mirror().shift(0.0), mirrored)
