"""Motions of a given duration, or of one that is a whole number of samples."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, inf
from typing import TYPE_CHECKING

from .checks import in_range, positive
from .endings import slowed_to
from .limits import Limits
from .trajectory import Trajectory
from .transfers.infeasible import InfeasibleError

if TYPE_CHECKING:
    from .transfers.problem import Problem, Transfer

_ROUNDING = 16.0 * 2.0**-52
_LEAST = -300.0  # exponent of two of a share that counts as none
_SAME_SHARE = 2e-13  # of exponents
_NEAR = 1e-6  # relative: durations between which a move is slowed down as a whole


def move_lasting(
    move: Trajectory,
    limits: Limits,
    duration: float | None,
    round_to: float | None,
    *,
    gentlest: bool,
) -> Trajectory:
    """Return the fastest move from rest to rest, made to last as long as is asked for.

    It needs the smallest share of the highest bound, at orders 2 and 3 exactly; from order 4 on
    where that is asked for: else it is slowed down as a whole.
    """
    least = move.duration
    wanted = _whole_samples(least if duration is None else positive("duration", duration), round_to)
    if wanted < least * (1.0 - _ROUNDING):
        raise InfeasibleError(
            f"duration = {duration!r} is shorter than the least within these limits, {least!r}: "
            "give that or more, or raise the limits",
            "",
        )
    if least == 0.0:
        return move.until(wanted)
    if wanted <= least * (1.0 + _ROUNDING) or limits.order not in (2, 3):
        if gentlest and limits.order > 3 and wanted > least * (1.0 + _NEAR):
            from .optimal.gentlest import gentlest_move  # which loads linear programs

            return gentlest_move(move, limits, wanted)
        return move if wanted == least else slowed_to(move, wanted)
    from .transfers.problem import Problem

    start, end = (float(state[0]) for state in (move.start_state, move.end_state))
    return _gentlest(Problem(start, end, limits), wanted).trajectory


def transfer_lasting(problem: Problem, duration: float | None, round_to: float | None) -> Transfer:
    """Return a transfer of a duration that is possible.

    Raises
    ------
    InfeasibleError
        For a duration that the transfer cannot take: it names those next to it.
    """
    fastest = problem.fastest()
    if duration is None:
        wanted = _next_multiple(fastest.duration, round_to, problem)
    else:
        wanted = _whole_samples(positive("duration", duration), round_to)
    if abs(wanted - fastest.duration) <= _ROUNDING * wanted:
        return fastest
    possible = problem.possible_durations()
    if not any(_within(wanted, interval) for interval in possible):
        raise InfeasibleError(
            f"duration = {duration!r} is none that this transfer can take: possible are those "
            f"{_told(possible)}; give one of them, or raise the limits",
            "",
        )
    return _gentlest(problem, wanted)


def _gentlest(problem: Problem, duration: float) -> Transfer:
    """Return the transfer of a possible duration with the smallest share of the highest bound.

    Whatever a share allows a larger one does, too: bisected to the last bits. A start that leaves
    its bounds is brought inside with all of it.
    """
    from .transfers.problem import Transfer

    if problem.fastest().inside_after or problem.start == problem.end:
        return problem.lasting(duration)
    high, step, best = 0.0, 1.0, problem  # of the share's logarithm
    while high > _LEAST and (found := _with_share(problem, high - step, duration)) is not None:
        high, step, best = high - step, 2.0 * step, found
    low = high - step
    while high - low > _SAME_SHARE:
        share = 0.5 * (low + high)
        found = _with_share(problem, share, duration)
        low, high, best = (share, high, best) if found is None else (low, share, found)
    if any((*best.start[1:], *best.end[1:])):
        return replace(best.lasting(duration), limits=problem.limits)
    fastest = best.fastest().trajectory
    return Transfer(slowed_to(fastest, duration), problem.limits)


def _with_share(problem: Problem, exponent: float, duration: float) -> Problem | None:
    """Return the problem with 2^exponent of the highest bound; None if it has no such duration."""
    *lower, (least, most) = zip(problem.limits.lower, problem.limits.upper, strict=True)
    share, n = 2.0**exponent, problem.limits.order
    try:
        within = Limits.from_bounds([*lower, (share * least, share * most)])
        less = type(problem)(problem.start[:n], problem.end[:n], within)
        if less.fastest().inside_after:
            return None
        possible = any(_within(duration, interval) for interval in less.possible_durations())
    except ValueError:  # an end that cannot be reached any more, or a time beyond doubles
        return None
    return less if possible else None


def _whole_samples(duration: float, round_to: float | None) -> float:
    """Return a duration, rounded up to a multiple of a sample time if there is one."""
    if round_to is None:
        return duration
    dt = positive("round_to", round_to)
    return in_range(lambda: ceil(duration / dt * (1.0 - _ROUNDING)) * dt)


def _next_multiple(least: float, round_to: float | None, problem: Problem) -> float:
    """Return the shortest possible duration that is a whole number of samples."""
    wanted = _whole_samples(least, round_to)
    if wanted == least:
        return wanted
    for interval in problem.possible_durations():
        wanted = _whole_samples(max(interval[0], least), round_to)
        if _within(wanted, interval):
            return wanted
    raise InfeasibleError(
        f"round_to = {round_to!r}: no multiple of it is a duration that this transfer can take; "
        "use a shorter sample time",
        "",
    )


def _within(duration: float, interval: tuple[float, float]) -> bool:
    low, high = interval
    return low * (1.0 - _ROUNDING) <= duration <= high * (1.0 + _ROUNDING)


def _told(possible: list[tuple[float, float]]) -> str:
    return ", ".join(
        f"from {low:.10g} on" if high == inf else f"from {low:.10g} to {high:.10g}"
        for low, high in possible
    )
