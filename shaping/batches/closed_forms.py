"""Moves of order 4 and more: the fastest closed form of each, and its pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..closed_moves import SPOILT, not_kept
from ..frozen import Frozen
from ..limits import Limits
from ..move_units import MoveUnits, Sides, in_own_units
from ..pieces import FloatArray
from ..trajectory import Trajectory, point, within_range
from .averages import (
    ORDERS,
    averaged_duration,
    averaged_move,
    averaged_pieces,
    most_averaged,
)
from .forms import Forms, Lanes, fastest, most_pieces, pieces, trajectory
from .lanes import AT_ONCE, Index, Shape, in_threads, index_text, lanes, limits_of, sides


@dataclass(frozen=True, eq=False)
class ClosedForms(Frozen):
    """Moves of order n ≥ 4: distances, starts and forms of one shape, limits that broadcast.

    A form is the derivative whose rise is one perfect spline (n − 1: the recursive S-curve; 0: one
    spline from start to end), n for Thompson's longer move without cruise, or n + m for averages of
    the move of order m, which bounds that differ between the directions are used by exactly.
    """

    distances: FloatArray
    starts: FloatArray
    limits: Limits
    forms: Forms

    def __post_init__(self) -> None:
        for array in (self.distances, self.starts, self.forms):
            array.flags.writeable = False

    @classmethod
    def planned(
        cls, distances: FloatArray, starts: FloatArray, limits: Limits, duration: FloatArray
    ) -> ClosedForms:
        """Return the fastest forms, and put their durations in place."""
        forms = np.empty(duration.shape, dtype=np.int8)

        def some(part: slice) -> None:
            units, lengths, bounds = _seen_forward(distances, limits, duration.shape, part)
            times, form = fastest(lengths, bounds)
            times = units.times(times)
            if not limits.symmetric:
                _take_averaged(*_ahead(distances, limits, duration.shape, part), times, form)
            duration.reshape(-1)[part], forms.reshape(-1)[part] = times, form

        in_threads(some, duration.size, AT_ONCE // 2)  # whose arrays take half a megabyte
        return cls(distances, starts, limits, forms)

    @property
    def most(self) -> int:
        """Largest number of pieces of a motion."""
        n = self.limits.order
        averaged = [most_averaged(n, m) for m in ORDERS if (self.forms == n + m).any()]
        return max([most_pieces(n, self.forms), *averaged])

    def select(self, index: Index) -> ClosedForms:
        """Return the problems that an index of numpy selects."""
        limits = limits_of(self.limits, self.forms.shape, index)
        return ClosedForms(self.distances[index], self.starts[index], limits, self.forms[index])

    def alone(self, index: Index) -> Trajectory:
        """Return one motion."""
        distance, start = float(self.distances[index]), float(self.starts[index])
        limits = limits_of(self.limits, self.forms.shape, index)
        if distance == 0.0:
            return point(start, limits.order)
        if self.forms[index] > limits.order:
            found = averaged_move(distance, limits)
            if found is None:
                raise not_kept(limits.order, f" of move {index}")
            return found.shift(start)
        ahead = np.array([distance])
        units, length, bounds = _seen_forward(ahead, limits, (1,), slice(0, 1))
        form, numbers = int(self.forms[index]), [float(bound.item()) for bound in bounds]
        move = within_range(lambda: trajectory(float(length.item()), numbers, form))
        spoilt = _spoilt_bound(move.states.T[..., None], bounds)
        if spoilt:
            raise not_kept(spoilt[0], f" of move {index}")
        move = within_range(lambda: units.select(0).trajectory(move))
        move = move if distance > 0.0 else move.mirror()
        return move.shift(start) if start else move

    def fill(self, some: slice, rooms: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Plan some, counted in C order; see `Problems`."""
        lengths, states, ends = rooms
        shape, count = self.forms.shape, len(ends)
        distances, starts, forms = (
            np.broadcast_to(lanes(each, shape, some), count)
            for each in (self.distances, self.starts, self.forms)
        )
        units, size, bounds = _seen_forward(self.distances, self.limits, shape, some)
        ends[:], lengths[:] = 0.0, 0.0
        ends[:, 0] = starts + distances
        states[:] = ends[:, None]
        direction = np.where(distances < 0.0, -1.0, 1.0)
        for chosen, durations, rows in pieces(size, bounds, forms):
            spoilt = _spoilt_bound(rows, [_of(bound, chosen) for bound in bounds])
            if spoilt:
                move = int(np.arange(some.start, some.stop)[chosen][spoilt[1]])
                raise not_kept(spoilt[0], f" of move {index_text(move, shape)}")
            own = units.select(chosen)
            m, durations = len(durations), own.times(durations)
            rows = np.stack([own.derivative(row, k) for k, row in enumerate(rows)])
            rows *= direction[chosen]
            rows[0] += starts[chosen]
            lengths[chosen, :m] = durations.T
            states[chosen, :m] = rows.transpose(2, 1, 0)
        for m in ORDERS:
            [chosen] = np.nonzero(forms == self.limits.order + m)
            if len(chosen):
                self._fill_averaged(m, chosen, some, rooms)
        still = distances == 0.0
        lengths[still], states[still] = 0.0, ends[still, None]

    def _fill_averaged(
        self,
        order: int,
        chosen: NDArray[np.intp],
        some: slice,
        rooms: tuple[FloatArray, FloatArray, FloatArray],
    ) -> None:
        lengths, states, ends = rooms
        size, sides = _ahead(self.distances, self.limits, self.forms.shape, some)
        sides = [(_of(low, chosen), _of(high, chosen)) for low, high in sides]
        durations, rows = averaged_pieces(size[chosen], sides, order)
        forward = lanes(self.distances, self.forms.shape, some)
        direction = np.where(np.broadcast_to(forward, len(ends))[chosen] < 0.0, -1.0, 1.0)
        rows = np.asarray(rows[:, :-1] * direction, float)
        rows[0] += np.broadcast_to(lanes(self.starts, self.forms.shape, some), len(ends))[chosen]
        m = len(durations)
        lengths[chosen, :m] = durations.T
        states[chosen, :m] = rows.transpose(2, 1, 0)


