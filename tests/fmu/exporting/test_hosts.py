"""Our FMUs in hosts that are not ours: libcosimpy and ecospy agree with the Python models."""

import json
import os
import subprocess
import sys
from functools import cache

import every_block
import foreign_host
import numpy as np
import pytest
import scipy.integrate
from fmus import fmu_of, folder, needs_compiler
from handmade_ssps import binding, bindings, component, connection, linear, ssp, system

from jounce.fmu import load_ssp
from jounce.fmu.exporting.ssp import export_ssp
from jounce.plant import Inertia, InertiaFeedforward, ServoLoop, design_pid
from jounce.shaping import CommandFollower, JerkFilter, Limits, min_time_move

pytestmark = needs_compiler

DT, STEPS = 1.0 / 128.0, 300  # a whole number of nanoseconds, and of a double's bits
TOLERANCE = 1e-9
RUNS = [("libcosimpy", "2.0"), ("ecospy", "2.0"), ("ecospy", "3.0")]
"""libcosimpy 0.0.6 does not know FMI 3.0."""

J, MOTION = 2.0, ("position", "velocity", "acceleration")
MOVE = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=20.0))
JUMPING = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0))
FILTER = JerkFilter(4.0, 4)


def shaper():
    return MOVE


def plant():
    return Inertia(J)


def follower():
    return CommandFollower(Limits(velocity=0.8, acceleration=3.0), dt=DT, jerk_filter=FILTER)


