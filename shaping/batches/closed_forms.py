"""Moves of order 4 and more: the fastest closed form of each, and its pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..derivatives import derivative_name
from ..frozen import Frozen
from ..limits import Limits
from ..move_units import MoveUnits, in_own_units
from ..pieces import FloatArray
from ..trajectory import Trajectory, point, within_range
from .forms import Forms, Lanes, fastest, most_pieces, pieces, trajectory
from .lanes import AT_ONCE, Index, Shape, in_threads, index_text, lanes, limits_of, sides

_SPOILT = 1e-11  # an excess over a bound that is more than rounding


@dataclass(frozen=True, eq=False)
class ClosedForms(Frozen):
    """Moves of order n ≥ 4: distances, starts and forms of one shape, limits that broadcast.

    A form is the derivative whose rise is one perfect spline (n − 1: the recursive S-curve; 0: one
    spline from start to end), or n for Thompson's longer move without cruise.
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
            times, forms.reshape(-1)[part] = fastest(lengths, bounds)
            duration.reshape(-1)[part] = units.times(times)

        in_threads(some, duration.size, AT_ONCE // 8)  # whose arrays take half a megabyte
        return cls(distances, starts, limits, forms)

    @property
    def most(self) -> int:
        """Largest number of pieces of a motion."""
        return most_pieces(self.limits.order, self.forms)

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
        ahead = np.array([distance])
        units, length, bounds = _seen_forward(ahead, limits, (1,), slice(0, 1))
        form, numbers = int(self.forms[index]), [float(bound.item()) for bound in bounds]
        move = within_range(lambda: trajectory(float(length.item()), numbers, form))
        spoilt = _spoilt_bound(move.states.T[..., None], bounds)
        if spoilt:
            raise _spoilt(spoilt[0], str(index))
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
                raise _spoilt(spoilt[0], index_text(move, shape))
            own = units.select(chosen)
            m, durations = len(durations), own.times(durations)
            rows = np.stack([own.derivative(row, k) for k, row in enumerate(rows)])
            rows *= direction[chosen]
            rows[0] += starts[chosen]
            lengths[chosen, :m] = durations.T
            states[chosen, :m] = rows.transpose(2, 1, 0)
        still = distances == 0.0
        lengths[still], states[still] = 0.0, ends[still, None]


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
        kept = np.abs(states[k]).max(axis=0) <= bound * (1.0 + _SPOILT)
        if not kept.all():
            return k, int(np.argmin(kept))
    return None


def _spoilt(k: int, index: str) -> ValueError:
    """Return the error about a bound on derivative k that cannot be kept."""
    return ValueError(
        f"the {derivative_name(k)} limit of move {index} cannot be kept in double precision: the "
        "limits are too many decades apart; leave out those that never bind"
    )
