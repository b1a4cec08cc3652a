"""Motions of a given duration, or of one that is a whole number of samples."""

from __future__ import annotations

from math import ceil, inf
from typing import TYPE_CHECKING

from .checks import in_range, positive
from .limits import Limits
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .transfers.problem import Problem, Transfer

_ROUNDING = 16.0 * 2.0**-52
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

    At orders 2 and 3 it cruises at a lower velocity. Above it needs the smallest share of the
    highest bound where that is asked for, and else is slowed down as a whole.
    """
    least = move.duration
    wanted = _whole_samples(least if duration is None else positive("duration", duration), round_to)
    if wanted < least * (1.0 - _ROUNDING):
        raise ValueError(
            f"duration = {duration!r} is shorter than the least within these limits, {least!r}: "
            "give that or more, or raise the limits"
        )
    if least == 0.0:
        return move.until(wanted)
    if wanted <= least * (1.0 + _ROUNDING) or limits.order not in (2, 3):
        if gentlest and limits.order > 3 and wanted > least * (1.0 + _NEAR):
            from .optimal.gentlest import gentlest_move  # which loads linear programs

            return gentlest_move(move, limits, wanted)
        return move if wanted == least else move.stretch(wanted / least)
    from .transfers.problem import Problem

    start, end = (float(state[0]) for state in (move.start_state, move.end_state))
    return Problem(start, end, limits).lasting(wanted).trajectory


def transfer_lasting(problem: Problem, duration: float | None, round_to: float | None) -> Transfer:
    """Return a transfer of a duration that is possible.

    Raises
    ------
    ValueError
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
        raise ValueError(
            f"duration = {duration!r} is none that this transfer can take: possible are those "
            f"{_told(possible)}; give one of them, or raise the limits"
        )
    return problem.lasting(wanted)


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
    raise ValueError(
        f"round_to = {round_to!r}: no multiple of it is a duration that this transfer can take; "
        "use a shorter sample time"
    )


def _within(duration: float, interval: tuple[float, float]) -> bool:
    low, high = interval
    return low * (1.0 - _ROUNDING) <= duration <= high * (1.0 + _ROUNDING)


def _told(possible: list[tuple[float, float]]) -> str:
    return ", ".join(
        f"from {low:.10g} on" if high == inf else f"from {low:.10g} to {high:.10g}"
        for low, high in possible
    )
