"""The simulation of a loop in the core: what it is given, and what comes back."""

from __future__ import annotations

from math import inf

import numpy as np

from .. import core
from ..shaping.pieces import FloatArray
from .commands import derivatives_of, on_breaks
from .core_numbers import fastest, memory_at_rest, sampled_steps, tuning
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
    if loop is not None and holding and controller.integral_gain:
        initial[loop.integral] = holding / controller.integral_gain
    z = layout.initial(initial)
    memory = np.zeros(4)
    if scene.is_digital:
        z[layout.held], memory = holding, memory_at_rest(controller, holding)
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
    torque_gains, position_gains = _gains(scene)
    tuned[3] = len(torque_gains) - 1.0
    segments, status = core.run_loop(
        numbers,
        tuned,
        *map(np.ascontiguousarray, (hybrid.rates, hybrid.rows, hybrid.next)),
        *(hybrid.onto, hybrid.along, z, layout.row(seen), layout.row(moved), sections),
        *(position_gains, torque_gains),
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
    summed = float(memory[1] if loop is None else z[loop.integral])
    return Run(
        scene,
        hybrid,
        layout,
        segments[:, 0],
        segments[:, 1].astype(int),
        segments[:, 2:],
        samples,
        controller.integral_gain * summed,
    )


def _gains(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the gains of torque and reference, by derivative, then of what an inverse adds."""
    f = scene.feedforward
    gains = np.array([each(max(f.order, 1)) for each in (f.torque_gains, f.position_gains)])
    if f.dynamics is not None and scene.is_digital:
        gains = np.hstack([gains, np.eye(2)])
    torque, position = np.ascontiguousarray(gains)
    return torque, position


def _sampled_command(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the command and its derivatives at all samples, and the same a lead later.

    Behind them stands what an inverse's dynamics add to torque and reference.
    """
    dt, f = scene.controller.sample_time, scene.feedforward
    if dt is None:
        return (np.empty((0, max(f.order, 1) + 1)),) * 2
    times = on_breaks(scene.command, scene.begin + dt * np.arange(float(scene.sample_count)))
    now = _columns(scene, times)
    if not f.lead:
        return now, now
    return now, _columns(scene, on_breaks(scene.command, np.asarray(times + f.lead)))


def _columns(scene: Scene, times: FloatArray) -> FloatArray:
    f = scene.feedforward
    rows = derivatives_of(scene.command, times, max(f.order, 1))
    if f.dynamics is not None:
        rows = np.vstack([rows, f.dynamics.added(scene.command, scene.begin, times)])
    return np.ascontiguousarray(rows.T)


def _numbers(
    scene: Scene, layout: Layout, hybrid: Hybrid, samples: int, settings: int
) -> tuple[list[float], list[float], FloatArray]:
    """Return the numbers of loop and controller, and the filters' sections, for the core."""
    c = scene.controller
    steps = _steps(scene, layout, hybrid)
    numbers = [layout.size, layout.moving, len(hybrid.modes), hybrid.rows.shape[1], *steps, 0]
    numbers += [scene.duration, c.delay, samples, layout.held]
    numbers += [settings, layout.chain, layout.held - layout.chain]
    tuned = tuning(c, scene.feedforward, scene.axis.torque_limit, scene.axis.encoder_step)
    sections = c.sections if scene.is_digital else np.empty((0, 5))
    return [float(x) for x in numbers], tuned, sections


def _steps(scene: Scene, layout: Layout, hybrid: Hybrid) -> tuple[float, float]:
    """Return two lengths of steps, the longer first, in which the Taylor series is exact."""
    norm = fastest(layout, hybrid)
    if scene.controller.sample_time is None:
        longest = min(2.0 / norm if norm else inf, scene.duration)
        return longest, longest
    return sampled_steps(norm, scene.controller.sample_time, scene.controller.delay)
