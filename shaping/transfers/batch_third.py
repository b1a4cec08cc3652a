"""Many transfers of order 3 at once: the arcs of `third_order` on arrays.

Every arc of every problem is one lane. The distances at the ends and turning points of all lanes
are found together, and the roots between them by one bracketed Newton iteration of those lanes
that can hold the shortest.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..pieces import FloatArray
from .batch_tasks import Indices, Mask, Profiles, Tasks, mirror_where, put, take
from .jerk_profile import Profile, ramp, travelled
from .task import ROUNDING

_profile: Any = Profile  # of arrays

_FREE_Q, _FREE_P, _HOLD, _DWELL, _BOTH = range(5)
_ITERATIONS = 2000
_FAR = 2.0**100


class _Arcs(NamedTuple):
    """Arcs of one kind: the problem each belongs to, and the range of its parameter."""

    kind: int
    problem: Indices
    first: FloatArray
    last: FloatArray


class _Shared:
    """What the arcs of a problem share, as `third_order.Family` has it."""

    def __init__(self, tasks: Tasks) -> None:
        self.tasks = tasks
        rise, fall, v0, a0, v1, a1 = (
            tasks.rise,
            tasks.fall,
            tasks.v0,
            tasks.a0,
            tasks.v1,
            tasks.a1,
        )
        self.kappa = kappa = 0.5 / rise + 0.5 / fall
        speed, turn = np.maximum(np.abs(v0), np.abs(v1)), np.maximum(np.abs(a0), np.abs(a1))
        self.noise = ROUNDING * (speed + kappa * turn * turn)
        c = v1 - v0 + (a0 - a1) * (a0 + a1) * 0.5 / rise
        self.c = np.where(np.abs(c) <= self.noise, 0.0, c)
        self.ratio = self.c / kappa
        self.v_in, self.v_out = v0 - a0 * a0 * 0.5 / rise, v1 - a1 * a1 * 0.5 / rise
        self.p_cruise = self._to_cruise(tasks.v_max - self.v_in, np.maximum(a0, 0.0))
        self.q_cruise = -self._to_cruise(tasks.v_max - self.v_out, np.maximum(-a1, 0.0))
        lowest = tasks.v_min - ROUNDING * np.abs(tasks.v_min) - self.noise
        self.may_dip = (a1 <= 0.0) | (self.v_out >= lowest)
        self.may_rise = (a0 >= 0.0) | (self.v_in >= lowest)
        self.usable = (a0 <= tasks.a_max) & (a1 >= tasks.a_min)
        jerk = np.minimum(rise, fall)
        stop = speed / np.minimum(tasks.a_max, -tasks.a_min) + np.sqrt(speed / jerk) + turn / jerk
        self.blur = tasks.resolution + ROUNDING * (np.abs(tasks.distance) + speed * stop)

    def _to_cruise(self, gain: FloatArray, least: FloatArray) -> FloatArray:
        square = gain / self.kappa
        slack = (ROUNDING * np.abs(self.tasks.v_max) + self.noise) / self.kappa
        near = np.where(square >= least * least - slack, least, -np.inf)
        root = np.sqrt(np.maximum(square, 0.0))
        return np.where(np.isinf(gain), np.inf, np.where(square > least * least, root, near))

    def _root(self, square: FloatArray) -> FloatArray:
        """Return roots of squared accelerations, rounding about zero taken for zero."""
        return np.where(square * self.kappa > self.noise, np.sqrt(np.maximum(square, 0.0)), 0.0)

    def _root_or_none(self, square: FloatArray) -> FloatArray:
        return np.where(square * self.kappa >= -self.noise, self._root(square), -np.inf)

    def arcs(self) -> list[_Arcs]:
        """Return the arcs as `Family.arcs` has them, kind by kind."""
        tasks, ratio = self.tasks, self.ratio
        a0, a1, p_max, q_min = tasks.a0, tasks.a1, tasks.a_max, tasks.a_min
        in_q, in_p = self.usable & self.may_rise, self.usable & self.may_dip
        bottom = np.where(self.may_dip, np.maximum(q_min, self.q_cruise), 0.0)
        top = np.where(self.may_rise, np.minimum(p_max, self.p_cruise), 0.0)
        least = np.where(a0 > 0.0, self._root(a0 * a0 - ratio), 0.0)
        most = self._root_or_none(p_max * p_max - ratio)
        where = in_q & (ratio >= 0.0)
        arcs = [
            _arcs(_FREE_Q, where, np.minimum(a1, most), least),
            _arcs(_FREE_Q, where, np.minimum(a1, -least), np.maximum(bottom, -most)),
        ]
        least = np.where(a1 < 0.0, self._root(a1 * a1 + ratio), 0.0)
        most = self._root_or_none(q_min * q_min + ratio)
        where = in_p & (ratio < 0.0)
        arcs += [
            _arcs(_FREE_P, where, np.maximum(a0, -most), -least),
            _arcs(_FREE_P, where, np.maximum(a0, least), np.minimum(top, most)),
            _arcs(_FREE_P, in_p & (ratio == 0.0) & (a0 <= a1) & (a1 < 0.0), a1, a1),
        ]
        least, where = self._root(p_max * p_max - ratio), in_q & (p_max < np.inf)
        arcs += [
            _arcs(_HOLD, where, np.minimum(a1, p_max), least),
            _arcs(_HOLD, where, np.minimum(a1, -least), bottom),
        ]
        least, where = self._root(q_min * q_min + ratio), in_p & (q_min > -np.inf)
        arcs += [
            _arcs(_DWELL, where, np.maximum(a0, q_min), -least),
            _arcs(_DWELL, where, np.maximum(a0, least), top),
        ]
        square = self.kappa * p_max * p_max
        begin = np.maximum(self.c - square + self.kappa * q_min * q_min, 0.0) / p_max
        end = (tasks.v_max - self.v_in - square) / p_max
        return [*arcs, _arcs(_BOTH, where & in_q & (p_max < np.inf), begin, end)]


def _arcs(kind: int, where: Mask, first: FloatArray, last: FloatArray) -> _Arcs:
    """Return the arcs that exist, those in q with falling and the others with rising parameter."""
    in_order = last <= first if kind in (_FREE_Q, _HOLD) else first <= last
    [problem] = np.nonzero(where & in_order)
    return _Arcs(kind, problem, first[problem], last[problem])


class _Lanes:
    """Arcs side by side, one kind after another."""

    def __init__(self, shared: _Shared) -> None:
        arcs = shared.arcs()
        self.shared = shared
        self.problem = np.concatenate([arc.problem for arc in arcs])
        self.first = np.concatenate([arc.first for arc in arcs])
        self.last = np.concatenate([arc.last for arc in arcs])
        self.kind = np.repeat([arc.kind for arc in arcs], [len(arc.problem) for arc in arcs])

    def look(self, lanes: Indices) -> _View:
        """Return a view of some lanes, in increasing order."""
        return _View(self.shared, self.kind[lanes], self.problem[lanes])


class _View:
    """The profiles of some lanes as functions of their parameters."""

    def __init__(self, shared: _Shared, kind: Indices, problem: Indices) -> None:
        self.tasks = take(shared.tasks, problem)
        self.kappa, self.c = shared.kappa[problem], shared.c[problem]
        self.ratio, self.v_in = shared.ratio[problem], shared.v_in[problem]
        edges = np.searchsorted(kind, range(6))
        self._kinds = [slice(*edges[k : k + 2]) for k in range(5)]

    def profile(self, s: FloatArray) -> Profiles:
        """Return the members at parameters s, as `Family.profile`."""
        tasks, kappa, c, ratio = self.tasks, self.kappa, self.c, self.ratio
        p, q, hold, dwell = s.copy(), s.copy(), np.zeros_like(s), np.zeros_like(s)
        free_q, free_p, held, dwelling, both = self._kinds
        p[free_q] = np.maximum(np.sqrt(ratio[free_q] + s[free_q] ** 2), tasks.a0[free_q])
        q[free_p] = np.minimum(-np.sqrt(s[free_p] ** 2 - ratio[free_p]), tasks.a1[free_p])
        p[held] = tasks.a_max[held]
        q[dwelling] = tasks.a_min[dwelling]
        p[both], q[both] = tasks.a_max[both], tasks.a_min[both]
        lack = c - kappa * (p - q) * (p + q)
        hold[held] = np.maximum(lack[held] / p[held], 0.0)
        dwell[dwelling] = np.maximum(lack[dwelling] / q[dwelling], 0.0)
        hold[both] = s[both]
        dwell[both] = np.maximum((lack[both] - p[both] * s[both]) / q[both], 0.0)
        moving = (p - tasks.a0) / tasks.rise + (p - q) / tasks.fall + (tasks.a1 - q) / tasks.rise
        duration = np.maximum(moving, 0.0) + hold + dwell
        return _profile(duration, p, hold, np.zeros_like(s), q, dwell)

    def duration_slope(self, profile: Profiles) -> Any:
        """Return the derivative of the duration by the parameter."""
        p, q = profile.p, profile.q
        slope = np.empty_like(p)
        free_q, free_p, held, dwelling, both = self._kinds
        for some in (free_q, held):
            slope[some] = 2.0 * self.kappa[some] * (q[some] / p[some] - 1.0)
        for some in (free_p, dwelling):
            slope[some] = 2.0 * self.kappa[some] * (1.0 - p[some] / q[some])
        slope[both] = 1.0 - p[both] / q[both]
        return slope

    def error(self, profile: Profiles) -> Any:
        """Return the excess of the distance, its derivative by the duration, and its rounding."""
        tasks = self.tasks
        distance, slope, v, w = travelled(tasks, profile)
        fastest = np.maximum(
            np.maximum(np.abs(tasks.v0), np.abs(v)), np.maximum(np.abs(w), np.abs(tasks.v1))
        )
        return distance - tasks.distance, slope, fastest * profile.duration

    def turning_points(self) -> FloatArray:
        """Return parameters (2, M) at which the distance may turn, NaN where there are none."""
        tasks, kappa, ratio, v_in = self.tasks, self.kappa, self.ratio, self.v_in
        free_q, free_p, held, dwelling, both = self._kinds
        a, b, c = np.empty((3, len(kappa)))
        free = slice(0, free_p.stop)
        rise, fall = tasks.rise, tasks.fall
        a[free] = 0.125 / rise[free] + 0.25 / fall[free]
        b[free] = v_in[free] + 0.25 * ratio[free] * (1.0 / rise[free] + 1.0 / fall[free])
        c[free] = 0.125 * ratio[free] ** 2 / rise[free]
        for some, bound, level in (
            (held, tasks.a_max, v_in + self.c),
            (dwelling, tasks.a_min, v_in),
        ):
            a[some] = kappa[some]
            b[some], c[some] = -0.5 * bound[some] / fall[some], level[some]
        p, q = tasks.a_max[both], tasks.a_min[both]
        level = v_in[both] + 0.5 * p * p / rise[both] + 0.5 * p * (p - q) / fall[both]
        points = _quadratic(a, b, c)
        width = np.sqrt(points[:, free])
        sign = np.where(np.arange(free.stop) < free_q.stop, -0.5, 0.5)
        points[:, free] = sign * width + 0.5 * ratio[free] / width
        points[:, both] = -level / p
        return points


def _quadratic(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return the real roots (2, M) of a·x² + b·x + c, NaN where there are none."""
    half = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
    return np.array([half / a, c / half])


