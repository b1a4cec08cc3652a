"""The simulation of a loop in the core: what it is given, and what comes back."""

from __future__ import annotations

from math import ceil, inf

import numpy as np

from .. import core
from ..shaping.pieces import FloatArray
from .anti_windup import BackCalculation, Clamp
from .cascade import CascadedPI
from .commands import derivatives_of, on_breaks
from .controller import Controller
from .hybrid import Hybrid, Mode, hybrid_of
from .layout import Layout, at_rest, layout_of
from .open_loop import open_loop
from .run import Run, Scene


def simulate(scene: Scene) -> Run:
    """Run a scene in the core."""
    axis, controller = scene.axis, scene.controller
    loop = None if scene.is_digital else open_loop(axis, controller, scene.feedforward)
    states = axis.dynamics.size if loop is None else len(loop.a)
    layout = layout_of(
        states,
        scene.disturbances,
        None if scene.is_digital else scene.command,
        signed=loop is not None and scene.feedforward.friction > 0.0,
        rippling=axis.ripple is not None,
    )
    hybrid = hybrid_of(axis, controller, layout, loop, scene.feedforward.friction)
    rest, holding = at_rest(axis, scene.start)
    initial = np.append(rest, np.zeros(states - len(rest)))
    preload = holding / controller.integral_gain if holding and controller.integral_gain else 0.0
    if loop is not None:
        initial[loop.integral] = preload
    z = layout.initial(initial)
    memory = np.zeros(4 + 2 * (len(controller.sections) if scene.is_digital else 0))
    if scene.is_digital:
        z[layout.held], memory[1] = holding, preload
        _preload_filters(controller, memory, holding)
    first, place = 0, layout.level("ripple")
    if axis.ripple is not None and place is not None:
        motor = float(axis.dynamics.motor @ rest)
        z[place] = axis.ripple.turns_before(motor)
        first = hybrid.modes.index(Mode(ripple=axis.ripple.cell(motor)))
    times, values = layout.settings(scene.begin, scene.duration)
    commands, ahead = _sampled_command(scene)
    samples = np.zeros((len(commands), 3))
    numbers, tuned, sections = _numbers(scene, layout, hybrid, len(commands), len(times))
    numbers[6] = first
    d = axis.dynamics
    seen = d.motor if axis.sensor == "motor" else d.load
    moved = d.load if axis.sensor == "load" else d.motor
    highest = int(tuned[3])
    segments, status = core.run_loop(
        numbers,
        tuned,
        *map(np.ascontiguousarray, (hybrid.rates, hybrid.rows, hybrid.next)),
        *(hybrid.onto, hybrid.along, z, layout.row(seen), layout.row(moved), sections),
        scene.feedforward.position_gains(highest),
        scene.feedforward.torque_gains(highest),
        *(commands, ahead, np.empty(0) if scene.noise is None else scene.noise),
        *(times, values, memory, samples),
    )
    if status == core.CHATTER:
        raise ValueError(
            f"the loop's modes change for ever at t = {segments[-1, 0]:.6g}: the anti-windup holds "
            "and releases the integral at the limit; use BackCalculation, or a sample time"
        )
    if status != core.OK and np.isfinite(z).all():
        raise ValueError(
            f"friction or limit changes more than {len(segments)} times until "
            f"t = {segments[-1, 0]:.6g}: shorten the duration"
        )
    if not np.isfinite(z).all():
        raise ValueError(
            f"the response leaves the range of a double within {scene.duration!r}: the loop is "
            "unstable; shorten the duration"
        )
    return Run(
        scene,
        hybrid,
        layout,
        segments[:, 0],
        segments[:, 1].astype(int),
        segments[:, 2:],
        samples,
    )


def _preload_filters(controller: Controller, memory: FloatArray, holding: float) -> None:
    """Put filters into the state of a constant torque."""
    x = holding
    for i, (b0, b1, b2, a1, a2) in enumerate(controller.sections):
        y = x * (b0 + b1 + b2) / (1.0 + a1 + a2) if holding else 0.0
        memory[4 + 2 * i], memory[5 + 2 * i] = y - b0 * x, b2 * x - a2 * y
        x = y


def _sampled_command(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the command and its derivatives at all samples, and the same a lead later."""
    dt, f = scene.controller.sample_time, scene.feedforward
    highest = max(f.order, 1)
    if dt is None:
        return np.empty((0, highest + 1)), np.empty((0, highest + 1))
    times = on_breaks(scene.command, scene.begin + dt * np.arange(float(scene.sample_count)))
    now = np.ascontiguousarray(derivatives_of(scene.command, times, highest).T)
    if not f.lead:
        return now, now
    later = on_breaks(scene.command, np.asarray(times + f.lead))
    return now, np.ascontiguousarray(derivatives_of(scene.command, later, highest).T)


def _numbers(
    scene: Scene, layout: Layout, hybrid: Hybrid, samples: int, settings: int
) -> tuple[list[float], list[float], FloatArray]:
    """Return the numbers of loop and controller, and the filters' sections, for the core."""
    steps = _steps(scene, layout, hybrid)
    numbers = [layout.size, layout.moving, len(hybrid.modes), hybrid.rows.shape[1], *steps, 0]
    numbers += [scene.duration, scene.controller.delay, samples, layout.held]
    numbers += [settings, layout.chain, layout.held - layout.chain]
    c, law, way = scene.controller, scene.controller.law, scene.controller.anti_windup
    kinds = {"conditional": 1, BackCalculation: 2, Clamp: 3}
    winding = kinds.get(way if isinstance(way, str) else type(way), 0)
    sections = c.sections if scene.is_digital else np.empty((0, 5))
    cascade = isinstance(law, CascadedPI)
    gains = (
        [law.velocity_gain, law.integral_gain, 0.0]
        if isinstance(law, CascadedPI)
        else [
            law.kp,
            law.ki,
            law.kr,
        ]
    )
    outer = (
        [law.position_gain, law.velocity_feedforward] if isinstance(law, CascadedPI) else [0.0] * 2
    )
    tuned = [float(cascade), winding, len(sections), max(scene.feedforward.order, 1)]
    tuned += [c.sample_time or 1.0, *gains, c.rate_filter, *outer]
    tuned += [scene.feedforward.friction, scene.axis.torque_limit]
    tuned += [way.tracking_time if isinstance(way, BackCalculation) else 1.0]
    tuned += [way.integral_limit if isinstance(way, Clamp) else inf, scene.axis.encoder_step]
    return [float(x) for x in numbers], [float(x) for x in tuned], sections


def _steps(scene: Scene, layout: Layout, hybrid: Hybrid) -> tuple[float, float]:
    """Return two lengths of steps, the longer first, in which the Taylor series is exact."""
    from scipy.linalg import matrix_balance

    own = layout.chain
    norm = 0.0
    for rates in hybrid.rates:
        balanced = matrix_balance(rates[:own, :own], permute=False)[0]
        norm = max(norm, float(np.abs(balanced).sum(axis=0).max(initial=0.0)))
    dt = scene.controller.sample_time
    if dt is None:
        longest = min(2.0 / norm if norm else inf, scene.duration)
        return longest, longest
    rest = scene.controller.delay % dt
    if rest < 1e-9 * dt or dt - rest < 1e-9 * dt:
        rest = 0.0
    lengths = [part / max(ceil(0.5 * norm * part), 1) for part in (rest, dt - rest) if part]
    return max(lengths), min(lengths)
