"""The lags of a jerk filter behind a follower, exact inside each sample.

Behind a polynomial r(t) lag i settles to the polynomial (1 + s/ω)^−i r, a finite sum over the
derivatives of r; what it differs from that by decays as exp(−ωt) times powers of ωt.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import comb, exp

import numpy as np

from ..jerk_filter import JerkFilter
from ..pieces import FloatArray
from ..transfers.task import Piece, taylor

_SAME = 1e-12  # relative difference of two states that is rounding


def advance(
    lags: Sequence[float], motion: Sequence[float], tau: float, jerk_filter: JerkFilter
) -> list[float]:
    """Return the lags a time `tau` after the motion had the derivatives 0, 1, … given."""
    before = _settled(motion, jerk_filter)
    after = _settled(taylor(motion, tau), jerk_filter)
    off = [lag - level for lag, level in zip(lags, before, strict=True)]
    weights = [exp(-jerk_filter.omega * tau)]
    for j in range(1, len(off)):
        weights.append(weights[-1] * jerk_filter.omega * tau / j)
    return [
        level + sum(weights[j] * off[i - j] for j in range(i + 1)) for i, level in enumerate(after)
    ]


def _settled(motion: Sequence[float], jerk_filter: JerkFilter) -> list[float]:
    """Return what each lag settles to: Σ_k (−1)^k·C(i + k − 1, k)·r^(k)/ω^k."""
    scaled = [value / (-jerk_filter.omega) ** k for k, value in enumerate(motion)]
    return [
        sum(comb(i + k - 1, k) * value for k, value in enumerate(scaled))
        for i in range(1, jerk_filter.order + 1)
    ]


class Lags:
    """The lags over samples of one length, in most of which the highest derivative is constant."""

    def __init__(self, jerk_filter: JerkFilter, order: int, dt: float) -> None:
        self._filter, self._dt = jerk_filter, dt
        unit_lags, unit_motions = np.eye(jerk_filter.order), np.eye(order + 1)
        nothing = [0.0] * jerk_filter.order, [0.0] * (order + 1)
        self._from_lags = np.array(
            [advance(lags, nothing[1], dt, jerk_filter) for lags in unit_lags.tolist()]
        ).T
        self._from_motion = np.array(
            [advance(nothing[0], motion, dt, jerk_filter) for motion in unit_motions.tolist()]
        ).T

    def after_sample(self, lags: FloatArray, motion: Sequence[float]) -> FloatArray:
        """Return the lags after a sample of one polynomial piece."""
        return np.asarray(self._from_lags @ lags + self._from_motion @ np.asarray(motion))

    def after_pieces(self, lags: FloatArray, pieces: Iterable[Piece]) -> FloatArray:
        """Return the lags after a sample that begins with these pieces."""
        left, state = self._dt, lags.tolist()
        for duration, motion in pieces:
            tau = min(duration, left)
            state = advance(state, motion, tau, self._filter)
            left -= tau
            if left <= 0.0:
                break
        return np.array(state)


def one_piece(before: Sequence[float], after: Sequence[float], dt: float) -> bool:
    """Tell whether the highest derivative after a sample was in force during all of it."""
    reached = taylor([*before[:-1], after[-1]], dt)
    scale = [abs(a) + abs(b) + abs(a - b) for a, b in zip(before, after, strict=True)]
    return all(abs(a - b) <= _SAME * s for a, b, s in zip(reached, after, scale, strict=True))


def output(state: FloatArray, lags: FloatArray, omega: float) -> FloatArray:
    """Return position and derivatives behind the lags, shape of `state`.

    Parameters
    ----------
    state : (order + 1, …) array
        Position and derivatives before the lags.
    lags : (m, …) array
    omega : float
        Corner frequency: lag j changes by ω·(lag j−1 − lag j).
    """
    rows, chain = [], np.concatenate([state[:1], lags])
    for k in range(len(state)):
        rows.append(chain[-1])
        changes = omega * (chain[:-1] - chain[1:])
        chain = np.concatenate([state[k + 1 : k + 2], changes]) if k + 1 < len(state) else chain
    return np.array(rows)