def fastest(tasks: Tasks) -> tuple[Tasks, Profiles, Mask]:
    """Return the tasks, some of them mirrored, their shortest profiles, and which are mirrored.

    A duration is infinite where there is no profile. The quickest change from (v0, a0) to
    (v1, a1) covers a distance d. Where the durations of such changes have no gap, which takes
    accelerations of one sign, the distances that can be covered grow continuously from d both
    ways, and the sign of what is missing tells the family.
    """
    falls = tasks.distance < _distance_of_change(tasks)
    tasks = mirror_where(falls, tasks)
    best = _furthest(tasks)
    [others] = np.nonzero((tasks.a0 * tasks.a1 > 0.0) | np.isinf(best.duration))
    if others.size:
        opposite = take(tasks, others).mirror()
        second = _furthest(opposite)
        shorter = second.duration < best.duration[others]
        replaced = others[shorter]
        tasks = put(tasks, replaced, take(opposite, shorter))
        best = put(best, replaced, take(second, shorter))
        falls[replaced] ^= True
    return tasks, best, falls


def _distance_of_change(tasks: Tasks) -> FloatArray:
    """Return the distance that the fastest change of velocity covers, as `change_velocity`."""
    a0, a1 = tasks.a0, tasks.a1
    straight = (a1 - a0) * (a1 + a0) * np.where(a1 >= a0, 0.5 / tasks.rise, -0.5 / tasks.fall)
    falls = tasks.v1 - tasks.v0 < straight
    tasks = mirror_where(falls, tasks)
    rise, fall, a0, a1 = tasks.rise, tasks.fall, tasks.a0, tasks.a1
    kappa = 0.5 / rise + 0.5 / fall
    square = (tasks.v1 - tasks.v0 + 0.5 * a0 * a0 / rise + 0.5 * a1 * a1 / fall) / kappa
    peak = np.maximum(np.sqrt(np.maximum(square, 0.0)), np.maximum(a0, a1))
    holds = peak > tasks.a_max
    hold = np.where(holds, kappa * (square / tasks.a_max - tasks.a_max), 0.0)
    peak = np.minimum(peak, tasks.a_max)
    x, v = ramp(tasks.v0, a0, peak, rise)
    x += (v + 0.5 * peak * hold) * hold + ramp(v + peak * hold, peak, a1, -fall)[0]
    return np.asarray(np.where(falls, -x, x))


