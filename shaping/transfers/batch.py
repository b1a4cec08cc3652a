"""Many transfers at once, on arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import in_range
from ..derivatives import derivative_name
from ..frozen import Frozen
from ..limits import Limits
from ..pieces import FloatArray
from ..real_numbers import real_array
from ..trajectory_checks import finite_array
from . import batch_second, batch_third
from .batch_brake import brake, outside
from .batch_tasks import Mask, Tasks, choose, inside, put, take
from .problem import Transfer, check_order
from .task import Task
from .transfer import min_time_transfer

_TINY = np.finfo(float).tiny
_NO_EXPONENT = -(2**20)
_CHUNK = 4096  # problems whose arrays stay in the processor's cache


@dataclass(frozen=True, eq=False)
class TransferBatch(Frozen):
    """Minimum-time transfers of N problems.

    Attributes
    ----------
    duration : (N,) array
        NaN where the end cannot be reached.
    inside_after : (N,) array
        As in `Transfer`; NaN where the end cannot be reached.
    starts, ends : (N, order) arrays
        The states asked for.
    bounds : (N, order, 2) array
        Lower and upper bounds, velocity first.
    piece_durations : (N, m) array
        Of up to m pieces each, zero for those that a transfer does not need.
    piece_states : (N, m, order + 1) array
        Position and derivatives at the start of each piece.
    """

    duration: FloatArray
    inside_after: FloatArray
    starts: FloatArray
    ends: FloatArray
    bounds: FloatArray
    piece_durations: FloatArray
    piece_states: FloatArray

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Which ends can be reached, (N,)."""
        return np.asarray(~np.isnan(self.duration))

    def __repr__(self) -> str:
        feasible = int(np.count_nonzero(self.feasible))
        return f"TransferBatch(problems={len(self)}, feasible={feasible})"

    def __len__(self) -> int:
        return len(self.duration)

    def transfer(self, i: int) -> Transfer:
        """Return transfer i as a trajectory; InfeasibleError where there is none."""
        limits = Limits.from_bounds([tuple(pair) for pair in self.bounds[i].tolist()])
        if np.isnan(self.duration[i]):
            return min_time_transfer(self.starts[i].tolist(), self.ends[i].tolist(), limits)
        some = self.piece_durations[i] > 0.0
        durations, states = self.piece_durations[i][some], self.piece_states[i][some]
        breaks = np.concatenate([[0.0], np.cumsum(durations)])
        transfer = Transfer.from_arrays(breaks, states, durations, np.append(self.ends[i], 0.0))
        transfer.__dict__.update(limits=limits, inside_after=float(self.inside_after[i]))
        return transfer


def min_time_transfers(
    starts: ArrayLike, ends: ArrayLike, limits: Limits | ArrayLike
) -> TransferBatch:
    """Return the fastest motions between many pairs of states: `min_time_transfer` on arrays.

    Parameters
    ----------
    starts, ends : (N, order) arrays
        Position, velocity and, for order 3, acceleration; those left out at the end are zero. One
        state (order,) stands for all.
    limits : Limits or (N, order) or (N, order, 2) array
        The same for all, or magnitudes or (lower, upper) pairs, velocity first; infinite where
        there is no bound.

    Returns
    -------
    TransferBatch

    Raises
    ------
    ValueError
        For arrays that do not fit or are not finite, or bounds that do not enclose zero. Ends that
        cannot be reached raise nothing: their duration is NaN.

    Notes
    -----
    The formulas are those of `min_time_transfer`, with which the results agree to rounding; each
    problem takes about 0.5 kB.

    Examples
    --------
    >>> batch = min_time_transfers([0.0], [[1.0], [2.0]], Limits(acceleration=1.0))
    >>> batch.duration
    array([2.        , 2.82842712])
    """
    begin, finish, bounds = _checked(starts, ends, limits)
    count, order = begin.shape
    columns = 1 + 3 if order == 2 else 4 + 7  # braking, and the plan
    batch = TransferBatch(
        np.empty(count),
        np.zeros(count),
        *(begin, finish, bounds),
        np.zeros((count, columns)),
        np.zeros((count, columns, order + 1)),
    )
    with np.errstate(all="ignore"):
        for i in range(0, count, _CHUNK):
            some = slice(i, i + _CHUNK)
            in_range(lambda: _solve(batch, some))  # noqa: B023  (it runs at once)
    for array in vars(batch).values():
        array.flags.writeable = False
    return batch


