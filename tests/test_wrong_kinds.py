"""What is no trajectory, no limits, no filter, no derivative and no choice: refused in one line."""

import datetime
import re

import numpy as np
import pandas as pd
import pytest

from jounce.analysis import (
    cascaded_lags,
    conformance,
    corner_omega,
    describing_function,
    fft_frequency_response,
    first_order_lag,
    frequency_response,
    null_by_size,
    null_omegas,
    place_null,
    residual_vibration,
    rollover_db_per_decade,
    servo_margins,
    vibration_map,
)
from jounce.plant import (
    PID,
    FlexibleInertia,
    Inertia,
    ServoLoop,
    filter_system,
    respond,
    zero_order_hold,
)
from jounce.plots import plot_trajectory
from jounce.shaping import (
    JerkFilter,
    Limits,
    binding_limits,
    certify,
    min_time_move,
    synchronize,
    through,
)
from jounce.shaping.recursive_s_curve import recursive_s_curve

LIMITS = Limits(velocity=1.0, acceleration=2.0, jerk=20.0)
MOVE = min_time_move(3.0, LIMITS)
LAST = min_time_move(-100.0, LIMITS)
FILTER = JerkFilter(2.0, 3)
LOOP = ServoLoop(Inertia(1.0), PID(1.0, 1.0, 2.0))
LAG = Inertia(1.0).system()
TABLE = pd.DataFrame({0.5: [1.0, 2.0], 1.5: [3.0, 4.0]})

NOUNS = {
    "violation": MOVE.violation,
    "then": MOVE.then,
    "then after a dwell": lambda x: MOVE.then(x, dwell=1.0),
    "plot_trajectory limits": lambda x: plot_trajectory(MOVE, limits=x),
    "steady_state": FILTER.steady_state,
    "filter respond": lambda x: FILTER.respond(x, 0.1),
    "min_time_move": lambda x: min_time_move(1.0, x),
    "recursive_s_curve": lambda x: recursive_s_curve(1.0, x),
    "synchronize": lambda x: synchronize([MOVE, x]),
    "through limits": lambda x: through([0.0, 1.0], x),
    "certify": lambda x: certify(x, LIMITS),
    "certify limits": lambda x: certify(MOVE, x),
    "binding_limits": lambda x: binding_limits(x, LIMITS),
    "binding_limits limits": lambda x: binding_limits(MOVE, x),
    "plant": lambda x: ServoLoop(x, PID(1.0, 1.0, 2.0)),
    "controller": lambda x: ServoLoop(Inertia(1.0), x),
    "loop respond": lambda x: LOOP.respond(x, 0.1),
    "loop respond behind a filter": lambda x: LOOP.respond(x, 0.1, jerk_filter=FILTER),
    "loop filter": lambda x: LOOP.respond(MOVE, 0.1, jerk_filter=x),
    "respond": lambda x: respond(LAG, x, 0.1),
    "respond system": lambda x: respond(x, MOVE, 0.1),
    "zero_order_hold": lambda x: zero_order_hold(x, 0.1),
    "filter_system": filter_system,
    "frequency_response": lambda x: frequency_response(x, 1.0),
    "frequency_response filter": lambda x: frequency_response(MOVE, 1.0, jerk_filter=x),
    "fft_frequency_response": lambda x: fft_frequency_response(x, 0.1),
    "corner_omega": corner_omega,
    "corner_omega filter": lambda x: corner_omega(MOVE, jerk_filter=x),
    "rollover": rollover_db_per_decade,
    "rollover filter": lambda x: rollover_db_per_decade(MOVE, jerk_filter=x),
    "cascaded_lags": lambda x: cascaded_lags(x, 1.0),
    "null_omegas": lambda x: null_omegas(x, 1.0),
    "null_by_size": lambda x: null_by_size(x, [1.0], 1.0),
    "place_null": lambda x: place_null(1.0, x, 4.0),
    "residual_vibration": lambda x: residual_vibration(x, 1.0),
    "residual_vibration filter": lambda x: residual_vibration(MOVE, 1.0, jerk_filter=x),
    "vibration_map": lambda x: vibration_map(x, [1.0], [1.0]),
    "describing_function": lambda x: describing_function(x, 1.0, 1.0),
    "first_order_lag": first_order_lag,
    "servo_margins": lambda x: servo_margins(1.0, x),
    "conformance": lambda x: conformance([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], x),
}
STRANGERS = {
    "table": TABLE,
    "Series": pd.Series([1.0, 2.0]),
    "array": np.eye(3),
    "text": "MOVE",
    "number": 1.0,
    "delta": datetime.timedelta(seconds=1),
    "loop": LOOP,
}


