"""Bounds of the rest of a response, beside the response itself, simulated on."""

from dataclasses import replace

import numpy as np
import pytest

from jounce.analysis.early_end import exact_figures
from jounce.analysis.specification import Move
from jounce.analysis.surveyed_moves import EXACT_FIGURES
from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    Notch,
    ServoLoop,
    Sine,
    TorqueSine,
)
from jounce.plant.response_figures import load_extremes
from jounce.plant.tail import tail_of
from jounce.shaping import Limits, min_time_move

DT = 2e-3
AXIS = Axis(
    1000.0,
    modes=[FlexibleMode(9.0, 0.02, load_fraction=0.5)],
    viscous=200.0,
    encoder_step=1e-7,
)
LAW = PID(4e4, 4e4, 1.2e4, derivative_filter=4e-3)
DIGITAL = Controller(
    LAW,
    filters=[Notch(9.0, zero_damping=0.1, pole_damping=0.6)],
    sample_time=DT,
    delay=1.5 * DT,
    anti_windup="conditional",
)
MOVE = min_time_move(0.06, Limits(0.18, 0.18, 0.7))
LOOPS = {
    "as it is": ServoLoop(AXIS, DIGITAL, Feedforward({1: 200.0, 2: 1000.0}, lead=2.0 * DT)),
    "without delay": ServoLoop(AXIS, replace(DIGITAL, delay=0.0)),
    "late": ServoLoop(AXIS, replace(DIGITAL, delay=7.0 * DT), Feedforward({2: 900.0})),
    "at the load": ServoLoop(
        replace(AXIS, sensor="load"),
        Controller(PID(8e3, 4e3, 3e3, derivative_filter=2e-2), sample_time=DT),
    ),
    "on two encoders": ServoLoop(replace(AXIS, sensor="both"), DIGITAL, Feedforward({2: 1000.0})),
    "under load": ServoLoop(replace(AXIS, constant_load=8.0, current_lag=5e-3), DIGITAL),
    "on a spring": ServoLoop(
        replace(AXIS, spring=500.0), DIGITAL, Feedforward({0: 400.0, 2: 1000.0})
    ),
    "without integral": ServoLoop(
        AXIS, Controller(PID(4e4, 0.0, 1.2e4, derivative_filter=4e-3), sample_time=DT)
    ),
    "of a cascade": ServoLoop(
        replace(AXIS, constant_load=-8.0),
        Controller(CascadedPI(4.0, 1e4, 0.8, velocity_filter=1e-3), sample_time=DT, delay=DT),
    ),
}


def responses_to(loop, samples, more):
    """Return a loop's response for so many samples, and one for more."""
    return [loop.respond(MOVE, times=[count * DT]) for count in (samples, samples + more)]


@pytest.mark.parametrize("name", LOOPS)
def test_what_follows_stays_within_its_bounds_and_comes_near_them(name):
    loop, samples = LOOPS[name], 900
    short, long = responses_to(loop, samples, 2000)
    tail = tail_of(short.run, loop.open_model())
    gone = []
    for after in (0, 200, 600):
        begin = (samples + after) * DT
        load = load_extremes(long, after=begin)
        position = load_extremes(long, of="position", after=begin)
        peaks = [max(high, -low) for low, high in (load, position)]
        peaks.append(np.abs(long.asked_torque[samples + after :]).max())
        assert (peaks <= tail.bounds(after)).all()
        gone.append(peaks)
    assert (tail.bounds() < 20.0 * np.array(gone[0])).all()
    until = tail.samples_until(2.0 * tail.still + 1e-7)
    assert (tail.bounds(until) < 2.0 * tail.still + 1e-7).all()
    assert not (tail.bounds(until - 1) < 2.0 * tail.still + 1e-7).all()
    assert tail.samples_until(0.9 * tail.still) is None


LIMITED = {
    f"limited to {limit} N m": ServoLoop(
        replace(AXIS, torque_limit=limit), DIGITAL, Feedforward({2: 1000.0})
    )
    for limit in (100.0, 170.0)
}


@pytest.mark.parametrize("name", LOOPS | LIMITED)
def test_figures_of_a_response_that_ends_early_are_those_of_the_whole(name, monkeypatch):
    loop = (LOOPS | LIMITED)[name]
    move = Move(name="far", distance=0.06, bounds=(0.18, 0.18, 0.7), limits_name="", settle_to=2e-5)
    whole = loop.respond(MOVE, times=[30.0])
    run = []
    monkeypatch.setattr("jounce.analysis.early_end.followed_for", lambda *_: 30.0)
    honest = ServoLoop.respond
    monkeypatch.setattr(
        ServoLoop, "respond", lambda *a, **k: run.append(k["duration"]) or honest(*a, **k)
    )
    figure = exact_figures(loop, MOVE, move, np.array([-1.0]))
    for known in ("settling_time_s", "load_settling_time_s", "saturated_time_s", "peak_error"):
        assert figure(known) == EXACT_FIGURES[known](whole, move, MOVE.duration)
    assert max(run) < 25.0
    for known, of in EXACT_FIGURES.items():
        assert figure(known) == pytest.approx(of(whole, move, MOVE.duration), rel=0, nan_ok=True)


def test_nothing_is_told_of_what_is_not_linear_or_not_over():
    loop = LOOPS["as it is"]
    nonlinear = {
        "friction": replace(loop, plant=replace(AXIS, friction=Friction(5.0, 6.0))),
        "clamp": replace(loop, controller=replace(DIGITAL, anti_windup=Clamp(50.0))),
        "unstable": replace(loop, controller=replace(DIGITAL, delay=60.0 * DT)),
        "loaded": replace(
            loop,
            plant=replace(AXIS, constant_load=30.0),
            controller=Controller(PID(4e4, 0.0, 1.2e4), sample_time=DT),
        ),
    }
    for other in nonlinear.values():
        run = other.respond(MOVE, times=[2.0]).run
        assert tail_of(run, other.open_model()) is None
    for command, given in (
        (MOVE, {"times": [0.2]}),
        (MOVE, {"times": [1.0], "disturbance": TorqueSine(1.0, 3.0, on="load")}),
        (MOVE, {"times": [1.0], "noise": np.zeros(500)}),
        (MOVE + Sine(1e-3, 1.0), {"times": [2.0]}),
    ):
        assert tail_of(loop.respond(command, **given).run, loop.open_model()) is None


def test_a_torque_at_its_limit_for_ever_is_followed_to_the_end():
    loop = replace(LOOPS["under load"], plant=replace(LOOPS["under load"].plant, torque_limit=8.01))
    short, _ = responses_to(loop, 1500, 1)
    tail = tail_of(short.run, loop.open_model())
    assert tail is None or not tail.bounds()[2] < 8.01
