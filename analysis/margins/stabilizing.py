"""Which gains and which added delays make one loop stable.

Nyquist's criterion counts the unstable poles of the closed loop from what L(jω) does beyond −1.
As a factor of the gain grows the count changes where L passes the negative real axis, and with
an added delay where |L| = 1: all changes, in order, say everywhere how many there are.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .factored_loop import DAMPING_FLOOR, Real
from .many_crossings import OnePieces
from .many_crossings import stable as is_stable_by_count
from .many_gain_and_phase import at_edges, at_limits
from .many_loops import Mask
from .passages import Passages, below, whole_turns
from .turning_points import TOUCH_TOLERANCE

Intervals = tuple[tuple[float, float], ...]

_TURN = 2.0 * np.pi
_MOST = 10_000
_SAME = 1e-12
_REAL = 1e-9


def stabilizing_gains(pieces: OnePieces, found: Passages, *, stable: bool) -> Intervals:
    """Return the intervals of k > 0 for which the loop k·L is stable, ascending.

    Parameters
    ----------
    pieces : Pieces
    found : Passages
        Of the same loop.
    stable : bool
        Whether the loop itself is: where rounding decides, the count at k = 1 gives way to it.
    """
    loops = pieces.loops
    if loops.hidden[0] or _is_real(pieces):
        return ()
    touching = np.concatenate([part[0][0] for part in (at_edges(pieces), at_limits(pieces))])
    touching = touching[np.isfinite(touching)]
    places = np.concatenate([-found.gain, -touching])
    steps = np.concatenate([-2.0 * found.turns, np.zeros(touching.size)])
    if loops.delay[0] and loops.rise[0] == 0:
        places, steps = np.append(places, -loops.limits[1][0]), np.append(steps, np.inf)
    start = float((loops.poles[0].real > 0).sum() + steps[places == -np.inf].sum())
    if not stable:
        places, steps = np.append(places, 0.0), np.append(steps, 0.0)
    some = np.isfinite(places)
    logs = _zeros_of_count(start, (places[some], steps[some]), (-np.inf, np.inf), stable)
    return tuple((float(np.exp(low)), float(np.exp(high))) for low, high in logs)


def stabilizing_delays(pieces: OnePieces, *, stable: bool) -> Intervals:
    """Return the intervals of added delay, in seconds, with which the loop is stable, ascending.

    Those of a loop that is discrete in time are whole samples, and the ends belong to them. No
    more than 10,000 passages of the axis, or samples, are looked at.
    """
    loops = pieces.loops
    if loops.hidden[0] or _stays_on_axis(pieces):
        return ()
    if loops.loop.dt is not None:
        return _stabilizing_samples(pieces, loops.loop.dt, stable)
    if loops.endless[0]:
        return ((0.0, 0.0),) if stable else ()
    found = _stabilizing_delays(pieces, stable)
    if stable or not is_stable_by_count(pieces)[0]:
        return found
    # What is too lightly damped to be called stable stays so behind the least delay.
    return tuple(pair for pair in found if pair[0] > 0.0)


def _stabilizing_delays(pieces: OnePieces, stable: bool) -> Intervals:
    loops, whole = pieces.loops, whole_turns(pieces)
    inner = pieces.crossing[0]
    omega, turns = loops.radians(pieces.omega[0, inner]), _snapped(pieces.turns[0, inner])
    beyond = _beyond(pieces).astype(float)
    steps = 2.0 * (beyond[:-1] - beyond[1:])[inner[1:-1]]
    # Just behind no added delay: what is on the axis now has begun to leave it.
    whole[inner] = np.ceil(turns) - 1.0
    start = _unstable(pieces, whole)
    if not omega.size:
        return ((0.0, np.inf),) if start == 0 else ()
    first = _TURN * (turns - whole[inner]) / omega
    period = _TURN / omega
    counts = np.clip(np.ceil((_last_delay(pieces) - first) / period), 0, _MOST).astype(int)
    places = np.concatenate(
        [d + p * np.arange(n) for d, p, n in zip(first, period, counts, strict=True)]
    )
    soonest = np.argsort(places, kind="stable")[:_MOST]
    places, changes = places[soonest], np.repeat(steps, counts)[soonest]
    return tuple(_zeros_of_count(start, (places, changes), (0.0, places.max(initial=0.0)), stable))


def _stabilizing_samples(pieces: OnePieces, dt: float, stable: bool) -> Intervals:
    """Return the intervals of n·dt for which L(z)·z^(−n) is stable, ends included."""
    loops = pieces.loops
    omega, turns = (part[0] for part in pieces.crossovers)
    omega, turns = loops.radians(omega[~np.isnan(omega)]), turns[~np.isnan(omega)]
    always = not omega.size and not _beyond(pieces).any()
    last = 0.0 if always else min(_last_delay(pieces) / dt, _MOST)
    samples = np.arange(np.ceil(last) + 1.0)
    whole = np.floor(pieces.turns[0] - _lag(samples * dt, loops.radians(pieces.omega[0])))
    whole[:, 0] = whole_turns(pieces)[0]
    high = loops.turns_at_limits[1][0] - 0.25 * loops.rise[0]
    whole[:, -1] = below(high - 0.5 * samples)
    passing = turns - _lag(samples * dt, omega)
    good = (_unstable(pieces, whole) == 0) & (_snapped(passing) != np.rint(passing)).all(axis=1)
    good[0] = stable
    if always:
        return ((0.0, np.inf),) if good.all() else ()
    [changes] = np.nonzero(np.diff(np.concatenate([[0], good, [0]])))
    return tuple((float(a) * dt, float(b - 1) * dt) for a, b in changes.reshape(-1, 2))


def _beyond(pieces: OnePieces) -> Mask:
    """Whether |L| > 1 on each piece, (K − 1,)."""
    gain = pieces.gain[0]
    return np.asarray(gain[:-1] + gain[1:] > 0.0)


def _unstable(pieces: OnePieces, whole: Real) -> Real:
    """Return how many poles of the closed loop are unstable, given the whole turns at edges."""
    encirclements = 2.0 * (np.diff(whole) * _beyond(pieces)).sum(axis=-1)
    return np.asarray((pieces.loops.poles[0].real > 0).sum() - encirclements)


def _lag(delays: Real, radians: Real) -> Real:
    """Return the turns that delays cost at frequencies, (D, K)."""
    return np.multiply.outer(delays, radians) / _TURN


def _last_delay(pieces: OnePieces) -> float:
    """Return an added delay behind which the loop is unstable for good; inf for none."""
    beyond = _beyond(pieces)
    rate = float(np.diff(pieces.loops.radians(pieces.omega[0]))[beyond].sum())
    turns = float(np.diff(pieces.turns[0])[beyond].sum())
    ends = np.sum(np.diff(np.concatenate([[0], beyond, [0]])) > 0) + abs(pieces.loops.power[0])
    return _TURN * (abs(turns) + float(ends) + 1.0) / rate if rate else np.inf


def _is_real(pieces: OnePieces) -> bool:
    """Whether L is real at every frequency, so that its poles lie alike on both sides."""
    quarters = 2.0 * pieces.turns[0]
    static = not pieces.loops.zeros.size + pieces.loops.poles.size + abs(pieces.loops.power[0])
    return not static and bool(np.all(abs(quarters - np.rint(quarters)) <= _REAL))


def _stays_on_axis(pieces: OnePieces) -> bool:
    """Whether L(0) = −1: no delay moves a pole at 0."""
    turns, gain = pieces.loops.turns_at_limits[0][0], pieces.loops.limits[0][0]
    return bool(turns == np.floor(turns) and abs(gain) <= TOUCH_TOLERANCE)


def _snapped(turns: Real) -> Real:
    """Return turns, whole where L lies on −1 but for rounding."""
    near = _TURN * abs(turns - np.rint(turns)) <= DAMPING_FLOOR
    return np.where(near, np.rint(turns), turns)


def _zeros_of_count(
    start: Any, changes: tuple[Real, Real], ends: tuple[float, float], stable: bool
) -> list[tuple[float, float]]:
    """Return the intervals between two ends where a count is 0, as it is at 0 if that is stable.

    `changes` are places and by how much the count steps there.
    """
    order = np.argsort(changes[0], kind="stable")
    edges = np.concatenate([ends[:1], changes[0][order], ends[1:]])
    counts = start + np.concatenate([[0.0], np.cumsum(changes[1][order])])
    low, high = edges[:-1], edges[1:]
    # Logarithms of gains are near one another by their difference, delays by their ratio.
    size = np.fmin(np.fmin(abs(low), abs(high)), 1e300)
    wide = high - low > _SAME * (size if ends[0] == 0.0 else np.maximum(size, 1.0))
    here = (low <= 0.0) & (high > 0.0) & ((low < 0.0) | (ends[0] == 0.0))
    kept = wide & ((counts == 0.0) | (here & stable))
    return list(zip(low[kept].tolist(), high[kept].tolist(), strict=True))
