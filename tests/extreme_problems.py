"""Problems at the edges of what can be planned, by kind and seed; what is wrong with a plan."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from math import inf

import numpy as np
from whole_problems import Bracketed, random_problem

from jounce.shaping import InfeasibleError, Limits
from jounce.shaping.optimal.long_plan import nearer_long_plan
from jounce.shaping.optimal.whole.planner import planned

Pairs = list[tuple[float, float]]


def pairs_of(problem: Bracketed) -> Pairs:
    """Return the bounds on derivatives 1 … n."""
    return [problem.limits.bounds(k) for k in range(1, problem.limits.order + 1)]


def short_ramps(seed: int) -> Bracketed:
    """Return a problem whose highest bound is 10 to 1e10 times what would be active."""
    rng = np.random.default_rng((1, seed))
    problem = random_problem(seed, int(rng.integers(4, 6)), moving=bool(rng.integers(2)))
    *pairs, highest = pairs_of(problem)
    factor = 10.0 ** rng.uniform(1.0, 10.0)
    return _with(problem, [*pairs, (factor * highest[0], factor * highest[1])])


def far_units(seed: int) -> Bracketed:
    """Return a problem in units of 1e-6 to 1e6 of its length and its time."""
    rng = np.random.default_rng((2, seed))
    problem = random_problem(seed, int(rng.integers(4, 7)), moving=bool(rng.integers(2)))
    length, time = 10.0 ** rng.uniform(-6.0, 6.0, 2)
    factors = length / time ** np.arange(problem.limits.order + 1)
    start, end = (
        tuple((np.array(state) * factors[:-1]).tolist()) for state in (problem.start, problem.end)
    )
    pairs = [
        (low * factor, high * factor)
        for (low, high), factor in zip(pairs_of(problem), factors[1:].tolist(), strict=True)
    ]
    return Bracketed("", start, end, Limits.from_bounds(pairs), 0.0, inf)


def far_bounds(seed: int) -> Bracketed:
    """Return a move whose bounds are up to six decades from one another's level."""
    rng = np.random.default_rng((3, seed))
    problem = random_problem(seed, int(rng.integers(4, 7)), moving=False)
    return _with(
        problem,
        [
            (low * factor, high * factor)
            for (low, high), factor in zip(
                pairs_of(problem), 10.0 ** rng.uniform(-3.0, 3.0, 6), strict=False
            )
        ],
    )


def high_orders(seed: int) -> Bracketed:
    """Return a problem of order 7 to 10."""
    return random_problem(seed, 7 + seed % 4, moving=bool(seed % 3 == 2))


def barely_active(seed: int) -> Bracketed:
    """Return a problem with a bound that cuts 1e-9 to 1e-3 off the peak there was without."""
    rng = np.random.default_rng((4, seed))
    problem = random_problem(seed, 4, moving=bool(rng.integers(2)))
    try:
        low, high = _quietly(problem.solve).extremes(k := int(rng.integers(1, 4)))
    except InfeasibleError:
        return problem
    cut = 1.0 - float(rng.choice([-1.0, 1.0])) * 10.0 ** rng.uniform(-9.0, -3.0)
    pairs = pairs_of(problem)
    inside = max(abs(problem.start[k]), abs(problem.end[k]))
    pairs[k - 1] = (min(cut * low, -inside), max(cut * high, inside))
    least, most = sorted(map(abs, pairs[k - 1]))
    return _with(problem, pairs) if least > 1e-3 * most else problem


def on_a_bound(seed: int) -> Bracketed:
    """Return a problem that starts or ends on a bound, with nothing above it."""
    rng = np.random.default_rng((5, seed))
    problem = random_problem(seed, int(rng.integers(4, 6)))
    n = problem.limits.order
    states = [list(problem.start), list(problem.end)]
    for state in states[: int(rng.integers(1, 3))]:
        k = int(rng.integers(1, n))
        side = problem.limits.bounds(k)[int(rng.integers(2))]
        if abs(side) < inf:
            state[k:] = [side, *[0.0] * (n - k - 1)]
    return Bracketed("", tuple(states[0]), tuple(states[1]), problem.limits, 0.0, inf)


def long_holds(seed: int) -> Bracketed:
    """Return a long way at a low velocity: switches without end into the hold and out of it."""
    rng = np.random.default_rng((6, seed))
    problem = random_problem(seed, 4, moving=bool(rng.integers(2)))
    pairs = pairs_of(problem)
    velocity = 10.0 ** rng.uniform(-1.0, 0.3)
    fast = max(abs(problem.start[1]), abs(problem.end[1]), velocity)
    pairs[0] = (-1.1 * fast, 1.3 * fast)
    pairs[1] = (-inf, inf) if rng.integers(2) else pairs[1]
    pairs[2] = (-inf, inf) if rng.integers(2) else pairs[2]
    way = float(rng.choice([-1.0, 1.0])) * fast * 10.0 ** rng.uniform(0.0, 3.0)
    return Bracketed(
        "", problem.start, (way, *problem.end[1:]), Limits.from_bounds(pairs), 0.0, inf
    )


def narrow_stops(seed: int) -> Bracketed:
    """Return a problem between stops that leave from 1e-6 to a tenth of its way."""
    rng = np.random.default_rng((7, seed))
    problem = random_problem(seed, int(rng.integers(3, 5)), moving=bool(rng.integers(2)))
    low, high = sorted((problem.start[0], problem.end[0]))
    room = (high - low) * 10.0 ** rng.uniform(-6.0, -1.0, 2)
    stops = (low - float(room[0]), high + float(room[1]))
    limits = Limits.from_bounds(pairs_of(problem), position=stops)
    return Bracketed("", problem.start, problem.end, limits, 0.0, inf)


KINDS: tuple[Callable[[int], Bracketed], ...] = (
    short_ramps, far_units, far_bounds, high_orders, barely_active, on_a_bound, long_holds,
    narrow_stops,
)  # fmt: skip


def wrong_with(problem: Bracketed) -> str:
    """Return what is wrong with the plan of a problem, "" for nothing.

    A plan keeps all bounds and both states, is no faster than what is proven, and is within the gap
    of it or warns; a problem without is refused with a reason.
    """
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            transfer = problem.solve()
        except InfeasibleError as error:
            return "" if "no motion" in str(error) or "outside" in str(error) else repr(error)
    others = [w for w in told if w.category is not RuntimeWarning or "%" not in str(w.message)]
    if others:
        return f"warned {others[0].message}"
    n = problem.limits.order
    if transfer.start_state[:n].tolist() != list(problem.start):
        return f"starts at {transfer.start_state}"
    if transfer.end_state[:n].tolist() != list(problem.end):
        return f"ends at {transfer.end_state}"
    if transfer.violation(problem.limits) > 1e-12:
        return f"exceeds a bound by {transfer.violation(problem.limits)}"
    if n < 4 and problem.limits.position == (-inf, inf):
        return ""
    states = problem.start, problem.end
    plan = nearer_long_plan(*states, problem.limits, rtol=1e-4)
    least = (plan or planned(*states, problem.limits)).lower_bound
    if not least <= transfer.duration * (1.0 + 1e-12):
        return f"takes {transfer.duration}, proven are {least}"
    if transfer.duration > least * (1.0 + 1.001e-4) and not told:
        return f"takes {transfer.duration}, proven are {least}, without a warning"
    return ""


def _with(problem: Bracketed, pairs: Pairs) -> Bracketed:
    return Bracketed("", problem.start, problem.end, Limits.from_bounds(pairs), 0.0, inf)


def _quietly(call: Callable[[], object]):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return call()
