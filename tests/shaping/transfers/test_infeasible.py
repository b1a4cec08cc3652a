"""InfeasibleError: what it names can be reached, and nothing beyond."""

import pickle
import re
import traceback
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from references import assert_sound_transfer
from strategies import TransferProblem, random_transfer

from jounce.shaping import InfeasibleError, Limits, min_time_transfer, velocity_transfer
from jounce.shaping.transfers.infeasible import LaterReason, Reason

LIMITS = Limits(velocity=(-2.0, 1.0), acceleration=(-3.0, 2.0), jerk=(-4.0, 8.0))


def refused(problem):
    """Return the error that a problem is refused with."""
    with pytest.raises(InfeasibleError) as caught:
        problem.solve()
    change = {"acceleration": problem.end[2]} if len(problem.end) == 3 else {}
    with pytest.raises(InfeasibleError) as again:
        velocity_transfer(problem.start, problem.end[1], problem.limits, **change)
    assert (again.value.bound, again.value.nearest) == (caught.value.bound, caught.value.nearest)
    return caught.value


def assert_nearest(problem, error, place):
    """Assert that the nearest value can be reached, and nothing beyond it."""

    def ending_at(value):
        end = [*problem.end]
        end[place] = value
        return replace(problem, end=tuple(end))

    assert_sound_transfer(ending_at(error.nearest), ending_at(error.nearest).solve())
    beyond = problem.end[place] - error.nearest
    for part in (1e-9, 1e-3, 0.5):
        value = error.nearest + part * beyond
        if abs(value - error.nearest) > 1e-12 * abs(error.nearest):
            refused(ending_at(value))
    assert f"{error.nearest!r}" in str(error)
    assert f"{problem.end[place]!r}" in str(error)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("factor", [1.0 + 1e-6, 1.5, 100.0])
@pytest.mark.parametrize("side", [0, 1])
def test_an_end_velocity_outside_its_bounds(order, factor, side):
    pairs = ((-2.0, 1.0), (-3.0, 2.0), (-4.0, 8.0))[:order]
    end = (1.0, factor * pairs[0][side], 0.0)[:order]
    problem = TransferProblem((0.0,) * order, end, pairs)
    error = refused(problem)
    assert (error.bound, error.nearest) == ("velocity", pairs[0][side])
    assert_nearest(problem, error, 1)


@pytest.mark.parametrize("value", [2.0 + 1e-6, 7.0, -3.1, -300.0])
def test_an_end_acceleration_outside_its_bounds(value):
    bounds = ((-2.0, 1.0), (-3.0, 2.0), (-4.0, 8.0))
    problem = TransferProblem((0.0, 0.0, 0.0), (1.0, -0.5, value), bounds)
    error = refused(problem)
    assert (error.bound, error.nearest) == ("acceleration", 2.0 if value > 0.0 else -3.0)
    assert_nearest(problem, error, 2)


@pytest.mark.parametrize("seed", range(60))
def test_an_end_acceleration_that_cannot_be_built_up_within_the_velocity_bounds(seed):
    """Rising to a1 takes a velocity of v1 − a1²/(2·rise) before, where acceleration is zero."""
    rng = np.random.default_rng((4, seed))
    problem = random_transfer(rng)
    (v_min, v_max), (a_min, a_max), (fall, rise) = problem.bounds
    up = rng.random() < 0.5
    most = 0.5 * a_max**2 / rise if up else -0.5 * a_min**2 / fall
    room = min(most, v_max - v_min) * float(rng.uniform(0.01, 0.9))
    velocity = v_min + room if up else v_max - room
    acceleration = a_max if up else a_min
    end = (problem.end[0], velocity, acceleration)
    problem = replace(problem, start=(problem.start[0], 0.0, 0.0), end=end)
    error = refused(problem)
    expected = (2.0 * rise * room) ** 0.5 if up else -((-2.0 * fall * room) ** 0.5)
    assert error.bound == "velocity"
    assert error.nearest == pytest.approx(expected, rel=1e-9), problem
    assert_nearest(problem, error, 2)


