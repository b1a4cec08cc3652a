"""Transfers of arrays of problems that linear programs plan, one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..frozen import Frozen
from ..limits import Limits
from ..pieces import FloatArray
from ..transfers.infeasible import InfeasibleError
from ..transfers.problem import Transfer
from ..transfers.transfer import min_time_transfer
from .lanes import Index, Shape, limits_of


@dataclass(frozen=True, eq=False)
class WholeTransfers(Frozen):
    """Starts and ends (*N, order), limits that broadcast, and what was planned of each.

    Attributes
    ----------
    motions : (N,) array of Transfer
        None where there is none, or none was found.
    """

    starts: FloatArray
    ends: FloatArray
    limits: Limits
    motions: NDArray[Any]

    @classmethod
    def planned(
        cls, starts: FloatArray, ends: FloatArray, limits: Limits, shape: Shape
    ) -> WholeTransfers:
        """Plan all problems of a batch of this shape."""
        from ..optimal.whole.outcome import check_whole  # which loads linear programs

        check_whole(limits)
        begin, finish = (
            np.broadcast_to(each, (*shape, limits.order)).copy() for each in (starts, ends)
        )
        problems = cls(begin, finish, limits, np.empty(shape, dtype=object))
        found = np.empty(shape, dtype=object)
        for index in np.ndindex(shape):
            try:
                found[index] = problems.alone(index)
            except InfeasibleError:
                found[index] = None
        return cls(problems.starts, problems.ends, limits, found)

    @property
    def duration(self) -> FloatArray:
        """Of each, NaN where there is no motion."""
        flat = [np.nan if one is None else one.duration for one in self.motions.flat]
        return np.array(flat).reshape(self.motions.shape)

    @property
    def most(self) -> int:
        """Largest number of pieces of a motion."""
        return max((len(one.states) for one in self.motions.flat if one is not None), default=0)

    def select(self, index: Index) -> WholeTransfers:
        """Return the problems that an index of numpy selects."""
        shape = self.motions.shape
        numbers = np.arange(self.motions.size).reshape(shape)[index]
        starts, ends = (
            rows.reshape(-1, self.limits.order)[numbers] for rows in (self.starts, self.ends)
        )
        limits = limits_of(self.limits, shape, index)
        return WholeTransfers(starts, ends, limits, self.motions[index])

    def alone(self, index: Index) -> Transfer:
        """Return one motion; InfeasibleError where there is none."""
        known: Any = self.motions[index]
        if known is not None:
            return cast(Transfer, known)
        own = limits_of(self.limits, self.motions.shape, index)
        pairs = [own.bounds(k) for k in range(1, own.order + 1)]
        limits = Limits.from_bounds(pairs, position=own.position if own.bounds_position else None)
        start, end = self.starts[index].tolist(), self.ends[index].tolist()
        return min_time_transfer(start, end, limits)

    def fill(self, some: slice, rooms: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Lay out some, counted in C order; see `Problems`."""
        lengths, states, ends = rooms
        lengths[:] = 0.0
        for i, motion in enumerate(self.motions.reshape(-1)[some]):
            if motion is None:
                lengths[i], states[i], ends[i] = np.nan, np.nan, np.nan
                continue
            count = len(motion.states)
            lengths[i, :count], states[i, :count] = motion.durations, motion.states
            states[i, count:], ends[i] = motion.end_state, motion.end_state
