"""How far a move is from the minimum time: a rigorous lower bound, and what each limit costs."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path

import numpy as np

from ..checks import in_range, positive
from ..derivatives import derivative_name
from ..limits import Limits, of_one
from ..pieces import evaluate
from ..told import Told
from ..trajectory import Motion, Trajectory, as_trajectory
from ..transfers.infeasible import InfeasibleError
from .half_bounds import proven_by_half
from .long_plan import long_plan
from .proof import Numbers, Proof, Proven, Slopes, number
from .proof_check import holds
from .proof_slopes import tells_truly
from .quick_bounds import least_duration
from .smoothing import even_are_symmetric, lower_order, relative_width, truncated
from .whole.outcome import check_whole
from .whole.planner import HIGHEST_ORDER, Plan, planned
from .whole.warm_program import Effort

_ROUNDING = 1e-12  # of the gap that a certificate tells
_AT_REST = 1e-9  # of a derivative's peak
_TARGETS = (1.0, 0.5, 0.2)  # of the gap asked for: searches, the next where one was not enough


@dataclass(frozen=True, repr=False)
class Certificate(Told):
    """A proof of how near a motion is to the minimum time under its limits.

    Attributes
    ----------
    duration : float
        Of the motion.
    lower_bound : float
        No motion between these states within the limits is faster.
    gap : float
        duration / lower_bound − 1.
    sensitivities : tuple of float
        dT/dL_k·L_k/T of the lower bound, velocity first, both sides of a bound changed alike: −0.2
        for jerk says that raising its limit by 1 % saves 0.2 %. From rest to rest, positions
        free, Σ_k k·sensitivity_k = −1; all zero where nothing is proven.
    slopes : tuple of pairs of float
        dT/d(lower bound) and dT/d(upper bound) of the lower bound, position first: what a bound of
        one side alone costs, one of zero or on position too.
    rtol : float
        The gap that was asked for.
    proof : Proof or None
        The proof as data; None where nothing is proven, `lower_bound` being zero.
    """

    duration: float
    lower_bound: float
    gap: float
    sensitivities: tuple[float, ...]
    slopes: Slopes
    rtol: float
    proof: Proof | None = None

    @property
    def reached(self) -> bool:
        """Whether the gap is as small as was asked for; the bound holds in any case."""
        return self.gap <= self.rtol

    def __str__(self) -> str:
        if not self.lower_bound > 0.0:
            return f"{self.duration:.10g}: nothing is proven of the minimum time"
        return (
            f"{self.duration:.10g}: at most {100.0 * self.gap:.2g} % more than the minimum time, "
            f"which is proven to be at least {self.lower_bound:.10g}"
        )

    def check(self) -> bool:
        """Tell whether the proof holds, by rational arithmetic alone (`proof_check`).

        What it says besides has to fit: duration, bound and gap, and what the bound hangs on.
        """
        proof = self.proof
        if proof is None:
            return self.lower_bound == 0.0 and self.gap == (inf if self.duration > 0.0 else 0.0)
        if not 0.0 < self.lower_bound <= min(proof.lower_bound, self.duration * (1.0 + _AT_REST)):
            return False
        gap = max(self.duration / self.lower_bound - 1.0, 0.0)
        fits = abs(self.gap - gap) <= _ROUNDING * (1.0 + gap)
        return fits and holds(proof) and tells_truly(proof, self.slopes, self.sensitivities)

    def save(self, path: str | Path) -> None:
        """Write the certificate with its proof to a file of JSON."""
        own = {name: value for name, value in vars(self).items() if name != "proof"}
        own["gap"] = None if self.gap == inf else self.gap
        proof = None if self.proof is None else json.loads(self.proof.text())
        Path(path).write_text(json.dumps({**own, "proof": proof}), encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> Certificate:
        """Return the certificate that `save` wrote.

        Raises
        ------
        ValueError
            For a file that is none.
        """
        text = Path(path).read_text(encoding="utf-8")
        try:
            data = json.loads(text)
            proof = data["proof"]
            return cls(
                number(data["duration"]),
                number(data["lower_bound"]),
                number(data["gap"], inf),
                tuple(map(float, data["sensitivities"])),
                tuple((float(low), float(high)) for low, high in data["slopes"]),
                positive("rtol", number(data["rtol"])),
                None if proof is None else Proof.from_text(json.dumps(proof)),
            )
        except (KeyError, TypeError, AttributeError, ValueError):
            raise ValueError(
                f"{str(path)!r} holds no certificate: expected what certificate.save wrote"
            ) from None


def certify(trajectory: Motion, limits: Limits, *, rtol: float = 1e-4) -> Certificate:
    """Prove how much faster a motion between its two states could be at most.

    From rest to rest, positions free and bounds on even derivatives the same in both directions,
    for any multipliers λ and measures μ_k every motion within the limits has

        R/2 ≤ L_n·∫|p| dt + Σ_k L_k·‖μ_k‖ = Σ_k c_k·L_k·(T/2)^k

    with p the costate that they give (weak duality); the root T is a lower bound. A linear
    program proposes the multipliers, on meshes refined until the gap is at most `rtol` or no
    longer shrinks; the bound is then evaluated from them alone, in extended precision, with a
    margin for rounding. No error of the solver can make it wrong. Between any states, under any
    bounds, the like holds over the whole horizon: each set of multipliers excludes the durations
    for which a polynomial is positive, and a chain of them covers all from zero to the bound.

    Parameters
    ----------
    trajectory : Trajectory
        Within the limits; its start and end are the states that are meant.
    limits : Limits
        Of order 2 to 10 unless the motion is from rest to rest, positions free. Above order 10 of
        bounds that differ between the directions the mean counts for even derivatives: the lower
        bound is then true but need not be near. It is 0 where no derivative is bounded in both
        directions and velocity not in that of the move.
    rtol : float, optional
        Gap to be reached. It cannot be less than what the move itself is slower than need be.

    Returns
    -------
    Certificate
        `reached` tells whether the gap came down to `rtol`.

    Raises
    ------
    ValueError
        For a motion that breaks its limits by more than 1e-9 or jumps in a derivative that is
        bounded, one between moving states under limits of other orders, or an rtol that is not
        positive.

    Notes
    -----
    Moves of `min_time_move` come to a gap of 1e-5…1e-4, with limits many decades apart to 1e-3, in
    0.05 to 0.5 s; some take 1.5 s, and up to 15 s from order 8 on where the gap asked for is out of
    reach. Ramps of 1e-2 to 1e-4 of the duration may be too short for the program at orders 6 and
    above: the gap is then about as large as they are. Above order 10 the bounds up to derivative 10
    count. For n ≤ 3 and for perfect splines the gap is that of rounding and of the solver's
    tolerance, some 1e-9, but not where bounds of even derivatives differ between the directions.

    References
    ----------
    Weak duality of linear programs in function space; Wang & Hu, arXiv 2311.07039, for the
    problem.

    Examples
    --------
    >>> limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    >>> from jounce.shaping import min_time_move
    >>> proof = certify(min_time_move(1.0, limits), limits)
    >>> proof.reached
    True
    >>> [round(s, 3) for s in proof.sensitivities]
    [-0.375, -0.125, -0.125]
    """
    rtol = positive("rtol", rtol)
    move, limits = as_trajectory(trajectory), of_one(limits)
    _check(move, limits)
    rests = _at_rest(move, limits.order)
    if np.array_equal(move.start_state[: limits.order], move.end_state[: limits.order]):
        return _certificate(move.duration, limits, rtol, None)
    if rests and (not 2 <= limits.order <= HIGHEST_ORDER or _has_half(limits)):
        proven = in_range(lambda: proven_by_half(move, limits, rtol))
        if _is_poor(proven, move.duration, limits, rtol):
            whole = in_range(lambda: _by_whole(move, limits, rtol, rests))
            proven = max(proven or whole, whole, key=lambda each: each.lower_bound)
    else:
        check_whole(limits)
        proven = in_range(lambda: _by_whole(move, limits, rtol, rests))
    return _certificate(move.duration, limits, rtol, proven)


def proven_excess(trajectory: Motion, limits: Limits) -> float:
    """Return how much longer than need be a move from rest to rest takes at most, T/T_lower − 1.

    Told in a few milliseconds, fifteen at order 8: T_lower is the exact minimum under the bounds
    up to jerk, or the duration of the perfect spline of one bound alone if that is longer. It says
    what a move of method="closed-form" may lose; `certify` proves how much it does lose.

    Parameters
    ----------
    trajectory : Trajectory
        From rest to rest, within the limits.
    limits : Limits

    Returns
    -------
    float
        0.02 for at most 2 % more than the minimum time; infinite where nothing is known of that.

    Raises
    ------
    ValueError
        For a motion that breaks its limits, jumps in a derivative that is bounded, or does not
        start and end at rest.

    Examples
    --------
    >>> from jounce.shaping import min_time_move
    >>> limits = Limits(velocity=2.0, acceleration=(-4.0, 8.0), jerk=60.0, snap=2000.0)
    >>> quick = min_time_move(1.0, limits, method="closed-form")
    >>> round(proven_excess(quick, limits), 3), round(certify(quick, limits).gap, 3)
    (0.062, 0.03)
    """
    move, limits = as_trajectory(trajectory), of_one(limits)
    _check(move, limits)
    if not _at_rest(move, limits.order):
        raise ValueError(
            "the trajectory starts or ends in motion: proven_excess takes moves from rest to rest; "
            "certify takes any"
        )
    distance = float(move.end_state[0] - move.start_state[0])
    least = in_range(lambda: least_duration(distance, limits)) if distance else 0.0
    if not least > 0.0:
        return inf if move.duration > 0.0 else 0.0
    return max(move.duration / least - 1.0, 0.0)


def _has_half(limits: Limits) -> bool:
    """Tell whether moves within limits can be taken odd about their middle."""
    return limits.plain and even_are_symmetric(limits)


def _is_poor(proven: Proven | None, duration: float, limits: Limits, rtol: float) -> bool:
    """Tell whether the whole horizon may prove more than the half does.

    So it is where bounds on odd derivatives are decades apart, which the half sees less well.
    """
    uneven = limits.order <= HIGHEST_ORDER and not limits.symmetric
    if not uneven or not all(map(isfinite, limits.bounds(limits.order))):
        return False
    return proven is None or duration > proven.lower_bound * (1.0 + rtol)


def _certificate(
    duration: float, limits: Limits, rtol: float, proven: Proven | None
) -> Certificate:
    n = limits.order
    if proven is None or not 0.0 < proven.lower_bound <= duration * (1.0 + _AT_REST):
        gap = inf if duration > 0.0 else 0.0
        return Certificate(duration, 0.0, gap, (0.0,) * n, ((0.0, 0.0),) * (n + 1), rtol)
    lower = proven.lower_bound
    slopes = (*proven.slopes, *[(0.0, 0.0)] * n)[: n + 1]
    shares = (*proven.sensitivities, *[0.0] * n)[:n]
    gap = max(duration / lower - 1.0, 0.0)
    return Certificate(duration, lower, gap, shares, slopes, rtol, proven.proof)


def _by_whole(move: Trajectory, limits: Limits, rtol: float, rests: bool) -> Proven:
    """Return what one effort proves, of fewer derivatives where the highest ones spoil it."""
    n, effort = limits.order, Effort()
    best = _by_ramps(move, limits, rtol, rests)
    for order in _orders(limits, move.duration, rtol):
        if best is not None and (
            move.duration <= best.lower_bound * (1.0 + rtol) or effort.left <= 0.0
        ):
            break
        low, high = limits.bounds(order)
        if not -inf < low < 0.0 < high < inf:
            continue
        states = _states(move, order, rests)
        if order == n:
            plan = planned(*states, limits)
        else:
            plan = planned(*states, truncated(limits, order), effort=effort.left)
            effort = Effort(plan.search.effort.left)
        found = _refined(move.duration, plan, rtol, effort)
        if best is None or found.lower_bound > best.lower_bound:
            best = Proven(found.lower_bound, found.sensitivities, found.slopes, found.proof)
    assert best is not None
    return best


def _orders(limits: Limits, duration: float, rtol: float) -> list[int]:
    """Return the orders to be tried: the highest first, unless its ramps hardly take any time."""
    low, orders = lower_order(limits), list(range(limits.order, 1, -1))
    short = low > 1 and relative_width(limits, low, duration) <= rtol
    return [low, *orders] if short else orders


def _states(move: Trajectory, order: int, rests: bool) -> tuple[Numbers, Numbers]:
    start, end = (
        (float(state[0]), *(0.0 if rests else float(x) for x in state[1:order]))
        for state in (move.start_state, move.end_state)
    )
    return start, end


def _by_ramps(move: Trajectory, limits: Limits, rtol: float, rests: bool) -> Proven | None:
    """Return what ramps and a cruise prove; None where the motion is not as long."""
    start, end = _states(move, limits.order, rests)
    try:
        plan = long_plan(start, end, limits, rtol=rtol)
        if plan is None or move.duration <= plan.lower_bound * (1.0 + rtol):
            return None if plan is None else plan.proven
        finer = long_plan(start, end, limits, rtol=_TARGETS[-1] * rtol)
    except InfeasibleError:  # or a ramp was not found
        return None
    assert finer is not None
    return max((plan, finer), key=lambda each: each.lower_bound).proven


def _refined(duration: float, plan: Plan, rtol: float, effort: Effort) -> Plan:
    """Return a plan searched for long enough to prove what there is to prove."""
    for target in _TARGETS:
        if duration <= plan.lower_bound * (1.0 + rtol) or plan.search.gap <= target * rtol:
            break
        if duration > plan.lower_bound * (1.0 + plan.search.gap) * (1.0 + rtol):
            break  # it is the motion that is slow
        if effort.left <= 0.0:
            break
        plan = plan.refined(target * rtol, effort)
    return plan


def _at_rest(trajectory: Trajectory, order: int) -> bool:
    return all(
        not state[k] or abs(float(state[k])) <= _AT_REST * trajectory.peak(k)
        for state in (trajectory.start_state, trajectory.end_state)
        for k in range(1, min(order, trajectory.order))
    )


def _check(trajectory: Trajectory, limits: Limits) -> None:
    """Refuse a motion that is not within the limits."""
    jump = _lowest_jump(trajectory)
    if len(trajectory.states) and jump < limits.order:
        name, highest = derivative_name(jump), derivative_name(limits.order)
        raise ValueError(
            f"{name} jumps, so that {highest} is unbounded: certify this move under limits up "
            f"to the derivative after {name} at most"
            if jump
            else "position jumps: certify takes continuous motions"
        )
    excess = trajectory.violation(limits)
    if excess > _AT_REST:
        raise ValueError(
            f"the trajectory exceeds a limit by {100.0 * excess:.3g} %: certify a move within "
            "its limits"
        )


def _lowest_jump(trajectory: Trajectory) -> int:
    """Return the lowest derivative that jumps between two pieces, or after the last."""
    ends = evaluate(trajectory.states.T, trajectory.durations, range(trajectory.order + 1)).T
    after = np.vstack([trajectory.states[1:], trajectory.end_state])
    jumps = np.abs(ends - after).max(axis=0, initial=0.0)
    for k in range(trajectory.order):
        if jumps[k] > _AT_REST * trajectory.peak(k):
            return k
    return trajectory.order