def test_the_message_tells_what_and_why():
    told = (
        "end acceleration = 2.0 at velocity -1.9 cannot be reached within the velocity bound -2: "
        "building it up takes a velocity of -2.15 before; the nearest acceleration that can be "
        "reached at that velocity is 1.26491"
    )
    with pytest.raises(InfeasibleError, match=re.escape(told)):
        min_time_transfer(0.0, (1.0, -1.9, 2.0), LIMITS)
    told = "end velocity = 1.5 is outside its bounds (-2, 1): the nearest that can be reached is 1"
    with pytest.raises(InfeasibleError, match=re.escape(told)):
        min_time_transfer(0.0, (1.0, 1.5), LIMITS)


def test_at_its_bound_velocity_is_reached_only_without_acceleration_away_from_it():
    """No acceleration upwards at the lowest velocity: it came from below."""
    with pytest.raises(InfeasibleError) as caught:
        min_time_transfer(0.0, (0.0, -2.0, 0.5), LIMITS)
    assert (caught.value.bound, caught.value.nearest) == ("velocity", 0.0)
    assert min_time_transfer(0.0, (0.0, -2.0, -0.5), LIMITS).duration > 0.0


@pytest.mark.parametrize("velocity", [-1.7, 0.0, 1.0])
@pytest.mark.parametrize("bound", [None, (-inf, 1.0)])
def test_without_a_bound_below_every_rise_can_be_built_up(velocity, bound):
    limits = Limits(velocity=bound, acceleration=(-3.0, 2.0), jerk=(-4.0, 8.0))
    transfer = min_time_transfer(0.0, (1.0, velocity, 2.0), limits)
    assert transfer.end_state.tolist() == [1.0, velocity, 2.0, 0.0]


def test_rounding_of_a_bound_is_reached():
    for value in (1.0 + 2e-16, 1.0):
        transfer = min_time_transfer(0.0, (1.0, value), LIMITS)
        assert transfer.violation(LIMITS) == 0.0
        assert transfer.end_state[1] == 1.0


def test_it_is_a_value_error_that_survives_pickling():
    error = InfeasibleError("too fast", "velocity", 0.25)
    again = pickle.loads(pickle.dumps(error))
    assert isinstance(again, ValueError)
    assert type(again) is InfeasibleError
    assert (str(again), again.bound, again.nearest) == ("too fast", "velocity", 0.25)


@pytest.mark.parametrize("unit", [(-600, 0), (600, 0), (0, 140), (0, -140), (-400, 80)])
@pytest.mark.parametrize(
    ("end", "derivative"),
    [((3.0, -0.9, 1.5), 2), ((3.0, -0.9, 2.5), 2), ((3.0, 1.5, -0.5), 1), ((3.0, -9.0, 0.2), 1)],
)
def test_the_nearest_is_the_same_in_any_units(end, derivative, unit):
    def error(distance, time):
        units = [2.0 ** (distance - k * time) for k in range(4)]
        bounds = [bound * of for bound, of in zip((1.0, 2.0, 8.0), units[1:], strict=True)]
        given = tuple(x * of for x, of in zip(end, units[:3], strict=True))
        with pytest.raises(InfeasibleError) as caught:
            min_time_transfer(0.0, given, Limits(*bounds))
        return caught.value

    here, there = error(0, 0), error(*unit)
    assert there.bound == here.bound
    expected = here.nearest * 2.0 ** (unit[0] - derivative * unit[1])
    assert there.nearest == pytest.approx(expected, rel=1e-14)


def test_of_an_acceleration_that_no_velocity_allows_the_nearest_velocity_is_a_bound():
    limits = Limits(velocity=(-0.2, 2.0), acceleration=4.0, jerk=(-0.6, 1.2))
    with pytest.raises(InfeasibleError) as caught:
        min_time_transfer(0.0, (0.0, -1.2, -2.8), limits)
    assert (caught.value.bound, caught.value.nearest) == ("velocity", -0.2)


def test_a_later_reason_is_worked_out_once_and_only_where_it_is_asked_for():
    asked = []

    def work_out():
        asked.append("")
        return Reason("too fast", 0.25, -1.5, (0.0, 0.25))

    error = InfeasibleError(LaterReason(work_out), "velocity").headed("axis 2: ")
    assert (error.bound, asked) == ("velocity", [])
    again = pickle.loads(pickle.dumps(error))
    for one in (error, again):
        assert f"{one} {one!r}" == "axis 2: too fast InfeasibleError('axis 2: too fast')"
        assert (one.nearest, one.time, one.state) == (0.25, -1.5, (0.0, 0.25))
    assert asked == [""]
    assert "InfeasibleError: axis 2: too fast" in "".join(traceback.format_exception(error))
