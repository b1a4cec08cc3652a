"""Several axes at once: started, ended or both together, or kept on a straight line."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from ... import core
from ..checks import one_of
from ..limits import Limits, of_one
from ..real_numbers import shown
from ..trajectory import Motion
from .axes import Given, as_axis
from .modes import MODES, Mode
from .problem import Transfer
from .synchronized import Synchronized, tied_together
from .transfer import min_time_transfer


def synchronize(
    transfers: Iterable[Given],
    mode: Mode = "both",
    *,
    resultant: Limits | Motion | None = None,
) -> Synchronized:
    """Return the transfers of several axes, tied together in time.

    Parameters
    ----------
    transfers : iterable of Trajectory, (start, end, limits) or (start, end)
        One per axis: what `min_time_transfer`, `min_time_move`, `s_curve_move` or another shaper
        returns, or what the first two are planned with (from rest to rest at other orders than 2
        and 3). Orders and kinds may be mixed. Units may differ between axes but for that of time.
    mode : "start", "end", "both" or "straight-line"
        "start": all start at time 0, each takes its own minimum time. "end": all end together,
        the faster ones waiting at rest first. "both": all take the shortest duration that every
        axis can take. "straight-line": one profile for all, so that the axes stay on the line
        from start to end even where that is slower; the axes' limits all hold. Of an axis whose
        limits are not known (a move, an S-curve) the peaks of its motion hold.
    resultant : Limits or Trajectory, optional
        For a straight line: bounds of the motion along it, L·s(t) with L² = Σ R_i², which hold
        besides those of the axes; or that motion itself, a distance of L, such as
        `s_curve_move(L, …)`, slowed down as a whole where an axis asks for it. An axis may then
        be (start, end), without limits of its own.

    Returns
    -------
    Synchronized
        A tuple of trajectories, in the order given, that can be modified under way; of a straight
        line its `resultant` is the motion along it.

    Raises
    ------
    InfeasibleError
        For an end that an axis cannot reach, or axes that have no duration in common.
    ValueError
        For an unknown mode, no axis at all, "end" with an axis that must wait but moves at its
        start, or "straight-line" with velocities or accelerations off the line, or with a motion
        not from rest to rest whose limits are not known or not all of one order; for a resultant
        in another mode, or one that does not go as far as the axes.

    Notes
    -----
    The durations that an axis can take need not be an interval: one that moves at its start and
    end may be able to pass quickly, or to turn back and pass again, and take no time in between.
    "both" takes the shortest duration that lies in an interval of every axis. An axis with time to
    spare goes to a lower velocity, keeps it, and goes to its end; where the time is too short
    for that, its motion is a weighted mean of those that go furthest up and furthest down in
    that time. A move of order 1, 4 or more, or an S-curve, has no limits to plan anew within: from
    rest to rest it is slowed down as a whole, x(t) → x(t/c), which divides derivative k by c^k,
    and otherwise it keeps its own duration.

    The profile of a "straight-line" of moves is the motion of one of the axes, slowed down until
    the others keep their bounds, or `min_time_move` within the bounds of all, if that is faster.

    Examples
    --------
    >>> pan, tilt = synchronize([
    ...     (0.0, 90.0, Limits(velocity=30.0, acceleration=20.0)),
    ...     (0.0, 10.0, Limits(velocity=30.0, acceleration=20.0)),
    ... ])
    >>> pan.duration, tilt.duration, round(tilt.peak("velocity"), 3)
    (4.5, 4.5, 2.28)
    >>> x, y = synchronize(
    ...     [(0.0, 3.0), (0.0, 4.0)], "straight-line", resultant=Limits(velocity=2.0)
    ... )
    >>> round(x.peak("velocity"), 12), round(y.peak("velocity"), 12)
    (1.2, 1.6)
    """
    one_of("mode", mode, MODES)
    if type(transfers) is not list and (
        isinstance(transfers, Motion) or not isinstance(transfers, Iterable)
    ):
        told = f"transfers = {shown(transfers)}: expected a list with one entry per axis"
        raise TypeError(told)
    if resultant is not None:
        _check_resultant(resultant, mode)
    transfers = [given if type(given) is Transfer else _planned(given) for given in transfers]
    if not transfers:
        raise ValueError("transfers is empty: expected at least one axis")
    if mode == "both":
        together = _in_the_core(transfers)
        if together is not None:
            return together
    axes = [as_axis(number, given, resultant) for number, given in enumerate(transfers)]
    return tied_together(axes, mode, resultant)


def _check_resultant(resultant: object, mode: Mode) -> None:
    if mode != "straight-line":
        raise ValueError(
            f"resultant = {shown(resultant)} with mode = {mode!r}: it holds along a line, use "
            "mode='straight-line'"
        )
    if not isinstance(resultant, Motion):
        of_one(resultant)


def _planned(given: Given) -> Given:
    """Return the transfer between two states within limits; anything else as it is given."""
    if type(given) in (tuple, list) and len(given) == 3:
        with suppress(TypeError, ValueError):  # a move, or an error to be told with its number
            return min_time_transfer(*given)
    return given


def _in_the_core(transfers: list[Given]) -> Synchronized | None:
    """Return transfers as they were planned, slowed down to one duration; None for others."""
    try:
        found = core.together(tuple(transfers), Transfer)
    except (AttributeError, TypeError, ValueError):  # made from arrays, or of another kind
        return None
    if isinstance(found, int):
        return None
    motions, limits = found
    return Synchronized.of(motions, "both", limits)
