"""What a digital loop can still do behind a run: bounds, by the modes of the sampled loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..shaping.pieces import FloatArray
from .anti_windup import Clamp
from .cascade import CascadedPI
from .commands import Command, breaks_of, derivatives_of, highest_order, sines_of
from .core_numbers import memory_at_rest
from .layout import at_rest
from .models import StateModel
from .run import Run, Scene

_TERMS = 25  # of the Taylor series over a sample
_FASTEST = 4.0  # rate·sample: the series is complete to 1e-10 of what it bounds
_ROUNDING = 1e-15
_COUPLED = 1e-2  # the most that rounding may join modes which decompose the loop
_FAR = 2**20  # samples: what is not within its bounds by then is not waited for


@dataclass(frozen=True, eq=False)
class Tail:
    """Bounds of the signals of a linear loop behind the end of a run.

    At k samples and ever after

        |s(t)| ≤ still + gains·decay^k,  t ≥ k samples.

    The signals are load and measured position, both less the command, which stands still, and the
    torque that is asked for.

    Attributes
    ----------
    gains : (3, n) array
        By signal and mode.
    decay : (n,) array
        |z| of the modes, below 1.
    still : (3,) array
        What stays: the load that hangs on its springs, the encoder's resolution through the loop.
    """

    gains: FloatArray
    decay: FloatArray
    still: FloatArray

    def bounds(self, samples: int = 0) -> FloatArray:
        """Return the bounds of load, position and torque from so many samples on, (3,)."""
        return np.asarray(self.still + self.gains @ self.decay**samples)

    def samples_until(self, most: FloatArray) -> int | None:
        """Return after how many samples all bounds are below these for good; None for never."""
        high = 0
        while not (self.bounds(high) < most).all():
            high = max(2 * high, 1)
            if high > _FAR:
                return None
        low = high // 2
        while high - low > 1:
            middle = (low + high) // 2
            fits = (self.bounds(middle) < most).all()
            low, high = (low, middle) if fits else (middle, high)
        return high


def tail_of(run: Run, loop: StateModel) -> Tail | None:
    """Return what bounds the rest of a digital loop's response; None where nothing known does.

    The run ends on a sample, its command at rest by then. From there on the loop is linear if the
    bound of the torque is within its limit: x⁺ = A·x + b·q, x its states less those at rest,
    |q| ≤ half a step of the encoder. With A·V = V·Λ,

        |c·x_k| ≤ Σ_i |c·v_i|·(|λ_i|^k·|w_i·x_0| + |w_i·b|·|q|/(1 − |λ_i|)),

    and between two samples by the Taylor series of the axis, term by term. What rounding leaves of
    V⁻¹·A·V − Λ is taken into account, to first order.

    Parameters
    ----------
    run : Run
    loop : StateModel
        The open loop, as `ServoLoop.open_model` gives it.
    """
    scene = run.scene
    dt = scene.controller.sample_time
    if dt is None or run.fastest * dt > _FASTEST or not _goes_on_linearly(scene):
        return None
    closed = loop.feedback()
    rest = _at_rest(run, len(closed.A))
    if rest is None:
        return None
    values, vectors = np.linalg.eig(closed.A)
    decay = np.abs(values)
    if not decay.max(initial=0.0) < 1.0:
        return None
    try:
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    lasting = 1.0 / (1.0 - decay)
    joined = np.abs(inverse @ closed.A @ vectors - np.diag(values))
    if not (lasting * joined.sum(axis=1)).max() < _COUPLED:
        return None
    deviation, sizes, still = rest
    start = np.abs(inverse @ deviation) + _ROUNDING * (np.abs(inverse) @ sizes)
    read = _reading(scene, loop)
    steps = 0.5 * scene.axis.encoder_step * np.abs(inverse @ read).sum(axis=1)
    ever = lasting * (steps + (1.0 + _COUPLED) * (joined @ start))
    seen = _seen(scene, closed, vectors)
    direct = 0.5 * scene.axis.encoder_step * np.abs(scene.controller.sampled_model().D).sum()
    return Tail(seen * start, decay, still + seen @ ever + np.array([0.0, 0.0, direct]))


def _goes_on_linearly(scene: Scene) -> bool:
    """Whether nothing acts behind the command but the loop, whose only limit is the torque's."""
    axis, feedforward = scene.axis, scene.feedforward
    bare = axis.friction is None and axis.ripple is None and scene.noise is None
    fixed = feedforward.dynamics is None and not isinstance(scene.controller.anti_windup, Clamp)
    return bare and fixed and not scene.disturbances and _is_over(scene)


