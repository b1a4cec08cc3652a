"""Blocks that make commands: trajectory, command follower, jerk filter."""

from __future__ import annotations

import numpy as np

from ...shaping import CommandFollower, JerkFilter, Trajectory
from ...shaping.derivatives import derivative_name
from .blocks import (
    LEAST_POSITIVE,
    MAX_DOUBLE,
    Block,
    Variable,
    output,
    parameter,
    sample_time_constant,
    signal,
)
from .units import rate

_HIGHEST = 6  # derivative of the jerk filter's output that is put out; below its order, so that
# none needs the command itself
_TICKS = 1000  # of the default experiment

SAMPLING = (
    "Sample k runs in the communication step that starts at (or holds) the time start + k times "
    "the sample time, on the inputs set before that step. Samples are counted, so none is lost "
    "or run twice however the host adds up its time; communication steps may have any length."
)


def trajectory_block(trajectory: Trajectory, name: str, unit: str) -> Block:
    """Return a trajectory as a block without inputs."""
    orders = range(trajectory.order + 1)
    position, *others = [_derivative_name(k) for k in orders]
    outputs = [
        output(
            own,
            derivative_name(k).capitalize(),
            rate(unit, k),
            dependencies={"time": "dependent"},
            initial_dependencies={"delay": "dependent"} | ({} if k else {"offset": "constant"}),
        )
        for k, own in enumerate((position, *others))
    ]
    outside = np.array([trajectory.start_state, trajectory.end_state])
    outside[:, trajectory.coasting + 1 :] = 0.0
    rows = np.vstack([outside[:1], trajectory.states, outside[1:]])
    span = trajectory.duration or 1.0
    return Block(
        name,
        "Trajectory with bounded derivatives, an exact piecewise polynomial of time",
        (
            parameter("delay", "Time by which the motion starts later", 0.0, "s"),
            parameter("offset", "Distance by which the motion is moved", 0.0, unit),
            *outputs,
        ),
        "trajectory",
        constants={
            "ORDER": str(trajectory.order),
            "N_PIECES": str(len(trajectory.durations)),
            "LAST_STEP": "0",
        },
        tables={
            "breaks": trajectory.breaks.tolist(),
            "durations": trajectory.durations.tolist() or [0.0],
            "states": rows.tolist(),
        },
        memory=1,
        start_time=trajectory.start_time,
        stop_time=trajectory.start_time + span,
        step=span / _TICKS,
        notes=(
            "Before its start and after its end the motion coasts. At a break the value is that "
            "just after it; a time before a break by at most 1e-6 of the last communication step "
            "counts as the break, for hosts that add up their time.",
        ),
    )


def _derivative_name(k: int) -> str:
    return derivative_name(k).replace(" ", "_")


def _moving(unit: str, known: dict[str, str], highest: int) -> list[Variable]:
    """Return position and derivatives 1 … highest as outputs."""
    return [
        output(
            _derivative_name(k),
            f"{derivative_name(k).capitalize()} put out",
            rate(unit, k),
            initial_dependencies=known,
        )
        for k in range(highest + 1)
    ]


def follower_block(follower: CommandFollower, name: str, unit: str) -> Block:
    """Return a command follower as a block with a fixed sample time."""
    lags = 0 if follower.jerk_filter is None else follower.jerk_filter.order
    limits = [
        _limit(f"{derivative_name(k)}_{side}", bound, rate(unit, k))
        for k in range(1, follower.order + 1)
        for side, bound in zip(("min", "max"), follower.limits.bounds(k), strict=True)
    ]
    known = {"start_position": "dependent", "start_velocity": "dependent"}
    corner = [] if follower.jerk_filter is None else [_corner(follower.jerk_filter)]
    if corner:
        known["corner_hz"] = "dependent"
    constants = {
        "SAMPLE_TIME": repr(follower.dt),
        "N_LAGS": str(lags),
        "ORDER": str(follower.order),
        "PERIOD": "INFINITE" if follower.period is None else repr(follower.period),
    }
    return Block(
        name,
        "Command follower: keeps its limits whatever it is commanded, in minimum time",
        (
            *limits,
            *corner,
            *_start(unit),
            sample_time_constant(follower.dt),
            signal("command", "Position to go to, taken over at every sample", unit),
            signal("command_velocity", "Velocity at which the command goes on", rate(unit, 1)),
            *_moving(unit, known, follower.order),
        ),
        "following",
        constants=constants,
        memory=14 + lags,
        sample_time=follower.dt,
        stop_time=_TICKS * follower.dt,
        step=follower.dt,
        notes=(
            SAMPLING,
            "Outputs are those of the motion at the end of the communication step: with steps of "
            "one sample, the state that a sample leads to is visible at its end. Shorter steps "
            "show the motion inside the sample, which is exact. Limits and corner frequency "
            "are taken over with the command.",
        ),
    )


