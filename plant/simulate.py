"""The simulation of a loop in the core: what it is given, and what comes back."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import Any, NamedTuple

import numpy as np

from .. import core
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import shown
from .commands import derivatives_of, on_breaks
from .core_numbers import fastest, memory_at_rest, sampled_steps, tuning
from .hybrid import Hybrid, Mode, hybrid_of
from .layout import Layout, at_rest, layout_of
from .open_loop import OpenLoop, open_loop
from .run import Run, Scene


class _Prepared(NamedTuple):
    """A scene as the core takes it."""

    scene: Scene
    layout: Layout
    hybrid: Hybrid
    norm: float
    command: tuple[FloatArray, FloatArray]
    z: FloatArray
    samples: FloatArray
    memory: FloatArray
    integral: int | None
    given: tuple[Any, ...]


def simulate(scene: Scene) -> Run:
    """Run a scene in the core."""
    return simulate_all((scene,))[0]


def simulate_all(scenes: Iterable[Scene]) -> list[Run]:
    """Run scenes in the core one after the other, other threads meanwhile.

    The equations of an axis and the samples of a command are made once for all that follow one
    another with the same.
    """
    prepared: list[_Prepared] = []
    for scene in scenes:
        prepared.append(_prepared(scene, prepared[-1] if prepared else None))
    outcomes = core.run_loops(tuple(each.given for each in prepared))
    return [
        _run(each, segments, status)
        for each, (segments, status) in zip(prepared, outcomes, strict=True)
    ]


def _prepared(scene: Scene, last: _Prepared | None) -> _Prepared:
    axis, controller = scene.axis, scene.controller
    loop = None if scene.is_digital else open_loop(axis, controller, scene.feedforward)
    if last is not None and _same_equations(scene, last.scene):
        layout, hybrid, norm = last.layout, last.hybrid, last.norm
    else:
        layout = _layout(scene, loop)
        hybrid = hybrid_of(axis, controller, layout, loop, scene.feedforward.friction)
        norm = fastest(layout, hybrid)
    z, holding, first = _start(scene, layout, hybrid, loop)
    memory = memory_at_rest(controller, holding) if scene.is_digital else np.zeros(4)
    if last is not None and _same_command(scene, last.scene):
        command = last.command
    else:
        command = _sampled_command(scene)
    samples = np.zeros((len(command[0]), 3))
    times, values = layout.settings(scene.begin, scene.duration)
    numbers = _numbers(scene, layout, hybrid, norm, (first, len(samples), len(times)))
    tuned = tuning(controller, scene.feedforward, axis.torque_limit, axis.encoder_step)
    d = axis.dynamics
    seen = d.motor if axis.sensor == "motor" else d.load
    moved = d.load if axis.sensor == "load" else d.motor
    torque_gains, position_gains = _gains(scene)
    tuned[3] = len(torque_gains) - 1.0
    given = (
        *(numbers, tuned, hybrid.rates, hybrid.rows, hybrid.next, hybrid.onto, hybrid.along, z),
        *(layout.row(seen), layout.row(moved)),
        controller.sections if scene.is_digital else np.empty((0, 5)),
        *(position_gains, torque_gains),
        *(*command, np.empty(0) if scene.noise is None else scene.noise),
        *(times, values, memory, samples),
    )
    integral = None if loop is None else loop.integral
    return _Prepared(scene, layout, hybrid, norm, command, z, samples, memory, integral, given)


def _same_equations(scene: Scene, other: Scene) -> bool:
    """Whether two digital loops differ in their controllers alone, which run beside the axis."""
    return (
        scene.is_digital
        and other.is_digital
        and scene.disturbances == other.disturbances == ()
        and (scene.axis is other.axis or scene.axis == other.axis)
    )


def _same_command(scene: Scene, other: Scene) -> bool:
    """Whether the controllers of two loops are given the same numbers at their samples."""
    same = scene.command is other.command
    same = same and scene.feedforward.dynamics is other.feedforward.dynamics
    return same and all(
        one == two for one, two in zip(_sampling(scene), _sampling(other), strict=True)
    )


def _sampling(scene: Scene) -> tuple[float | None, float, int, float, int]:
    """Return what the samples of a command depend on, but for the command."""
    f = scene.feedforward
    return scene.controller.sample_time, scene.begin, scene.sample_count, f.lead, max(f.order, 1)


def _layout(scene: Scene, loop: OpenLoop | None) -> Layout:
    return layout_of(
        scene.axis.dynamics.size if loop is None else len(loop.a),
        scene.disturbances,
        None if scene.is_digital else scene.command,
        signed=loop is not None and scene.feedforward.friction > 0.0,
        rippling=scene.axis.ripple is not None,
    )


def _start(
    scene: Scene, layout: Layout, hybrid: Hybrid, loop: OpenLoop | None
) -> tuple[FloatArray, float, int]:
    """Return the state at the start, the torque that holds the axis, and the first mode."""
    axis = scene.axis
    rest, holding = at_rest(axis, scene.start)
    initial = np.append(rest, np.zeros(layout.loop - len(rest)))
    if loop is not None and holding and scene.controller.integral_gain:
        initial[loop.integral] = holding / scene.controller.integral_gain
    z = layout.initial(initial)
    if scene.is_digital:
        z[layout.held] = holding
    place = layout.level("ripple")
    if axis.ripple is None or place is None:
        return z, holding, 0
    motor = float(axis.dynamics.motor @ rest)
    z[place] = axis.ripple.turns_before(motor)
    return z, holding, hybrid.modes.index(Mode(ripple=axis.ripple.cell(motor)))


def _run(prepared: _Prepared, segments: FloatArray, status: int) -> Run:
    scene, z = prepared.scene, prepared.z
    if status == core.CHATTER:
        raise ValueError(
            f"the loop's modes change for ever at t = {segments[-1, 0]:.6g}: the anti-windup holds "
            "and releases the integral at the limit; use BackCalculation, or a sample time"
        )
    if status != core.OK and np.isfinite(z).all():
        raise ValueError(
            f"more than {len(segments)} steps and changes of friction or limit until "
            f"t = {segments[-1, 0]:.6g}: shorten the duration"
        )
    if not np.isfinite(z).all():
        raise ValueError(
            f"the response leaves the range of a double within {shown(scene.duration)}: "
            "the loop is "
            "unstable; shorten the duration"
        )
    times, modes, states = segments[:, 0], segments[:, 1].astype(int), segments[:, 2:]
    known = prepared.hybrid, prepared.layout
    summed = float(prepared.memory[1] if prepared.integral is None else z[prepared.integral])
    held = scene.controller.integral_gain * summed
    taken = prepared.samples, held, prepared.memory, prepared.norm
    return Run(scene, *known, times, modes, states, *taken)


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
    scene: Scene, layout: Layout, hybrid: Hybrid, norm: float, counts: tuple[int, int, int]
) -> list[float]:
    """Return the numbers of a loop for the core, `counts` its first mode, samples and settings."""
    first, samples, settings = counts
    steps = _steps(scene, norm)
    numbers = [layout.size, layout.moving, len(hybrid.modes), hybrid.rows.shape[1], *steps, first]
    numbers += [scene.duration, scene.controller.delay, samples, layout.held]
    numbers += [settings, layout.chain, layout.held - layout.chain]
    return [float(x) for x in numbers]


def _steps(scene: Scene, norm: float) -> tuple[float, float]:
    """Return two lengths of steps, the longer first, in which the Taylor series is exact."""
    if scene.controller.sample_time is None:
        longest = min(2.0 / norm if norm else inf, scene.duration)
        return longest, longest
    return sampled_steps(norm, scene.controller.sample_time, scene.controller.delay)