def refused(call, stranger, *errors):
    with pytest.raises(errors) as info:
        call(stranger)
    told = str(info.value)
    assert "expected" in told
    assert "\n" not in told
    assert "ambiguous" not in told


@pytest.mark.parametrize("call", NOUNS.values(), ids=NOUNS)
def test_another_kind_of_thing_is_refused_where_a_noun_is_expected(call):
    for stranger in STRANGERS.values():
        refused(call, stranger, TypeError)


DERIVATIVES = {
    "call": lambda x: MOVE(0.5, x),
    "evaluate": lambda x: MOVE.evaluate(0.5, x),
    "peak": MOVE.peak,
    "derivative": MOVE.derivative,
    "bounds": LIMITS.bounds,
    "steady_state": lambda x: FILTER.steady_state(MOVE, x),
    "respond": lambda x: respond(LAG, MOVE, 0.1, derivatives=[x]),
    "place_null": lambda x: place_null(1.0, LIMITS, 4.0, by=x),
}


@pytest.mark.parametrize(
    "wrong",
    [True, 1.0, np.nan, "speed", -1, np.ma.masked, TABLE, 1j, datetime.timedelta(1)],
    ids=str,
)
@pytest.mark.parametrize("call", DERIVATIVES.values(), ids=DERIVATIVES)
def test_a_derivative_is_a_name_or_a_whole_number(call, wrong):
    refused(call, wrong, TypeError, ValueError)


@pytest.mark.parametrize("call", DERIVATIVES.values(), ids=DERIVATIVES)
def test_a_derivative_may_be_any_kind_of_whole_number(call):
    said = [
        re.sub(r"0x[0-9a-f]+", "", repr(call(same)))  # an object of no repr of its own
        for same in (1, np.int8(1), np.array(1), "velocity")
    ]
    assert said == [said[0]] * 4


def test_derivatives_beyond_what_is_there():
    assert FILTER.steady_state(MOVE, 10**400).tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="by = 1000: expected velocity or a higher derivative, up"):
        place_null(1.0, LIMITS, 4.0, by=1000)
    with pytest.raises(ValueError, match="k = 4: expected a whole number from 0 to 3"):
        FILTER.derivative_weights(4)


CHOICES = {
    "method": lambda x: min_time_move(1.0, LIMITS, method=x),
    "mode": lambda x: synchronize([MOVE], x),
    "rate": lambda x: PID(1.0, 1.0, 1.0).sampled(0.1, rate=x),
    "sensor": lambda x: FlexibleInertia(1.0, 1.0, 0.1, sensor=x),
    "match": lambda x: cascaded_lags(MOVE, [1.0], match=x),
}


@pytest.mark.parametrize(
    "wrong", [None, 0, True, "Optimal", ["start"], *STRANGERS.values()], ids=str
)
@pytest.mark.parametrize("call", CHOICES.values(), ids=CHOICES)
def test_a_choice_is_one_of_the_words(call, wrong):
    refused(call, wrong, ValueError)


@pytest.mark.parametrize(
    "wrong",
    [
        TABLE,
        {1.5: None, 2.5: None},
        {1.5, 2.5},
        b"12",
        memoryview(b"12"),
        "12",
        np.ma.array([1.0, 2.0], mask=[False, True]),
        pd.Series([1.0, 2.0], dtype="category"),
        pd.Series(pd.to_timedelta([1, 2], unit="s")),
        None,
    ],
    ids=[
        "table",
        "mapping",
        "set",
        "bytes",
        "memory",
        "text",
        "masked",
        "category",
        "times",
        "none",
    ],
)
def test_bounds_are_not_taken_from_labels_bytes_or_what_is_masked(wrong):
    with pytest.raises(TypeError, match=r"^bounds = [^\n]*: expected [^\n]*$"):
        Limits.from_bounds(wrong)


def test_bounds_of_every_list_mean_the_same():
    bounds = [1.0, 2.5]
    same = (tuple(bounds), iter(bounds), (x for x in bounds), np.array(bounds), pd.Series(bounds))
    assert {Limits.from_bounds(each) for each in (bounds, *same)} == {Limits(1.0, 2.5)}
    pairs = [[-1.0, 2.0], [-3.0, 4.0]]
    assert Limits.from_bounds(np.array(pairs)) == Limits.from_bounds(pairs)


@pytest.mark.parametrize("motion", [MOVE, MOVE.reverse().shift(2.0), LAST], ids=str)
def test_factors_beyond_the_range_of_a_double_are_refused_without_a_warning(motion):
    for call, factor in (
        (motion.scale, 1.7e308),
        (motion.stretch, 1e-300),
        (motion.stretch, 5e-324),
    ):
        with pytest.raises(
            ValueError, match=r"^[^\n]*(range of a double|must be finite|take time)"
        ):
            call(factor)