def _limit(name: str, bound: float, unit: str) -> Variable:
    """Return a tunable limit; one of no effect is the largest double."""
    what, side = name.split("_")
    upper = side == "max"
    return parameter(
        name,
        f"{'Upper' if upper else 'Lower'} limit of the {what}",
        min(max(bound, -MAX_DOUBLE), MAX_DOUBLE),
        unit,
        minimum=LEAST_POSITIVE if upper else None,
        maximum=None if upper else -LEAST_POSITIVE,
    )


def _corner(jerk_filter: JerkFilter) -> Variable:
    return parameter(
        "corner_hz",
        "Corner frequency of each lag of the jerk filter",
        jerk_filter.corner_hz,
        "Hz",
        minimum=LEAST_POSITIVE,
    )


def _start(unit: str) -> list[Variable]:
    return [
        parameter("start_position", "Position at the start", 0.0, unit, variability="fixed"),
        parameter(
            "start_velocity", "Velocity at the start", 0.0, rate(unit, 1), variability="fixed"
        ),
    ]


def jerk_filter_block(jerk_filter: JerkFilter, name: str, unit: str) -> Block:
    """Return a jerk filter as a block of continuous time."""
    m, highest = jerk_filter.order, min(jerk_filter.order - 1, _HIGHEST)
    lags = ["command", *(f"lag_{i}" for i in range(1, m + 1))]
    known = {"start_position": "constant", "start_velocity": "dependent", "corner_hz": "dependent"}
    states, rates = [], []
    for i in range(1, m + 1):
        told = f"Output of lag {i}"
        states.append(
            Variable(
                lags[i],
                told,
                "local",
                initial="calculated",
                unit=unit,
                state=True,
                initial_dependencies=known,
                macro="V_LAG" if i == 1 else "",
            )
        )
        rates.append(
            Variable(
                f"der({lags[i]})",
                f"Derivative of the {told[0].lower()}{told[1:]}",
                "local",
                initial="calculated",
                unit=rate(unit, 1),
                derivative_of=lags[i],
                dependencies={lags[i - 1]: "tunable", lags[i]: "tunable"},
                initial_dependencies=known | ({"command": "dependent"} if i == 1 else {}),
                macro="V_DER_LAG" if i == 1 else "",
            )
        )
    outputs = [
        output(
            _derivative_name(k),
            f"{derivative_name(k).capitalize()} put out",
            rate(unit, k),
            dependencies=dict.fromkeys(lags[m - k :], "tunable" if k else "constant"),
            initial_dependencies=known,
        )
        for k in range(highest + 1)
    ]
    settled = jerk_filter.settling_time(1e-6)
    return Block(
        name,
        f"Jerk filter: {m} equal first-order lags in series",
        (
            _corner(jerk_filter),
            *_start(unit),
            signal("command", "Command at the start of each step", unit),
            signal("command_velocity", "Its velocity there (0: it is held)", rate(unit, 1)),
            signal("command_acceleration", "Its acceleration during the step", rate(unit, 2)),
            *outputs,
            *states,
            *rates,
        ),
        "jerk_filter",
        constants={"N_LAGS": str(m), "N_OUTPUTS": str(highest + 1)},
        partials=True,
        stop_time=settled,
        step=settled / _TICKS,
        notes=(
            "Exact for a command that is a polynomial of second degree during each communication "
            "step; its velocity and acceleration are those at the step's start. It starts as if "
            "the command had coasted in for ever from start_position at start_velocity.",
        ),
    )