def _take_averaged(
    distance: FloatArray, sides: list[Sides], times: FloatArray, forms: Forms
) -> None:
    """Put in place the durations and forms of averages that are faster."""
    for m in ORDERS:
        other = averaged_duration(distance, sides, m)
        better = other < times
        times[better], forms[better] = other[better], len(sides) + m


def _ahead(
    distances: FloatArray, limits: Limits, shape: Shape, some: slice
) -> tuple[FloatArray, list[Sides]]:
    """Return sizes of distances (K,), and both sides of all bounds seen forward."""
    count = len(range(*some.indices(int(np.prod(shape)))))
    distance = np.broadcast_to(lanes(distances, shape, some), count)
    pairs, back = sides(limits, shape, some), distance < 0.0
    if back.any():
        pairs = [(np.where(back, -b, a), np.where(back, -a, b)) for a, b in pairs]
    return np.abs(distance), pairs


def _seen_forward(
    distances: FloatArray, limits: Limits, shape: Shape, some: slice
) -> tuple[MoveUnits, FloatArray, list[FloatArray]]:
    """Return units, and in them distances ≥ 0 (K,) and bounds on derivatives 1…n, seen forward.

    Velocity is bounded in the direction of motion, others by the smaller magnitude.
    """
    count = len(range(*some.indices(int(np.prod(shape)))))
    distance = np.broadcast_to(lanes(distances, shape, some), count)
    (down, up), *others = sides(limits, shape, some)
    even = down.ndim == up.ndim == 0 and -down == up
    velocity = up if even else np.where(distance >= 0.0, up, -down)
    bounds = [velocity, *(np.minimum(high, -low) for low, high in others)]
    units, size, own = in_own_units(np.abs(distance), [(-bound, bound) for bound in bounds])
    return units, size, [high for _, high in own]


def _of(bound: FloatArray, chosen: Lanes) -> FloatArray:
    return bound[chosen] if bound.ndim else bound


def _spoilt_bound(states: FloatArray, bounds: list[FloatArray]) -> tuple[int, int] | None:
    """Return derivative and move of a bound that states (n + 1, m, k) break, None if they do not.

    Only rounding can do that, and takes bounds some 15 decades apart.
    """
    for k, bound in enumerate(bounds, start=1):
        kept = np.abs(states[k]).max(axis=0) <= bound * (1.0 + SPOILT)
        if not kept.all():
            return k, int(np.argmin(kept))
    return None
