"""Whether a log kept its limits: peaks used, their error bars, verdicts, and the table."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import Limits
from ...shaping.checks import finite, of_kind, positive
from ...shaping.limits import check_plain, of_one
from .bands import RESOLVED, Band, extent, joint_band, upper_end_holds
from .fit import fit_spline
from .readings import FEWEST, checked_log, found_resolution, merged, parts
from .result import MEASURED, Conformance, Peak
from .spline import SplineFit

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

_SCATTER = 2.0  # standard deviations that the noise adds to the distance of the farthest readings


def conformance(
    times: ArrayLike,
    positions: ArrayLike,
    limits: Limits,
    *,
    resolution: float | None = None,
    tolerance: float = 0.0,
) -> Conformance:
    """Check a log of an encoder against limits: what was used, how surely, and what was kept.

    A smoothing spline is fitted to the readings; its derivatives carry error bars that hold at
    all times at once with probability 0.95 (each derivative by itself). A limit is kept where
    the whole error bar of the peak is within it, broken where the whole of it is outside, and
    otherwise the log cannot tell; nor where it is so coarse that the peak may have been hidden.

    Parameters
    ----------
    times, positions : (N,) array
        At least 16 readings, times strictly increasing; evenly spaced or not.
    limits : Limits
        In the units of the log. Snap and above cannot be taken from a log: a limit on them is
        one that it cannot tell.
    resolution : float, optional
        Distance of two positions that the encoder tells apart: a reading's noise is then at
        least resolution/√12. Left out, noise is known from the readings' scatter alone (from
        their smallest step, where most readings repeat the one before).
    tolerance : float, optional
        Excess over a limit that still keeps it, relative; not negative. A motion planned to run
        at its limit needs one: no error bar ends below the limit then.

    Returns
    -------
    Conformance

    Raises
    ------
    ValueError
        For numbers that are not finite, times that do not increase (naming the row), too few
        readings, or readings all the same without a resolution.

    Notes
    -----
    "Broken" assumes nothing of the motion, only independent errors of readings that are about
    evenly spaced: the lower end of the error bar comes from averages of the derivative, which
    its peak can only exceed. The upper end cannot exclude an excess shorter than
    `resolved_time`, whatever the method: "kept" means as far as can be seen. It is infinite,
    and no limit kept, where even a jump of the derivative below could hide, which is unless

        (2/3)·resolved_time·most_k ≤ least_(k−1)

    with least_0 the distance from the lowest reading to the highest, less twice the noise. A jump
    of x^(k−1) by D, smoothed, shows an upper end of x^(k) of at least D/(0.62·resolved_time):
    what was not seen changed x^(k−1) by less than its peak. Smaller changes may hide still. A
    motion that shows no acceleration, such as one at constant velocity, tells nothing of jerk.
    Where all readings are the same, what moves within a count is not asked for.

    Pauses of a hundred times the usual time between readings part the log: nothing is said of
    what happened meanwhile, nor of parts of less than 16 readings. Vibration that the encoder
    sees is motion and counts; so does a single wrong reading. Errors of the times count as noise:
    one of δ makes velocity·δ.

    On 864 simulated logs of moves of orders 2 to 4 (100 to 20,000 readings, white noise of up
    to 1e-3 of the distance, resolutions of up to 1e-2 of it) all true peaks of velocity and
    acceleration were within the error bars, and at least 98 % of those of jerk. On 3,024 others
    (18 to 4,000 readings; noise and resolutions from 1e-6 of the distance to twenty times it;
    moves of orders 3 and 4, many of them all but jumps of position, velocity or acceleration)
    no upper end of acceleration or jerk was below the true peak, and one of velocity, of a move
    within one reading, below two thirds of it: no other limit exceeded by half could be called
    kept. Of jerk, four logs in five had no upper end.

    Error bars are widest at the ends of a log: let it begin before the motion and
    end after it.

    Examples
    --------
    >>> from jounce.shaping import Limits, min_time_move
    >>> used = Limits(velocity=1.0, acceleration=2.0, jerk=20.0)
    >>> times, states = min_time_move(1.5, used).sample(0.001)
    >>> readings = 1e-5 * np.round(states[0] / 1e-5)
    >>> allowed = Limits(velocity=1.1, acceleration=1.8, jerk=25.0)
    >>> report = conformance(times, readings, allowed, resolution=1e-5)
    >>> [peak.verdict for peak in report.peaks]
    ['kept', 'broken', 'cannot tell']
    """
    of_one(of_kind("limits", limits, Limits, "Limits, such as Limits(velocity=2.0)"))
    check_plain(limits)
    time, position = checked_log(times, positions)
    given = found_resolution(position) if resolution is None else positive("resolution", resolution)
    if not given and not np.ptp(position):
        raise ValueError(
            f"positions are all {float(position[0])!r}: at rest the readings do not show their "
            "own noise; give resolution=…"
        )
    tolerance = finite("tolerance", tolerance)
    if tolerance < 0.0:
        raise ValueError(f"tolerance = {tolerance!r}: expected zero or more, such as 0.01 for 1 %")
    pieces = [part for part in parts(time) if given or np.ptp(position[part])]
    if not pieces:
        raise ValueError(
            f"pauses part the log into pieces of less than {FEWEST} readings, or without motion: "
            "log what moves without pauses"
        )
    fits = [_fit(time[part], position[part], given) for part in pieces]
    bands = tuple(joint_band(fits, k) for k in range(1, MEASURED + 1))
    noise = max(fit.noise for fit in fits)
    resolved_time = min(RESOLVED * max(fit.sharpness for fit in fits), float(np.ptp(time)))
    travel = float(np.ptp(position))
    moved = max(travel - _SCATTER * noise, 0.0) if travel else inf
    holds = upper_end_holds(bands, resolved_time, moved)
    return Conformance(
        peaks=tuple(_peaks(bands, holds, limits, tolerance)),
        bands=bands,
        limits=limits,
        readings=len(time),
        left_out=len(time) - sum(part.stop - part.start for part in pieces),
        resolution=given,
        noise=noise,
        longest_gap=float(np.diff(time).max()),
        resolved_time=resolved_time,
    )


def _fit(times: FloatArray, positions: FloatArray, resolution: float) -> SplineFit:
    middles, values, share = merged(times, positions)
    return fit_spline(middles, values, resolution / sqrt(12.0 * share))


def _peaks(
    bands: tuple[Band, ...], holds: tuple[bool, ...], limits: Limits, tolerance: float
) -> Iterator[Peak]:
    """Yield the peaks of all that is measured, or limited."""
    for k in range(1, max(MEASURED, limits.order) + 1):
        lower, upper = limits.bounds(k)
        if k > MEASURED and (lower, upper) == (-inf, inf):
            continue
        ways = {1: upper, -1: -lower} if upper != -lower else {0: upper}
        for direction, limit in ways.items():
            used, least, most, time = nan, 0.0, inf, nan
            if k <= MEASURED:
                used, least, most, time = extent(bands[k - 1], direction)
                most = most if holds[k - 1] else inf
            yield Peak(k, direction, used, least, most, time, limit, tolerance)