def _is_over(scene: Scene) -> bool:
    """Whether the command stands still from the end of the run on."""
    end = scene.begin + scene.duration
    if sines_of(scene.command) or end < breaks_of(scene.command)[-1]:
        return False
    return not _standing(scene.command, end)[1:].any()


def _standing(command: Command, time: float) -> FloatArray:
    return derivatives_of(command, np.array([time]), max(highest_order(command), 1))[:, 0]


def _at_rest(run: Run, size: int) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return the closed loop's states less those at rest, of what size they are, and what stays.

    They are, as `StateModel.behind` has them, those of axis, past torques, and controller, whose
    signs are those of an open loop: it is fed with the position, not with the error.
    """
    scene, d = run.scene, run.scene.axis.dynamics
    order = max(scene.feedforward.order, 1)
    command = _standing(scene.command, scene.begin + scene.duration)[0]
    reference = command * scene.feedforward.position_gains(order)[0]
    axis, holding = at_rest(scene.axis, reference)
    asked = holding - command * scene.feedforward.torque_gains(order)[0]
    if abs(asked) <= _ROUNDING * abs(holding):
        asked = 0.0
    elif not scene.controller.integral_gain:
        return None
    places, signs = scene.controller.memory_places
    past = size - d.size - len(places)
    if past > len(run.samples):
        return None
    settled = memory_at_rest(scene.controller, asked / _standing_gain(scene.controller.sections))
    motor = float((d.load if scene.axis.sensor == "load" else d.motor) @ axis)
    cascade = isinstance(scene.controller.law, CascadedPI)
    settled[2] = motor if cascade else reference - motor
    now = np.concatenate(
        [run.states[-1, : d.size], run.samples[::-1][:past, 2], signs * run.memory[places]]
    )
    then = np.concatenate([axis, np.full(past, holding), signs * settled[places]])
    seen = d.motor if scene.axis.sensor == "motor" else d.load
    still = np.array([abs(d.load @ axis - command), abs(seen @ axis - command), abs(holding)])
    return now - then, np.abs(now) + np.abs(then), still


def _standing_gain(sections: FloatArray) -> float:
    """Return what filters make of a constant."""
    return float(np.prod(sections[:, :3].sum(axis=1) / (1.0 + sections[:, 3:].sum(axis=1))))


def _reading(scene: Scene, loop: StateModel) -> FloatArray:
    """Return what errors of the encoders, or of the one, add to the closed loop's states."""
    controller = scene.controller.sampled_model()
    axis = loop.nstates - controller.nstates
    read = np.vstack([-loop.B[:axis] @ controller.D, controller.B])
    return read if scene.axis.sensor == "both" else read.sum(axis=1, keepdims=True)


def _seen(scene: Scene, closed: StateModel, vectors: FloatArray) -> FloatArray:
    """Return by how much each mode is at most seen in the signals until the next sample, (3, n)."""
    d, dt = scene.axis.dynamics, scene.controller.sample_time or 0.0
    torque = np.abs(closed.C[0] @ vectors)
    past = np.abs(vectors[d.size : closed.nstates - scene.controller.sampled_model().nstates])
    fed = np.vstack([past, torque]).max(axis=0)
    position = d.motor if scene.axis.sensor == "motor" else d.load
    rows = [np.array([d.load, position])]
    for k in range(1, _TERMS):
        rows.append(rows[-1] @ d.a * (dt / k))
    terms, ahead = np.array(rows), dt / np.arange(1.0, _TERMS + 1.0)
    held = (np.abs(terms @ d.b[:, 0]) * ahead[:, None]).sum(axis=0)
    total = np.abs(terms @ vectors[: d.size]).sum(axis=0) + held[:, None] * fed
    return np.vstack([total, torque])
