"""The unit step response of a closed loop, and its figures."""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from ..plant import ServoLoop
from ..plant.exact_response import respond_on_grid
from ..plant.models import StateModel
from ..shaping import Trajectory
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.told import Told
from ..shaping.trajectory import point
from .sampling import clock_for, followed, thinned
from .surveyed_loop import followed_until, is_ideal, linear_part

KEPT = 50_000
"""Samples kept of a response, of all those that its figures are taken from."""

_PER_SAMPLE = 10
_DECAY = log(1e5)  # every mode is followed until this much of it has died away


@dataclass(frozen=True, eq=False, repr=False)
class StepResponse(Told, Frozen):
    """Response of the closed loop, without feedforward, to a unit step of the command.

    `rise_time_s` is from 10 to 90 %, `settling_time_s` to ±2 %.
    """

    time: FloatArray
    position: FloatArray
    overshoot_percent: float
    peak_time_s: float
    rise_time_s: float
    settling_time_s: float


def step_response(loop: ServoLoop, poles: NDArray[np.complex128]) -> StepResponse:
    """Return the response of a stable loop's linear part, without feedforward, to a unit step.

    Parameters
    ----------
    loop : ServoLoop
    poles : (n,) complex array
        Its closed-loop poles in rad/s.

    Notes
    -----
    Exact at the samples. Overshoot to 1e-5 of the step; times to 1 % of the fastest mode's, of a
    digital loop to a hundredth of its sample.
    """
    samples = _sampled_step(loop, poles) if loop.is_digital else _continuous_step(loop, poles)
    time, position = samples
    peak_time, peak = _vertex(time, position)
    outside = np.flatnonzero(np.abs(position - 1.0) > 0.02)
    kept_time, kept_position = thinned(samples, KEPT)
    return StepResponse(
        kept_time,
        kept_position,
        overshoot_percent=100.0 * max(peak - 1.0, 0.0),
        peak_time_s=peak_time,
        rise_time_s=_first_reach(time, position, 0.9) - _first_reach(time, position, 0.1),
        settling_time_s=float(time[min(outside[-1] + 1, time.size - 1)]) if outside.size else 0.0,
    )


def _continuous_step(loop: ServoLoop, poles: NDArray[np.complex128]) -> tuple[FloatArray, ...]:
    bare = ServoLoop(loop.plant, loop.controller)
    closed = _from_position(bare.model if is_ideal(bare) else linear_part(bare).model)

    def respond_to_step(dt: float, duration: float) -> tuple[FloatArray, ...]:
        still = np.zeros(closed.nstates)
        time, *_, outputs = respond_on_grid(closed, (0,), point(1.0, 1), dt, duration, still)
        return time, outputs[0]

    return followed(respond_to_step, clock_for(poles, _DECAY))


def _from_position(system: StateModel) -> StateModel:
    """Return r → y of a system (r, ṙ, …) → (y, …), the derivatives taken inside.

    With s^k·(s − A)⁻¹ = (s − A)⁻¹·A^k + Σ_j A^j·s^(k−1−j), of which y sees j = k − 1 alone.
    """
    a, b, c = system.A, system.B, system.C[:1]
    direct, drive, power = system.D[0, 0], b[:, :1], np.eye(len(a))
    for k in range(1, b.shape[1]):
        direct = direct + (c @ power @ b[:, k]).item()
        power = power @ a
        drive = drive + power @ b[:, k : k + 1]
    return StateModel(a, drive, c, np.array([[direct]]))


def _sampled_step(loop: ServoLoop, poles: NDArray[np.complex128]) -> tuple[FloatArray, ...]:
    """Return the response to a step that comes with the second sample, which it starts from."""
    duration = followed_until(loop, poles, _DECAY)
    dt = float(loop.controller_noun.sample_time or 1.0)
    count = int(min(_PER_SAMPLE * duration / dt, KEPT))
    times = np.linspace(0.0, duration, count + 1)
    before = np.array([[0.0, 0.0], [1.0, 0.0]])
    step = Trajectory(np.array([0.0, dt, 2.0 * dt]), before, end_state=before[1])
    response = linear_part(loop).respond(step, times=dt + times)
    return times, response.position


def _vertex(time: FloatArray, values: FloatArray) -> tuple[float, float]:
    """Return time and value of the maximum, from the parabola through its three samples."""
    k = int(values.argmax())
    if not 0 < k < values.size - 1:
        return float(time[k]), float(values[k])
    before, here, after = values[k - 1 : k + 2]
    offset = 0.5 * (before - after) / (before - 2.0 * here + after)
    step = time[k + 1] - time[k]
    return float(time[k] + offset * step), float(here - 0.25 * (before - after) * offset)


def _first_reach(time: FloatArray, values: FloatArray, level: float) -> float:
    """Return when a response that starts below a level first reaches it."""
    k = int(np.argmax(values >= level))
    fraction = (level - values[k - 1]) / (values[k] - values[k - 1])
    return float(time[k - 1] + fraction * (time[k] - time[k - 1]))
