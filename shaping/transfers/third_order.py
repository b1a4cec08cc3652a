"""Transfers with bounded jerk: the two families of profiles among which the fastest is.

For a given duration the profile that goes furthest has the acceleration

    rise to p, hold, fall to q, hold, rise to a1,    p ≤ a_max, q ≥ a_min, holds only at the bounds,

broken by a cruise at v_max where the fall crosses zero: the costate of the acceleration is convex
in time. With κ = 1/(2·rise) + 1/(2·fall) the end velocity asks

    κ·(p² − q²) + a_max·hold + a_min·dwell = c = v1 − v0 + (a0² − a1²)/(2·rise),

which leaves a one-parameter family of arcs. Along each arc the duration grows monotonically, and
the distance d changes with it by dd/dT = H, the Hamiltonian, a polynomial of degree two at most
in the arc's parameter (in w² with w = p − q on the arc without holds). So d is monotone between
the known zeros of H, and each monotone stretch holds at most one profile of the distance wanted,
found to the last bit by a bracketed Newton iteration. The profiles that go the least far are the
same family of the mirrored task; the fastest transfer is the shortest one of either family.

Source: the structures are those of Ruckig's step 1 (Berscheid & Kröger, "Jerk-limited real-time
trajectory generation with arbitrary target states", 2021); the families and their Hamiltonian
follow Wang & Hu, arXiv 2311.07039.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, sqrt
from typing import NamedTuple

from .jerk_profile import Profile, pieces, travelled
from .task import ROUNDING, Piece, Task


class _Arc(NamedTuple):
    """One structure of a family, over a range of its parameter in which the duration grows."""

    kind: int
    first: float
    last: float


_ITERATIONS = 2000  # for a root 300 decades below its bracket's end
_FREE_Q, _FREE_P, _HOLD, _DWELL, _BOTH = range(5)
# parameter: q, p, q (p at its bound), p (q at its bound), the hold's duration


class Family:
    """The profiles that go furthest in their time."""

    def __init__(self, task: Task) -> None:
        self.task = task
        rise, fall, v0, a0, v1, a1 = task.rise, task.fall, task.v0, task.a0, task.v1, task.a1
        self.kappa = kappa = 0.5 / rise + 0.5 / fall
        squares = max(a0 * a0, a1 * a1)
        self.noise = ROUNDING * (max(abs(v0), abs(v1)) + kappa * squares)
        self.blur = self._blur()
        self.c = self._settled(v1 - v0 + (a0 - a1) * (a0 + a1) * 0.5 / rise)
        self.ratio = self.c / kappa  # p² − q² where nothing is held
        # velocities at which the outer rises cross zero acceleration
        self.v_in = v0 - a0 * a0 * 0.5 / rise
        self.v_out = v1 - a1 * a1 * 0.5 / rise
        # the accelerations from and to which the profile cruises at v_max
        self.p_cruise = self._to_cruise(task.v_max - self.v_in, max(a0, 0.0))
        self.q_cruise = -self._to_cruise(task.v_max - self.v_out, max(-a1, 0.0))
        # a rise at the end that starts below zero acceleration dips to v_out
        lowest = task.v_min - self._slack(task.v_min)
        self.may_dip = a1 <= 0.0 or self.v_out >= lowest
        self.may_rise = a0 >= 0.0 or self.v_in >= lowest  # so does one at the start, above it

    def _slack(self, bound: float) -> float:
        return ROUNDING * abs(bound) + self.noise

    def _settled(self, difference: float) -> float:
        return 0.0 if abs(difference) <= self.noise else difference

    def _root(self, square: float) -> float:
        """Return the root of a squared acceleration, rounding about zero taken for zero."""
        return sqrt(square) if square * self.kappa > self.noise else 0.0

    def _to_cruise(self, gain: float, least: float) -> float:
        """Return the acceleration that gains the speed, −inf where it is below the least."""
        if gain == inf:
            return inf
        square = gain / self.kappa
        slack = self._slack(self.task.v_max) / self.kappa
        if square > least * least:
            return sqrt(square)
        return least if square >= least * least - slack else -inf

    # --- the arcs ------------------------------------------------------------------------------

    def arcs(self) -> Iterator[_Arc]:
        """Yield the arcs of the family without cruise."""
        a0, a1 = self.task.a0, self.task.a1
        p_max, q_min, ratio = self.task.a_max, self.task.a_min, self.ratio
        if a0 > p_max or a1 < q_min:
            return
        if ratio == 0.0 and a0 <= a1 < 0.0:
            yield _Arc(_FREE_P, a1, a1)  # nothing but the rise
        if ratio >= 0.0:
            least = self._root(a0 * a0 - ratio) if a0 > 0.0 else 0.0
            most = inf if p_max == inf else self._root_or_nan(p_max * p_max - ratio)
            yield from self._in_q(_FREE_Q, max(least, -a1), most, min(a1, most), least)
        else:
            least = self._root(a1 * a1 + ratio) if a1 < 0.0 else 0.0
            most = inf if q_min == -inf else self._root_or_nan(q_min * q_min + ratio)
            yield from self._in_p(_FREE_P, max(least, a0), most, max(a0, -most), least)
        if p_max < inf:
            least = self._root(p_max * p_max - ratio)
            yield from self._in_q(_HOLD, max(least, -a1), -q_min, min(a1, p_max), least)
        if q_min > -inf:
            least = self._root(q_min * q_min + ratio)
            yield from self._in_p(_DWELL, max(least, a0), p_max, max(a0, q_min), least)
        if p_max < inf and q_min > -inf and self.may_dip and self.may_rise:
            yield from self._holds()

    def _root_or_nan(self, square: float) -> float:
        return self._root(square) if square * self.kappa >= -self.noise else -inf

    def _in_q(
        self, kind: int, low: float, high: float, start: float, least: float
    ) -> Iterator[_Arc]:
        """Yield the two arcs in falling q: from `start` to `least`, and from −`low` to −`high`."""
        if not self.may_rise:
            return
        bottom = max(self.task.a_min, self.q_cruise, -high) if self.may_dip else 0.0
        if least <= start:
            if least == 0.0 and bottom < 0.0:
                yield _Arc(kind, start, bottom)
                return
            yield _Arc(kind, start, least)
        if bottom <= -low:
            yield _Arc(kind, -low, bottom)

    def _in_p(
        self, kind: int, low: float, high: float, start: float, least: float
    ) -> Iterator[_Arc]:
        """Yield the two arcs in rising p: from `start` to −`least`, and from `low` to `high`."""
        if not self.may_dip:
            return
        top = min(self.task.a_max, self.p_cruise, high) if self.may_rise else 0.0
        if start <= -least:
            if least == 0.0 and top > 0.0:
                yield _Arc(kind, start, top)
                return
            yield _Arc(kind, start, -least)
        if low <= top:
            yield _Arc(kind, low, top)

    def _holds(self) -> Iterator[_Arc]:
        """Yield the arc that holds and dwells, in the duration of the hold."""
        task = self.task
        p, q = task.a_max, task.a_min
        first = max(self.c - self.kappa * (p * p - q * q), 0.0) / p
        last = (task.v_max - self.v_in - self.kappa * p * p) / p
        if first <= last:
            yield _Arc(_BOTH, first, last)

    def profile(self, kind: int, s: float) -> Profile:
        """Return the member of an arc at parameter s."""
        task, hold, dwell = self.task, 0.0, 0.0
        if kind == _FREE_Q:
            p, q = max(sqrt(self.ratio + s * s), task.a0), s
        elif kind == _FREE_P:
            p, q = s, min(-sqrt(s * s - self.ratio), task.a1)
        elif kind == _HOLD:
            p, q = task.a_max, s
            hold = max((self.c - self.kappa * (p - q) * (p + q)) / p, 0.0)
        elif kind == _DWELL:
            p, q = s, task.a_min
            dwell = max((self.c - self.kappa * (p - q) * (p + q)) / q, 0.0)
        else:
            p, q, hold = task.a_max, task.a_min, s
            dwell = max((self.c - self.kappa * (p * p - q * q) - p * hold) / q, 0.0)
        return self._timed(p, hold, q, dwell)

    def _timed(self, p: float, hold: float, q: float, dwell: float) -> Profile:
        task = self.task
        moving = (p - task.a0) / task.rise + (p - q) / task.fall + (task.a1 - q) / task.rise
        return Profile(max(moving, 0.0) + hold + dwell, p, hold, 0.0, q, dwell)

    def _duration_slope(self, kind: int, profile: Profile) -> float:
        p, q = profile.p, profile.q
        if kind in (_FREE_Q, _HOLD):
            return 2.0 * self.kappa * (q / p - 1.0) if p else -2.0 * self.kappa
        if kind in (_FREE_P, _DWELL):
            return 2.0 * self.kappa * (1.0 - p / q) if q else 2.0 * self.kappa
        return 1.0 - p / q

    # --- distance ------------------------------------------------------------------------------

    def travel(self, profile: Profile) -> tuple[float, float, float]:
        """Return the distance covered, its derivative by the duration, and a scale of rounding."""
        distance, slope, v, w = travelled(self.task, profile)
        fastest = max(abs(self.task.v0), abs(v), abs(w), abs(self.task.v1))
        return distance, slope, fastest * profile.duration

    def turning_points(self, kind: int) -> tuple[float, ...]:
        """Return the parameters at which the distance may turn: the zeros of H on an arc."""
        task, kappa = self.task, self.kappa
        if kind in (_FREE_Q, _FREE_P):
            alpha = 0.125 / task.rise + 0.25 / task.fall
            gamma = self.v_in + 0.25 * self.ratio * (1.0 / task.rise + 1.0 / task.fall)
            beta = 0.125 * self.ratio * self.ratio / task.rise
            widths = [sqrt(w2) for w2 in quadratic(alpha, gamma, beta) if w2 > 0.0]
            sign = -0.5 if kind == _FREE_Q else 0.5
            return tuple(sign * w + 0.5 * self.ratio / w for w in widths)
        p, q = task.a_max, task.a_min
        if kind == _HOLD:
            return quadratic(kappa, -0.5 * p / task.fall, self.v_in + self.c)
        if kind == _DWELL:
            return quadratic(kappa, -0.5 * q / task.fall, self.v_in)
        exit_velocity = self.v_in + 0.5 * p * p / task.rise
        return (-(exit_velocity + 0.5 * p * (p - q) / task.fall) / p,)

    # --- profiles of a given distance ----------------------------------------------------------

    def solutions(self) -> Iterator[Profile]:
        """Yield every profile of the family that covers the task's distance."""
        for arc in self.arcs():
            yield from self._on_arc(arc)
        cruising = self.cruising()
        if cruising is not None:
            profile, distance = cruising
            rest = self.task.distance - distance
            slack = 4.0 * ROUNDING * abs(self.task.v_max) * profile.duration + self.blur
            if self.task.v_max > 0.0 and rest >= -slack:
                cruise = max(rest, 0.0) / self.task.v_max
                yield profile._replace(cruise=cruise, duration=profile.duration + cruise)
            elif self.task.v_max <= 0.0 and abs(rest) <= slack:
                yield profile

    def _blur(self) -> float:
        """Return an error of the distance that is mere rounding: of a stop, at the least."""
        task = self.task
        speed, jerk = max(abs(task.v0), abs(task.v1)), min(task.rise, task.fall)
        stop = speed / min(task.a_max, -task.a_min) + sqrt(speed / jerk)
        stop += max(abs(task.a0), abs(task.a1)) / jerk
        return task.resolution + ROUNDING * (abs(task.distance) + speed * stop)

    def _on_arc(self, arc: _Arc) -> Iterator[Profile]:
        low, high = min(arc.first, arc.last), max(arc.first, arc.last)
        turns = [s for s in self.turning_points(arc.kind) if low < s < high]
        turns.sort(reverse=arc.last < arc.first)
        before: tuple[float, float] | None = None
        for s in (arc.first, *turns, arc.last):
            if abs(s) == inf:
                assert before is not None
                s = self._far(arc.kind, before[0], s)
            profile = self.profile(arc.kind, s)
            distance, _, scale = self.travel(profile)
            error = distance - self.task.distance
            if abs(error) <= 4.0 * ROUNDING * scale + self.blur:
                yield profile
                error = 0.0
            elif before is not None and before[1] * error < 0.0:
                yield self._between(arc.kind, *before, s)
            before = s, error

    def _far(self, kind: int, s: float, infinite: float) -> float:
        """Return a parameter beyond which the distance wanted is exceeded for good."""
        step = 1.0 if infinite > 0.0 else -1.0
        while True:
            distance, slope, _ = self.travel(self.profile(kind, s + step))
            if slope > 0.0 and distance > self.task.distance:
                return s + step
            step *= 2.0
            if abs(step) > 1e100:
                raise OverflowError

    def _between(self, kind: int, s: float, error: float, other: float) -> Profile:
        """Return the profile between two parameters at which the distance errs either way."""
        wrong_side = error
        middle = 0.5 * (s + other)
        for _ in range(_ITERATIONS):
            profile = self.profile(kind, middle)
            distance, slope, scale = self.travel(profile)
            error = distance - self.task.distance
            if abs(error) <= 2.0**-52 * scale:
                break
            if (error < 0.0) == (wrong_side < 0.0):
                s = middle
            else:
                other = middle
            slope *= self._duration_slope(kind, profile)
            following = middle - error / slope if slope else s
            if not min(s, other) < following < max(s, other):
                following = 0.5 * (s + other)
                if following in (s, other):
                    break
            if following == middle:
                break
            middle = following
        return profile

    def cruising(self) -> tuple[Profile, float] | None:
        """Return the profile that touches v_max with zero acceleration, and its distance."""
        task = self.task
        p, q = self.p_cruise, self.q_cruise
        if not (self.may_dip and self.may_rise and 0.0 <= p < inf and -inf < q <= 0.0):
            return None
        if task.a0 > task.a_max or task.a1 < task.a_min:
            return None
        hold = dwell = 0.0
        if p > task.a_max:
            hold = self.kappa * (p / task.a_max - 1.0) * (p + task.a_max)
            p = task.a_max
        if q < task.a_min:
            dwell = self.kappa * (q / task.a_min - 1.0) * (-q - task.a_min)
            q = task.a_min
        profile = self._timed(p, hold, q, dwell)
        return profile, self.travel(profile)[0]

    def lasting(self, duration: float) -> Profile | None:
        """Return the member of a given duration, None where the family has none."""
        for arc in self.arcs():
            found = self._lasting_on(arc, duration)
            if found is not None:
                return found
        cruising = self.cruising()
        if cruising is None or cruising[0].duration > duration * (1.0 + ROUNDING):
            return None
        profile = cruising[0]
        cruise = max(duration - profile.duration, 0.0)
        return profile._replace(cruise=cruise, duration=profile.duration + cruise)

    def _lasting_on(self, arc: _Arc, duration: float) -> Profile | None:
        """Return the arc's member of a given duration, if it has one."""
        shortest = self.profile(arc.kind, arc.first)
        if duration < shortest.duration * (1.0 - ROUNDING):
            return None
        if abs(arc.last) < inf:
            longest = self.profile(arc.kind, arc.last)
            if duration >= longest.duration:
                fits = duration <= longest.duration * (1.0 + ROUNDING)
                return longest if fits else None
        s = self._parameter(arc, duration, max(duration - shortest.duration, 0.0))
        low, high = min(arc.first, arc.last), max(arc.first, arc.last)
        return self.profile(arc.kind, min(max(s, low), high))

    def _parameter(self, arc: _Arc, duration: float, more: float) -> float:
        """Return the parameter of a duration, `more` than that of the arc's first member."""
        task, kappa, first = self.task, self.kappa, arc.first
        if arc.kind in (_FREE_Q, _FREE_P):
            width = 0.5 * (duration - (task.a1 - task.a0) / task.rise) / kappa
            if width <= 0.0:
                return first
            return 0.5 * self.ratio / width + (-0.5 if arc.kind == _FREE_Q else 0.5) * width
        if arc.kind == _HOLD:  # the duration is κ·(q − p)²/p and a constant
            p = task.a_max
            return p - sqrt((first - p) ** 2 + more * p / kappa)
        if arc.kind == _DWELL:
            q = task.a_min
            return q + sqrt((first - q) ** 2 - more * q / kappa)
        return first + more / (1.0 - task.a_max / task.a_min)

    def limits_of_duration(self) -> Iterator[float]:
        """Yield the durations at which the family begins or ends."""
        for arc in self.arcs():
            for s in (arc.first, arc.last):
                if abs(s) < inf:
                    yield self.profile(arc.kind, s).duration
        cruising = self.cruising()
        if cruising is not None:
            yield cruising[0].duration

    def distance(self, profile: Profile) -> float:
        """Return the distance covered."""
        return self.travel(profile)[0] + (
            self.task.v_max * profile.cruise if profile.cruise else 0.0
        )

    def pieces(self, profile: Profile, start: float, end: float) -> list[Piece]:
        """Return the pieces of a profile from position `start` to position `end`."""
        return pieces(self.task, profile, start, end)


def quadratic(a: float, b: float, c: float) -> tuple[float, ...]:
    """Return the real roots of a·x² + b·x + c, without cancellation."""
    discriminant = b * b - 4.0 * a * c
    if discriminant < 0.0:
        return ()
    half = -0.5 * (b + (sqrt(discriminant) if b >= 0.0 else -sqrt(discriminant)))
    return (half / a, c / half) if half else (0.0,)
