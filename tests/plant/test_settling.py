"""When a response has settled."""

from math import inf, log, nan, pi

import numpy as np
import pytest

from jounce.plant import (
    Axis,
    Controller,
    FlexibleInertia,
    FlexibleMode,
    InertiaFeedforward,
    LoopResponse,
    ServoLoop,
    design_pid,
)
from jounce.shaping import JerkFilter, Limits, min_time_move


def curve(position, t):
    outputs = np.array([position, -position, 0.0 * position])
    return LoopResponse(t, np.zeros((3, t.size)), outputs, np.zeros((3, t.size)))


@pytest.mark.parametrize("dt", [0.1, 0.01])
@pytest.mark.parametrize("start", [0.0, -4.0, 30.0])
@pytest.mark.parametrize("tolerance", [0.5, 0.1, 1e-3])
def test_settling_of_an_exponential_is_its_logarithm(dt, start, tolerance):
    t = np.arange(0.0, 12.0, dt)
    response = curve(2.0 - np.exp(-t), start + t)
    assert response.settling_time(2.0, tolerance) == pytest.approx(
        -log(tolerance), abs=dt**2 / 8 + 1e-12
    )


def test_settling_counts_the_last_time_outside():
    t = np.linspace(0.0, 10.0, 100_001)
    response = curve(np.exp(-t) * np.cos(4 * pi * t), t)
    late = t[np.abs(np.exp(-t) * np.cos(4 * pi * t)) > 0.1][-1]
    assert response.settling_time(0.0, 0.1) == pytest.approx(late, abs=1.1e-4)


def test_settling_takes_no_time_or_for_ever():
    t = np.linspace(0.0, 1.0, 11)
    assert curve(np.full(11, 1.05), t).settling_time(1.0, 0.1) == 0.0
    assert curve(t, t).settling_time(0.0, 0.5) == inf
    assert curve(t, t).settling_time(1.0, 0.25) == pytest.approx(0.75)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, nan, inf])
def test_a_settling_tolerance_that_is_not_positive_is_refused(tolerance):
    t = np.linspace(0.0, 1.0, 11)
    with pytest.raises(ValueError, match=f"tolerance = {tolerance!r}: expected a positive"):
        curve(t, t).settling_time(0.0, tolerance)


def test_the_load_behind_a_jerk_filter_settles_later_than_the_motor():
    axis = FlexibleInertia(1.0, frequency_hz=6.0, damping=0.01, load_fraction=0.3)
    gains = design_pid(1.0, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    move = min_time_move(1.0, Limits(1.0, 4.0, 60.0))
    response = ServoLoop(axis, gains, InertiaFeedforward(1.0)).respond(
        move, 1e-3, duration=10.0, jerk_filter=JerkFilter(30.0, order=3)
    )
    usual, measured, load = (
        response.settling_time(1.0, 1e-3, of=of) for of in (None, "position", "load")
    )
    assert usual == measured < load - 0.5
    late = response.time[np.abs(response.load - 1.0) > 1e-3][-1]
    assert load == pytest.approx(late, abs=1.1e-3)


@pytest.mark.parametrize("target", [1.0, None])
@pytest.mark.parametrize("viscous", [0.0, 0.3])
def test_only_pieces_that_may_be_outside_are_made_and_none_is_missed(target, viscous):
    axis = Axis(
        1.0,
        modes=[FlexibleMode(6.0, damping=0.003, load_fraction=0.3)],
        viscous=viscous,
        sensor="motor",
    )
    law = design_pid(1.0, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    move = min_time_move(1.0, Limits(1.0, 4.0, 60.0))
    run = ServoLoop(axis, Controller(law, sample_time=2e-3)).respond(move, 0.01, duration=8.0).run
    command, goal = (-1.0, 0.0) if target is None else (0.0, target)
    last = []
    for tolerance in np.geomspace(1e-7, 2.0, 40):
        found = run.last_outside(run.load_row, command, goal, tolerance)
        assert found == run.pieces(run.load_row, command, goal).last_outside(tolerance)
        last.append(found)
    assert len(set(last)) > 20
    assert last == sorted(last, reverse=True)