def _checked(
    starts: ArrayLike, ends: ArrayLike, limits: Limits | ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return starts and ends (N, order) and bounds (N, order, 2)."""
    if isinstance(limits, Limits):
        check_order(limits)
        bounds = np.array([limits.lower, limits.upper]).T
    else:
        bounds = np.array(real_array("limits", limits))
        if bounds.ndim < 3:
            bounds = np.stack([-bounds, bounds], axis=-1)
    order = bounds.shape[-2] if bounds.ndim > 1 else 0
    if order not in (2, 3) or bounds.shape[-1] != 2:
        raise ValueError(
            f"limits of shape {bounds.shape}: expected Limits of order 2 or 3, or an array "
            "(N, order) of magnitudes or (N, order, 2) of pairs"
        )
    _check_bounds(bounds.reshape(-1, order, 2))
    states = [_states(name, value, order) for name, value in (("starts", starts), ("ends", ends))]
    shapes = [bounds.shape[:-2], *(state.shape[:-1] for state in states)]
    try:
        (count,) = np.broadcast_shapes((1,), *shapes)
    except ValueError:
        raise ValueError(
            f"starts, ends and limits of {shapes[1]}, {shapes[2]} and {shapes[0]} problems do not "
            "fit: expected the same number N, or one for all"
        ) from None
    begin, finish = (np.broadcast_to(state, (count, order)) for state in states)
    return begin, finish, np.broadcast_to(bounds, (count, order, 2))


def _check_bounds(bounds: FloatArray) -> None:
    low, high = bounds[..., 0], bounds[..., 1]
    wrong = ~((low < 0.0) & (high > 0.0))
    wrong[:, -1] |= ~(np.isfinite(low[:, -1]) & np.isfinite(high[:, -1]))
    if wrong.any():
        i, k = np.argwhere(wrong)[0]
        raise ValueError(
            f"{derivative_name(int(k) + 1)} limit {bounds[i, k].tolist()} of problem {i}: expected "
            "lower < 0 < upper, finite for the highest derivative"
        )


def _states(name: str, given: ArrayLike, order: int) -> FloatArray:
    """Return states (…, order), what is left out filled with zeros."""
    states = np.atleast_1d(finite_array(name, given))
    if not states.size:
        states = np.empty((0, order))
    missing = order - states.shape[-1]
    if missing < 0 or states.ndim > 2:
        raise ValueError(
            f"{name} of shape {states.shape}: expected (N, {order}) or ({order},), position first"
        )
    return np.pad(states, [(0, 0)] * (states.ndim - 1) + [(0, missing)])


def _solve(batch: TransferBatch, some: slice) -> None:
    """Put the plans of some problems in place."""
    order = batch.starts.shape[1]
    tasks = _tasks(batch.starts[some], batch.ends[some], batch.bounds[some])
    time, length = _own_units(tasks)
    units = np.array([time, length])
    if not (np.isfinite([*units, tasks.distance]).all() and (units >= _TINY).all()):
        raise OverflowError
    tasks = tasks.in_units(time, length)
    solver = batch_second if order == 2 else batch_third
    [leaving] = np.nonzero(outside(tasks))
    steps = 1 if order == 2 else 4
    braking = np.zeros((steps, len(time))), np.zeros((steps, order + 1, len(time)))
    left = tasks
    if leaving.size:
        starts = take(tasks, leaving)
        durations, states, begun = brake(starts)
        # it may keep its bounds as far as the end
        inside = (starts.v0 <= starts.v_max) & (starts.v0 >= starts.v_min)
        inside &= (starts.a0 <= starts.a_max) & (starts.a0 >= starts.a_min)
        direct = inside & np.isfinite(solver.fastest(starts)[1].duration)
        braking[0][:, leaving] = np.where(direct, 0.0, durations)
        braking[1][..., leaving] = states
        left = put(tasks, leaving, choose(direct, starts, begun))
    ahead, profile, falls = solver.fastest(left)
    durations, states = solver.pieces(ahead, profile)
    states *= np.where(falls, -1.0, 1.0)
    states[:, 0] += tasks.distance - left.distance
    outer = length / time ** np.arange(order + 1)[:, None]
    durations, states = (
        np.concatenate(both) for both in zip(braking, (durations, states), strict=True)
    )
    batch.piece_durations[some] = (durations * time).T
    batch.piece_states[some] = (states * outer).transpose(2, 0, 1)
    batch.piece_states[some, :, 0] += batch.starts[some, :1]
    before = braking[0].sum(axis=0) * time
    total = before + profile.duration * time
    feasible = np.isfinite(total) & _within(tasks)
    batch.duration[some] = np.where(feasible, total, np.nan)
    batch.inside_after[some] = np.where(feasible, before, np.nan)


def _within(tasks: Tasks) -> Mask:
    """Tell which ends are within their bounds."""
    speeds = (tasks.v_min <= tasks.v1) & (tasks.v1 <= tasks.v_max)
    return np.asarray(speeds & (tasks.a_min <= tasks.a1) & (tasks.a1 <= tasks.a_max))


def _tasks(begin: FloatArray, finish: FloatArray, bounds: FloatArray) -> Tasks:
    """Return the problems as a task of arrays."""
    count, order = begin.shape
    (v_min, v_max), (a_min, a_max) = bounds[:, 0].T, bounds[:, 1].T
    fall = -bounds[:, 2, 0] if order == 3 else np.full(count, np.inf)
    rise = bounds[:, 2, 1] if order == 3 else fall
    nothing = np.zeros(count)
    make: Any = Task
    return make(
        finish[:, 0] - begin[:, 0],
        inside(begin[:, 1], v_min, v_max),
        inside(begin[:, 2], a_min, a_max) if order == 3 else nothing,
        inside(finish[:, 1], v_min, v_max),
        inside(finish[:, 2], a_min, a_max) if order == 3 else nothing,
        *(v_min, v_max, a_min, a_max, fall, rise),
        2.0**-52 * np.maximum(np.abs(begin[:, 0]), np.abs(finish[:, 0])),
    )


def _own_units(tasks: Tasks) -> tuple[FloatArray, FloatArray]:
    """Return units of time and distance, as `task.own_units`."""
    n = 2 if np.isinf(tasks.rise).all() else 3
    jerk, acceleration = np.minimum(tasks.rise, tasks.fall), np.minimum(tasks.a_max, -tasks.a_min)
    power = acceleration if n == 2 else jerk
    sizes = [
        np.abs(tasks.distance),
        np.maximum(np.abs(tasks.v0), np.abs(tasks.v1)),
        np.maximum(np.abs(tasks.a0), np.abs(tasks.a1)),
    ]
    span = np.full(len(power), _NO_EXPONENT)
    for order, size in zip(range(n, 0, -1), sizes, strict=False):
        if not np.isfinite(size / power).all():
            raise OverflowError
        exponent = -(-np.frexp(size / power)[1] // order)  # rounded up
        span = np.where(size > 0.0, np.maximum(span, exponent), span)
    still = span == _NO_EXPONENT
    span = np.where(still, 0, span)
    outer = np.where(still, 0, np.frexp(power)[1] + n * span)
    return np.ldexp(1.0, span), np.ldexp(1.0, outer)
