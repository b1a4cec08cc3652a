"""From the inputs of a half to a whole move: cells merged, ends repaired, bounds kept exactly."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np

from ..limits import Limits
from ..pieces import INVERSE_FACTORIALS, FloatArray, RealArray, extrema
from ..trajectory import Trajectory

_REPAIRS = 8
_MET = 1e-17  # of a derivative's size: an end condition that is met
_SHORTEST = 0.1  # of its duration is what a run must keep through a repair


@dataclass(frozen=True, eq=False)
class Half:
    """Runs of constant input over the first half, at rest when it begins.

    Parameters
    ----------
    durations : (r,) array of extended precision
    inputs : (r,) array
        Derivative n on each run.
    order : int
        n.
    negligible : float
        Of its peak: a derivative between two runs that is smaller is zero but for rounding, which
        a long run would blow up.
    """

    durations: RealArray
    inputs: RealArray
    order: int
    negligible: float = 0.0

    def states(self) -> RealArray:
        """Return the states at the start of each run and at the end, (n + 1, r + 1)."""
        n, r = self.order, len(self.inputs)
        factorials = np.array([factorial(k) for k in range(n + 1)])[:, None]
        powers = self.durations ** np.arange(n + 1)[:, None] / factorials
        states = np.zeros((n + 1, r + 1), dtype=np.longdouble)
        states[n, :-1] = self.inputs
        states[n, -1] = self.inputs[-1]
        for k in range(n - 1, -1, -1):
            rises = (states[k + 1 :, :-1] * powers[1 : n + 1 - k]).sum(axis=0)
            states[k, 1:] = np.cumsum(rises)
            states[k, np.abs(states[k]) <= self.negligible * np.abs(states[k]).max()] = 0.0
        return states

    def repaired(self, ends: FloatArray, sizes: FloatArray) -> Half | None:
        """Move the switches so that derivatives at the end have given values.

        Parameters
        ----------
        ends : (n + 1,) array
            NaN where the end is free.
        sizes : (n + 1,) array
            Of the derivatives.

        Returns
        -------
        Half or None
            None where no small change of the switches does it.
        """
        n, half = self.order, self
        fixed = np.flatnonzero(np.isfinite(ends))
        for _ in range(_REPAIRS):
            errors = (half.states()[fixed, -1] - ends[fixed]) / sizes[fixed]
            if np.abs(errors).max(initial=0.0) <= _MET:
                return half
            left = np.asarray(half.durations[::-1].cumsum()[-2::-1], dtype=float)
            jumps = -np.diff(half.inputs).astype(float)
            lag = n - 1 - fixed[:, None]
            slopes = jumps * left**lag * INVERSE_FACTORIALS[lag] / sizes[fixed, None]
            room = np.minimum(half.durations[1:], half.durations[:-1]).astype(float)
            steps = room * np.linalg.lstsq(slopes * room, -errors.astype(float), rcond=None)[0]
            durations = half.durations.copy()
            durations[:-1] += steps
            durations[1:] -= steps
            if not (durations > _SHORTEST * half.durations).all():
                return None
            half = Half(durations, half.inputs, n)
        return half


def merged(nodes: FloatArray, inputs: FloatArray, order: int, tolerance: float) -> Half:
    """Join neighbouring cells whose inputs differ by at most `tolerance`."""
    starts = np.flatnonzero(np.concatenate([[True], np.abs(np.diff(inputs)) > tolerance]))
    edges = np.append(nodes[:-1][starts], nodes[-1]).astype(np.longdouble)
    return Half(np.diff(edges), inputs[starts], order)


def whole_move(
    half: Half, distance: float, unit: float, limits: Limits, cruise: float = 0.0
) -> Trajectory:
    """Return the move whose first half this is, as fast as the limits allow.

    Parameters
    ----------
    half : Half
        Its derivatives 2, 4, … vanish at the end.
    distance : float
        Of the whole move, positive.
    unit : float
        Time unit of the half.
    limits : Limits
    cruise : float
        Time that goes on at the velocity of the half's end, until the middle.
    """
    n = half.order
    states, durations = half.states(), half.durations
    states[2:n:2, -1] = 0.0
    if cruise > 0.0:
        states[2:, -1] = 0.0
        middle = states[:, -1:].copy()
        middle[0] += middle[1] * cruise
        states, durations = np.hstack([states, middle]), np.append(durations, cruise)
    states *= distance / (2.0 * states[0, -1])
    states[0, -1] = 0.5 * distance
    unit *= _slowdown(np.asarray(states[:, :-1], float), durations, unit, limits)
    states /= np.longdouble(unit) ** np.arange(n + 1)[:, None]
    return _mirrored(states, durations * unit, distance)


def _slowdown(states: FloatArray, durations: RealArray, unit: float, limits: Limits) -> float:
    """Return the factor on time that brings every derivative to its bounds."""
    durations = np.asarray(durations, float)
    factor = 0.0
    for k in range(1, len(states)):
        low, high = extrema(durations, states[k:])
        least, most = float(low.min()), float(high.max())
        lower, upper = limits.bounds(k)
        if k % 2 == 0:
            least, most = min(least, -most), max(most, -least)
        excess = max(most / upper, least / lower) / unit**k
        factor = max(factor, excess ** (1.0 / k))
    return factor


def _mirrored(states: RealArray, durations: RealArray, distance: float) -> Trajectory:
    """Append x(t) = R − x(T − t) to a first half."""
    n = len(states) - 1
    signs = (-1.0) ** np.arange(1, n + 2)
    back = states[:, :0:-1] * signs[:, None]
    back[0] += distance
    back[n] = states[n, -2::-1] * signs[n]
    lengths = durations[::-1]
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    breaks = np.concatenate([edges, 2.0 * edges[-1] - edges[-2::-1]])
    if n % 2 or states[n, -2] == 0.0:  # the input goes on through the middle
        breaks = np.delete(breaks, len(durations))
        back, lengths = back[:, 1:], lengths[1:]
        durations = np.append(durations[:-1], 2.0 * durations[-1])
    end = np.zeros(n + 1)
    end[0] = distance
    return Trajectory.from_arrays(
        np.asarray(breaks, float),
        np.ascontiguousarray(np.hstack([states[:, :-1], back]).T, float),
        np.asarray(np.concatenate([durations, lengths]), float),
        end,
    )
