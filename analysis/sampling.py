"""When a response is looked at: finely while anything fast goes on, coarsely in a slow tail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..shaping.pieces import FloatArray

_FINE = 0.01  # of the shortest time scale: a peak between two samples is missed by 1e-5 of itself
_MOST = 1_000_000  # fine samples
_TAIL = 4_000  # samples of the tail
_FAST = 0.02  # a mode that decays at this part of the largest pole, or faster, is not the tail's


@dataclass(frozen=True)
class Clock:
    """Sampling of a response: every `step` until `fast`, more coarsely until `horizon`."""

    step: float
    fast: float
    horizon: float


def clock_for(
    poles: NDArray[np.complex128], decay: float, *, lead: float = 0.0, quickest: float = inf
) -> Clock:
    """Return how to sample a response of a stable system.

    Parameters
    ----------
    poles : (n,) complex array
        Its poles.
    decay : float
        Every mode is followed until it has died away to exp(−decay).
    lead : float, optional
        Time for which the input goes on.
    quickest : float, optional
        Shortest time scale of the input.
    """
    rates, size = -poles.real, float(np.abs(poles).max())
    fast = lead + decay / float(rates[rates >= _FAST * size].min(initial=size))
    horizon = max(fast, lead + decay / float(rates.min()))
    return Clock(max(_FINE * min(1.0 / size, quickest), fast / _MOST), fast, horizon)


def followed(
    respond: Callable[[float, float], tuple[FloatArray, ...]], clock: Clock
) -> tuple[FloatArray, ...]:
    """Return a response, sampled by a clock.

    Parameters
    ----------
    respond : callable
        From spacing and duration to arrays with time last, the times themselves first.
    clock : Clock
    """
    fine = respond(clock.step, clock.fast)
    if clock.horizon <= clock.fast:
        return fine
    tail = respond(clock.horizon / _TAIL, clock.horizon)
    later = tail[0] > fine[0][-1]
    return tuple(
        np.concatenate([f, t[..., later]], axis=-1) for f, t in zip(fine, tail, strict=True)
    )


def thinned(arrays: tuple[FloatArray, ...], most: int) -> tuple[Any, ...]:
    """Return at most so many samples of arrays with time last, equally far apart by number."""
    stride = -(-arrays[0].shape[-1] // most)
    return arrays if stride == 1 else tuple(array[..., ::stride].copy() for array in arrays)