def _furthest(tasks: Tasks) -> Profiles:
    """Return the shortest profile of each family; its duration is infinite where there is none."""
    shared = _Shared(tasks)
    best, lanes = _cruising(shared), _Lanes(shared)
    if lanes.problem.size:
        _improve(best, lanes, *_events(lanes, best.duration))
    return best


def _improve(best: Profiles, lanes: _Lanes, chosen: Indices, s: FloatArray) -> None:
    """Put the profiles of some lanes in the place of longer ones."""
    profile, problem = lanes.look(chosen).profile(s), lanes.problem[chosen]
    shortest = np.full(len(best.duration), np.inf)
    np.minimum.at(shortest, problem, profile.duration)
    better = (profile.duration == shortest[problem]) & (profile.duration < best.duration[problem])
    for kept, new in zip(best, profile, strict=True):
        kept[problem[better]] = new[better]


def _cruising(shared: _Shared) -> Profiles:
    """Return the profiles that cruise at v_max, as `Family.cruising`."""
    tasks, p, q = shared.tasks, shared.p_cruise, shared.q_cruise
    usable = shared.usable & shared.may_dip & shared.may_rise & (tasks.v_max > 0.0)
    usable &= (p >= 0.0) & (p < np.inf) & (q > -np.inf) & (q <= 0.0)
    p, q = np.where(usable, p, 0.0), np.where(usable, q, 0.0)
    hold = np.where(
        p > tasks.a_max, shared.kappa * (p / tasks.a_max - 1.0) * (p + tasks.a_max), 0.0
    )
    dwell = np.where(
        q < tasks.a_min, shared.kappa * (q / tasks.a_min - 1.0) * (-q - tasks.a_min), 0.0
    )
    p, q = np.minimum(p, tasks.a_max), np.maximum(q, tasks.a_min)
    ends = (p - tasks.a0) / tasks.rise + (p - q) / tasks.fall + (tasks.a1 - q) / tasks.rise
    ends = np.maximum(ends, 0.0) + hold + dwell
    profile = _profile(ends, p, hold, np.zeros_like(p), q, dwell)
    rest = tasks.distance - travelled(tasks, profile)[0]
    slack = 4.0 * ROUNDING * np.abs(tasks.v_max) * ends + shared.blur
    cruise = np.maximum(rest, 0.0) / tasks.v_max
    duration = np.where(usable & (rest >= -slack), ends + cruise, np.inf)
    return profile._replace(duration=duration, cruise=cruise)


