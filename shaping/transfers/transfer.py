"""Transfers between two states of motion in minimum time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ... import core
from ..checks import finite
from ..limits import Limits
from .problem import Problem, State, Transfer, check_order, checked_state


def min_time_transfer(
    start: State,
    end: State,
    limits: Limits,
    *,
    duration: float | None = None,
    round_to: float | None = None,
    rtol: float = 1e-4,
) -> Transfer:
    """Return the fastest motion from one state to another within limits of order 2 to 10.

    Parameters
    ----------
    start, end : (position, velocity[, acceleration, …])
        In the limits' units, derivatives below the order n. Numbers left out are zero; a single
        number is a position at rest. The highest derivative may follow, as
        `trajectory.evaluate(t)` gives it (at the very end `trajectory.end_state`, as it coasts
        from there on); it may jump and is not used.
    limits : Limits
        Of order 2 (velocity and acceleration) to 10, each bound the same in both directions or
        not, absent or zero on a side; positions bounded or not.
    duration : float, optional
        How long it is to take. What is possible need not be an interval: an axis that moves at
        its start and end may pass quickly, or turn back and pass again. The motion is the one
        that needs the smallest share of the bound on the highest derivative, unless it starts
        outside its bounds.
    round_to : float, optional
        Sample time: the duration is rounded up to a whole number of samples.
    rtol : float, optional
        How near to the proven minimum the duration is to come, relative, where it is not exact.

    Returns
    -------
    Transfer
        Starting at time 0, of order n. At orders 2 and 3, positions free, a start outside its
        bounds, or bound to leave them, is brought inside as fast as the limits allow, and the
        transfer planned from there: `inside_after` is the time that this takes.

    Raises
    ------
    InfeasibleError
        Where the end cannot be reached within the limits. It names the bound, and the nearest
        value that can be reached or the time at which the bound would be exceeded. Or where it
        cannot be in the duration given.
    ValueError
        For numbers that are not finite, limits of another order, a highest bound in one direction
        only, or times outside the range of a double.

    Warns
    -----
    RuntimeWarning
        Where the search ends before `rtol` is reached: it says what is proven.

    Notes
    -----
    At orders 4 and above, with bounds on position or bounds that are zero on a side, linear
    programs over the whole horizon find motions from above and exclude durations from below, on
    grids that are refined until both meet (`certify` has the proof). It takes 20 to 120 ms at
    order 4, 0.1 to 0.5 s at orders 5 and 6, 0.3 to 2 s at orders 7 and 8, some up to ten. The
    search ends by a count of the work done, after ten seconds or so, at worst thirty, with what is
    known then. Motions long against their ramps are planned and proven by their ramps;
    where a highest bound, or several, takes less than 2 % of the motion, it is planned and proven
    with fewer derivatives, then averaged. A duration above four times the least is taken by a
    rest in between, where there is time for one, unless a motion without is gentler: the share of
    the highest bound is then the smallest of those tried.

    Otherwise the minimum is exact: the structures of both families are enumerated,
    and the one unknown of each is found to the last bit. End state and bounds hold to 1e-10
    relative to the motion's own scale, and neither depends on the units: problems are scaled by
    powers of two first. Bounds more than three decades apart between the two directions cost
    digits: 1e-9 at six decades, 1e-4 at ten. Only the way to the end is held to the limits; an end
    at v_max with acceleration left is reached, and leaves them afterwards.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section II (order 2); Berscheid & Kröger, 2021 (order 3);
    Wang & Hu, arXiv 2311.07039 and 2403.17675, for the problem at higher orders.

    Examples
    --------
    >>> limits = Limits(velocity=1.0, acceleration=1.0, jerk=2.0)
    >>> round(min_time_transfer((0.0, 0.3), 1.0, limits).duration, 10)
    2.2319602829
    """
    if duration is None and round_to is None:
        try:  # as `_at_once` does: a call would be a tenth of the time that a transfer takes
            found = core.transfer(start, end, limits.flat, Transfer, limits)
        except (AttributeError, TypeError, ValueError):
            found = core.UNREACHABLE
        if type(found) is Transfer:
            return found
    if isinstance(limits, Limits) and (limits.order > 3 or not limits.plain):
        from .whole_transfer import whole_transfer

        return whole_transfer(start, end, limits, (duration, round_to), rtol)
    if duration is not None or round_to is not None:
        from ..lasting import transfer_lasting

        return transfer_lasting(Problem(start, end, limits), duration, round_to)
    return Problem(start, end, limits).fastest()


def velocity_transfer(
    start: State,
    velocity: float,
    limits: Limits,
    *,
    acceleration: float = 0.0,
    relative: bool = False,
) -> Transfer:
    """Return the fastest change to another velocity, wherever it ends.

    Parameters
    ----------
    start : (position, velocity[, acceleration])
        As in `min_time_transfer`.
    velocity : float
        At the end; from the start's where `relative`.
    limits : Limits
        Of order 2 or 3.
    acceleration : float, optional
        At the end; order 3 only.
    relative : bool, optional

    Returns
    -------
    Transfer
        Starting at time 0.

    Raises
    ------
    InfeasibleError, ValueError
        As in `min_time_transfer`.

    References
    ----------
    MEI, "S-Curve Jerk Algorithm": velocity moves.

    Examples
    --------
    >>> spin_up = velocity_transfer(0.0, 2.0, Limits(acceleration=1.0, jerk=1.0))
    >>> spin_up.duration, float(spin_up.end_state[0])
    (3.0, 3.0)
    """
    if not relative and type(acceleration) is float and not acceleration:
        found = _at_once(core.velocity_transfer, start, (0.0, velocity), limits)
        if found is not None:
            return found
    check_order(limits)
    position, v0, a0 = checked_state("start", start, limits)
    velocity = finite("end velocity", velocity) + (v0 if relative else 0.0)
    acceleration = finite("end acceleration", acceleration)
    if limits.order == 2 and acceleration != 0.0:
        raise ValueError(
            f"acceleration = {acceleration!r}: at order 2 it may jump and cannot be asked for; "
            "leave it out, or bound jerk as well"
        )
    end = position, velocity, acceleration
    return Problem((position, v0, a0), end, limits).change_of_velocity()


def _at_once(
    plan: Callable[..., Transfer | int], start: Any, end: Any, limits: Any
) -> Transfer | None:
    """Return what the core plans of plain numbers; None for others, which are told or converted."""
    try:
        found = plan(start, end, limits.flat, Transfer, limits)
    except (AttributeError, TypeError, ValueError):
        return None
    return found if type(found) is Transfer else None