def loop():
    gains = design_pid(J, crossover_hz=3.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    return ServoLoop(Inertia(J), gains, InertiaFeedforward(1.1 * J))


@cache
def why_not(package):
    """Return why a host cannot be loaded, or nothing; importing it loads native code."""
    code = f"import {package}"
    if package == "libcosimpy":
        code += ".CosimExecution"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    if done.returncode == 0:
        return ""
    reason = (done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"])[-1]
    remedy = "apt-get install libtbb12" if "libtbb" in reason else f"pip install {package}"
    return f"{package} cannot be loaded: {reason} ({remedy})"


@cache
def ssp_of(move, version, filtered):
    """Return the path of the exported loop."""
    path = folder() / f"loop_of_order_{move.order}_{version}_{filtered}.ssp"
    behind = FILTER if filtered else None
    options = {"fmi_version": version, "platforms": ["host"], "unit": "m"}
    export_ssp(path, move, loop(), dt=DT, jerk_filter=behind, **options)
    return path


def hosted(host, tmp_path, record, **task):
    """Return what a host gives for the names to record, after each step: (names, steps)."""
    if reason := why_not(host):
        pytest.skip(reason)
    task = {"host": host, "dt": DT, "steps": STEPS, "record": record, "inputs": {}} | task
    given, found = tmp_path / "task.json", tmp_path / "rows.json"
    given.write_text(json.dumps(task), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, foreign_host.__file__, given, found],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=tmp_path,
        env=os.environ | {"TMPDIR": str(tmp_path)},  # ecos leaves there what it unpacks
    )
    assert found.exists(), f"{host} ended with status {done.returncode}:\n{done.stderr[-3000:]}"
    return np.array(json.loads(found.read_text(encoding="utf-8"))).T


def close(found, expected):
    """Whether signals agree, each relative to its own largest value."""
    found, expected = np.atleast_2d(found), np.atleast_2d(expected)
    peaks = np.abs(expected).max(axis=1, keepdims=True)
    assert (peaks > 0.0).all()
    return bool((np.abs(found - expected) / peaks).max() <= TOLERANCE)


@pytest.mark.parametrize(("host", "version"), RUNS)
def test_blocks_run_in_a_foreign_host(host, version, tmp_path):
    models = {make.__name__: str(fmu_of(make, version)) for make in (shaper, plant, follower)}
    outputs = [f"{name}.{signal}" for name in ("shaper", "follower") for signal in MOTION]
    found = hosted(
        host,
        tmp_path,
        [*outputs, "plant.y", "plant.y_rate"],
        models=models,
        connections=[
            ("shaper.position", "follower.command"),
            ("shaper.velocity", "follower.command_velocity"),
        ],
        inputs={"plant.u": 1.5},
    )
    time = DT * np.arange(STEPS + 1)
    assert close(found[:3], [MOVE(time[1:], k) for k in range(3)])
    # as each tick sees the shaper at its own communication point
    model = follower()
    state, rows = model.rest(0.0), []
    for command, velocity in zip(MOVE(time[:-1]), MOVE(time[:-1], 1), strict=True):
        state = model.step(state, command, velocity)
        rows.append(model.output(state)[:3])
    assert close(found[3:6], np.array(rows).T)
    assert close(found[6:], [0.5 * 1.5 / J * time[1:] ** 2, 1.5 / J * time[1:]])


@pytest.mark.parametrize(("host", "version"), RUNS)
def test_a_digital_loop_that_sticks_runs_in_a_foreign_host(host, version, tmp_path):
    make, dt, steps = every_block.digital_loop, 1e-3, 600
    found = hosted(
        host,
        tmp_path,
        ["loop.r", "loop.y_motor", "loop.y_load"],
        models={"loop": str(fmu_of(make, version))},
        connections=[],
        dt=dt,
        steps=steps,
    )
    sampled = make()
    expected = sampled.loop.respond(sampled.trajectory, dt, duration=steps * dt)
    assert len(expected.friction_events) > 0
    rows = np.array([expected.command, expected.states[0], expected.load])
    assert close(found, rows[:, 1:])


def sampled_loop(commands):
    """Return y and u after each step, all blocks stepped at once: u acts one sample later.

    In the first step acts what the controller shows after its initialisation, the torque of its
    first tick.
    """
    model = loop()
    gains, j_hat = model.controller, model.feedforward.J_hat
    y = y_rate = integral = 0.0
    rows, shown = [], None
    for r, r_rate, r_acceleration in np.transpose(commands):
        error = r - y
        u = gains.kp * error + gains.ki * (integral + DT * error) + gains.kr * (r_rate - y_rate)
        u += j_hat * r_acceleration
        shown = u if shown is None else shown
        integral += DT * error
        y += DT * y_rate + 0.5 * DT**2 * shown / J
        y_rate += DT * shown / J
        shown = u
        rows.append((y, u))
    return np.transpose(rows)


@pytest.mark.parametrize("move", [MOVE, JUMPING], ids=["smooth", "jumping"])
@pytest.mark.parametrize(("host", "version"), RUNS)
def test_the_loop_runs_as_ssp_in_a_foreign_host(host, version, move, tmp_path):
    path = str(ssp_of(move, version, filtered=False))
    found = hosted(host, tmp_path, ["plant.y", "controller.u"], ssp=path)
    time = DT * np.arange(STEPS)
    assert close(found, sampled_loop([move(time, k) for k in range(3)]))


@pytest.mark.parametrize(("host", "version"), RUNS)
def test_the_loop_behind_a_filter_runs_as_ssp(host, version, tmp_path):
    found = hosted(
        host,
        tmp_path,
        ["filter.position", "plant.y", "controller.u"],
        ssp=str(ssp_of(MOVE, version, filtered=True)),
    )
    # the filter takes the move's acceleration as constant within each step
    commands = filtered_commands()
    assert close(found[0][:-1], commands[0][1:])
    assert close(found[1:], sampled_loop(commands))


@cache
def filtered_commands():
    """Return position, velocity, acceleration behind the filter at each tick, by small steps."""
    time = DT * np.arange(STEPS)
    weights = np.array([FILTER.derivative_weights(k)[1:] for k in range(3)])
    lags, rows = np.zeros(FILTER.order), [np.zeros(3)]
    for r in np.transpose([MOVE(time, k) for k in range(3)])[:-1]:

        def rate(t, x, r=r):
            command = r[0] + r[1] * t + 0.5 * r[2] * t**2
            return FILTER.omega * (np.concatenate([[command], x[:-1]]) - x)

        done = scipy.integrate.solve_ivp(
            rate, (0.0, DT), lags, method="DOP853", rtol=1e-12, atol=1e-14
        )
        lags = done.y[:, -1]
        rows.append(weights @ lags)
    return np.transpose(rows)


def test_an_ssp_by_hand_runs_as_in_libcosim(tmp_path):
    """Transformations and a parameter set are taken as another host takes them."""
    ends = (("u", "input"), ("y", "output"))
    sets = bindings(binding({"J": ("Real", 3.0)}))
    top = system(
        [component("a", ends, sets), component("b", ends)],
        [
            connection("a.y", "b.u", linear(2.0, 0.5)),
            connection("b.y", "a.u", linear(-0.25, 1.0)),
        ],
    )
    parts = [(f"resources/{name}.fmu", fmu_of(plant, "2.0").read_bytes()) for name in "ab"]
    path = ssp(tmp_path, top, {}, extra=parts)
    record = ["a.y", "b.y"]
    found = hosted("libcosimpy", tmp_path, record, ssp=str(path))
    with load_ssp(path) as whole:
        run = whole.run(STEPS * DT, dt=DT, order="jacobi")
    assert close(found, [run[name][1:] for name in record])