def _events(lanes: _Lanes, known: FloatArray) -> tuple[Indices, FloatArray]:
    """Return for lanes that may hold the shortest profile the first parameter that fits."""
    view = lanes.look(np.arange(lanes.problem.size))
    nodes = _nodes(lanes, view)
    errors, durations = np.empty_like(nodes), np.empty_like(nodes)
    blur = lanes.shared.blur[lanes.problem]
    for k, s in enumerate(nodes):
        profile = view.profile(s)
        error, _, scale = view.error(profile)
        fits = np.abs(error) <= 4.0 * ROUNDING * scale + blur
        errors[k], durations[k] = np.where(fits, 0.0, error), profile.duration
    fits = errors == 0.0
    crosses = errors[:-1] * errors[1:] < 0.0
    # events in order of duration: node 0, then what lies between 0 and 1, node 1, …
    events = np.empty((2 * len(nodes) - 1, len(view.kappa)), dtype=bool)
    events[::2], events[1::2] = fits, crosses
    first = events.argmax(axis=0)
    lane = np.arange(len(first))
    some = events[first, lane]
    low, high = first // 2, (first + 1) // 2
    soonest, latest = durations[low, lane], durations[high, lane]
    bound = known.copy()
    np.minimum.at(bound, lanes.problem[some], latest[some])
    [chosen] = np.nonzero(some & (soonest <= bound[lanes.problem] * (1.0 + ROUNDING)))
    s = nodes[low[chosen], chosen]
    [between] = np.nonzero(low[chosen] != high[chosen])
    roots = chosen[between]
    s[between] = _roots(
        lanes, roots, s[between], nodes[high[roots], roots], errors[low[roots], roots]
    )
    return chosen, s


def _nodes(lanes: _Lanes, view: _View) -> FloatArray:
    """Return the ends of the arcs and the turning points between them, in order (4, M)."""
    first, last = lanes.first, lanes.last
    low, high = np.minimum(first, last), np.maximum(first, last)
    turns = view.turning_points()
    turns = np.where((low < turns) & (turns < high), turns, first)
    falling = last < first
    least, most = np.minimum(*turns), np.maximum(*turns)
    nodes = np.array([first, np.where(falling, most, least), np.where(falling, least, most), last])
    endless = np.isinf(last)
    if endless.any():
        nodes[3, endless] = _far(lanes, np.nonzero(endless)[0], nodes[2, endless])
    return nodes


def _far(lanes: _Lanes, some: Indices, s: FloatArray) -> FloatArray:
    """Return parameters beyond which the distance is exceeded for good."""
    view, step = lanes.look(some), np.where(lanes.last[some] > 0.0, 1.0, -1.0)
    while True:
        error, slope, _ = view.error(view.profile(s + step))
        short = ~((slope > 0.0) & (error > 0.0)) & (np.abs(step) < _FAR)
        if not short.any():
            return np.asarray(s + step)
        step = np.where(short, 2.0 * step, step)


def _roots(
    lanes: _Lanes, chosen: Indices, s: FloatArray, other: FloatArray, error: FloatArray
) -> FloatArray:
    """Return the parameters between s and other at which the distance is right.

    The error at s is given; Newton steps, halved where they leave the bracket.
    """
    roots = 0.5 * (s + other)
    active, view, wrong_side = np.arange(len(chosen)), lanes.look(chosen), error < 0.0
    middle, running = roots.copy(), np.ones(len(chosen), dtype=bool)
    for _ in range(_ITERATIONS):
        profile = view.profile(middle)
        error, slope, scale = view.error(profile)
        before = (error < 0.0) == wrong_side
        s, other = np.where(before, middle, s), np.where(before, other, middle)
        following = middle - error / (slope * view.duration_slope(profile))
        low, high = np.minimum(s, other), np.maximum(s, other)
        inside = (low < following) & (following < high)
        following = np.where(inside, following, 0.5 * (s + other))
        roots[active[running]] = middle[running]
        running &= (np.abs(error) > 2.0**-52 * scale) & (following != middle)
        running &= (following != s) & (following != other)
        left = np.count_nonzero(running)
        if left == 0:
            break
        if 2 * left < len(running):
            active, chosen, s, other = active[running], chosen[running], s[running], other[running]
            wrong_side, following, view = (
                wrong_side[running],
                following[running],
                lanes.look(chosen),
            )
            running = np.ones(left, dtype=bool)
        middle = following
    return roots


def pieces(tasks: Tasks, profiles: Profiles) -> tuple[FloatArray, FloatArray]:
    """Return durations (7, N) and states (7, 4, N) of the pieces, positions from the start on."""
    rise, fall, p, q = tasks.rise, tasks.fall, profiles.p, profiles.q
    nothing = np.zeros_like(p)
    cruises = profiles.cruise > 0.0
    x1, v1 = ramp(tasks.v0, tasks.a0, p, rise)
    x2, v2 = x1 + (v1 + 0.5 * p * profiles.hold) * profiles.hold, v1 + p * profiles.hold
    step, w = ramp(tasks.v1, tasks.a1, q, rise)  # backwards in time
    y5 = tasks.distance + step
    y4, w4 = y5 - (w - 0.5 * q * profiles.dwell) * profiles.dwell, w - q * profiles.dwell
    y3 = y4 - ramp(tasks.v_max, nothing, q, -fall)[0]
    top = np.where(cruises, tasks.v_max, nothing)
    durations = np.maximum(
        [
            (p - tasks.a0) / rise,
            profiles.hold,
            np.where(cruises, p, p - q) / fall,
            profiles.cruise,
            np.where(cruises, -q, nothing) / fall,
            profiles.dwell,
            (tasks.a1 - q) / rise,
        ],
        0.0,
    )
    states = np.array(
        [
            [nothing, tasks.v0, tasks.a0, rise],
            [x1, v1, p, nothing],
            [x2, v2, p, -fall],
            [x2 + ramp(v2, p, nothing, -fall)[0], top, nothing, nothing],
            [y3, top, nothing, -fall],
            [y4, w4, q, nothing],
            [y5, w, q, rise],
        ]
    )
    return durations, states
