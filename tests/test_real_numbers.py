"""What is not plainly real numbers is refused by every public function, in the same line."""

import datetime
import re
from dataclasses import fields, is_dataclass
from decimal import Decimal
from fractions import Fraction

import control
import numpy as np
import pandas as pd
import pint
import pytest
from tiers import some

from jounce.analysis import (
    cascaded_lags,
    conformance,
    describing_function,
    fft_frequency_response,
    first_order_lag,
    frequency_response,
    loop_margins,
    many_loop_margins,
    null_by_size,
    null_omegas,
    periodic_response,
    place_null,
    residual_vibration,
    servo_margins,
    vibration_map,
)
from jounce.plant import (
    PID,
    FlexibleInertia,
    Inertia,
    InertiaFeedforward,
    ServoLoop,
    design_pid,
    respond,
    zero_order_hold,
)
from jounce.plant.pid import printed_pid
from jounce.shaping import (
    CommandFollower,
    JerkFilter,
    Limits,
    Trajectory,
    binding_limits,
    bound_for_rise_time,
    certify,
    min_jerk_move,
    min_time_move,
    min_time_moves,
    min_time_transfer,
    min_time_transfers,
    perfect_spline,
    s_curve_move,
    synchronize,
    through,
    velocity_move,
    velocity_transfer,
)
from jounce.shaping.real_numbers import rounded_down, shown
from jounce.shaping.recursive_s_curve import recursive_s_curve

LIMITS = Limits(velocity=1.0, acceleration=2.0, jerk=20.0)
MOVE = min_time_move(3.0, LIMITS)
BATCH = min_time_moves([1.0, 2.0], LIMITS)
FILTER = JerkFilter(2.0, 3)
FOLLOWER = CommandFollower(LIMITS, dt=0.1)
CURVE = s_curve_move(1.0, velocity=1.0, acceleration=2.0, acceleration_jerk=20.0)
LOOP = ServoLoop(Inertia(1.0), PID(1.0, 1.0, 2.0))
LAG = control.tf([1.0], [1.0, 1.0])
LIMITER = Limits(velocity=1.0)
READINGS = MOVE.sample(0.1)
DESIGN = {"crossover_hz": 1.0, "phase_margin_deg": 45.0, "lower_gain_margin_db": 12.0}
AXES = synchronize([(0.0, 1.0, LIMITS), (2.0, 3.0, LIMITS)])
SPIN = velocity_move(1.0, acceleration=2.0, acceleration_jerk=20.0)
CURVE_RATES = {"velocity": 1.0, "acceleration": 2.0, "acceleration_jerk": 20.0}


# name -> call, and a good value
NUMBERS = {
    "min_time_move distance": (lambda x: min_time_move(x, LIMITS), 1.5),
    "min_time_move start": (lambda x: min_time_move(1.0, LIMITS, start=x), 1.5),
    "recursive_s_curve distance": (lambda x: recursive_s_curve(x, LIMITS), 1.5),
    "perfect_spline distance": (lambda x: perfect_spline(x, 4, 1.0), 1.5),
    "perfect_spline bound": (lambda x: perfect_spline(1.0, 4, x), 1.5),
    "bound_for_rise_time acceleration": (lambda x: bound_for_rise_time(x, 1.0, 4), 1.5),
    "bound_for_rise_time rise_time": (lambda x: bound_for_rise_time(1.0, x, 4), 1.5),
    "min_jerk_move distance": (lambda x: min_jerk_move(x, duration=1.0), 1.5),
    "min_jerk_move duration": (lambda x: min_jerk_move(1.0, duration=x), 1.5),
    "min_jerk_move start": (lambda x: min_jerk_move(1.0, duration=1.0, start=x), 1.5),
    "Limits velocity": (lambda x: Limits(velocity=x), 1.5),
    "Limits side": (lambda x: Limits(velocity=(-1.0, x)), 1.5),
    "Limits.from_bounds": (lambda x: Limits.from_bounds([1.0, x]), 1.5),
    "shift": (MOVE.shift, 1.5),
    "delay": (MOVE.delay, 1.5),
    "scale": (MOVE.scale, 1.5),
    "stretch": (MOVE.stretch, 1.5),
    "until": (MOVE.until, 1.5),
    "then dwell": (lambda x: MOVE.then(MOVE, dwell=x), 1.5),
    "sample": (MOVE.sample, 0.5),
    "batch sample": (BATCH.sample, 0.5),
    "certify rtol": (lambda x: certify(MOVE, LIMITS, rtol=x), 0.5),
    "binding_limits rtol": (lambda x: binding_limits(MOVE, LIMITS, rtol=x), 0.5),
    "JerkFilter corner_hz": (lambda x: JerkFilter(x, 3), 1.5),
    "settling_time": (FILTER.settling_time, 0.5),
    "filter dt": (lambda x: FILTER.respond(MOVE, x), 0.5),
    "filter duration": (lambda x: FILTER.respond(MOVE, 0.1, duration=x), 0.5),
    "CommandFollower dt": (lambda x: CommandFollower(LIMITS, dt=x), 0.5),
    "CommandFollower period": (lambda x: CommandFollower(LIMITS, dt=0.1, period=x), 1.5),
    "step command": (lambda x: FOLLOWER.step((0.0,), x), 1.5),
    "step velocity": (lambda x: FOLLOWER.step((0.0,), 1.0, x), 1.5),
    "step state element": (lambda x: FOLLOWER.step((x, 0.0), 1.0), 1.5),
    "rest": (FOLLOWER.rest, 1.5),
    "transfer start element": (lambda x: min_time_transfer((x, 0.0), 2.0, LIMITS), 1.5),
    "transfer unused element": (lambda x: min_time_transfer((0.0, 0.0, 0.0, x), 2.0, LIMITS), 1.5),
    "velocity_transfer velocity": (lambda x: velocity_transfer(0.0, x, LIMITS), 0.5),
    "velocity_transfer acceleration": (
        lambda x: velocity_transfer(0.0, 0.5, LIMITS, acceleration=x),
        0.5,
    ),
    "s_curve_move target": (lambda x: s_curve_move(x, **CURVE_RATES), 1.5),
    **{
        f"s_curve_move {name}": (
            lambda x, name=name: s_curve_move(1.0, **{**CURVE_RATES, name: x}),
            0.5,
        )
        for name in [*CURVE_RATES, "deceleration", "deceleration_jerk", "final_velocity", "dt"]
    },
    "s_curve_move jerk_percent": (
        lambda x: s_curve_move(1.0, velocity=1.0, acceleration=1.0, jerk_percent=x),
        0.5,
    ),
    "s_curve_move delay": (lambda x: s_curve_move(1.0, delay=x, **CURVE_RATES), 0.5),
    "modify time": (lambda x: CURVE.modify(x, target=2.0), 0.5),
    "modify target": (lambda x: CURVE.modify(0.5, target=x), 0.5),
    "modify velocity": (lambda x: CURVE.modify(0.5, velocity=x), 0.5),
    **{
        f"velocity_move {name}": (
            lambda x, name=name: velocity_move(
                **{"velocity": 1.0, "acceleration": 2.0, "acceleration_jerk": 20.0, name: x}
            ),
            0.5,
        )
        for name in ("velocity", "acceleration", "deceleration", "acceleration_jerk", "delay", "dt")
    },
    "velocity modify time": (lambda x: SPIN.modify(x, velocity=2.0), 0.5),
    "velocity modify": (lambda x: SPIN.modify(0.1, velocity=x), 0.5),
    "velocity append": (SPIN.append, 0.5),
    "synchronized modify time": (lambda x: AXES.modify(x, [2.0, 3.0]), 0.5),
    "synchronized modify target": (lambda x: AXES.modify(0.5, [(x, 0.0), None]), 1.5),
    "append target": (CURVE.append, 0.5),
    "append delay": (lambda x: CURVE.append(2.0, delay=x), 0.5),
    "through points": (lambda x: through([0.0, x, 0.2], LIMITS), 0.5),
    "through corner": (lambda x: through([0.0, 1.0, 0.2], LIMITS, corner=x), 0.125),
    "through scan": (lambda x: through([0.0, 1.0], LIMITS, scan={0: x}), 0.5),
    "synchronize start": (lambda x: synchronize([(x, 1.0, LIMITS)]), 0.5),
    "Inertia": (Inertia, 1.5),
    "FlexibleInertia J": (lambda x: FlexibleInertia(x, 1.0, 0.1), 1.5),
    "FlexibleInertia frequency": (lambda x: FlexibleInertia(1.0, x, 0.1), 1.5),
    "FlexibleInertia damping": (lambda x: FlexibleInertia(1.0, 1.0, x), 0.5),
    "FlexibleInertia load": (lambda x: FlexibleInertia(1.0, 1.0, 0.1, load_fraction=x), 0.5),
    "InertiaFeedforward": (InertiaFeedforward, 1.5),
    "PID kp": (lambda x: PID(x, 1.0, 1.0), 1.5),
    "PID ki": (lambda x: PID(1.0, x, 1.0), 1.5),
    "PID kr": (lambda x: PID(1.0, 1.0, x), 1.5),
    "PID.sampled": (PID(1.0, 1.0, 1.0).sampled, 0.5),
    "printed_pid": (printed_pid, 1.5),
    "design_pid inertia": (lambda x: design_pid(x, **DESIGN), 1.5),
    "design_pid crossover": (lambda x: design_pid(1.0, **{**DESIGN, "crossover_hz": x}), 1.5),
    "design_pid phase": (lambda x: design_pid(1.0, **{**DESIGN, "phase_margin_deg": x}), 42.5),
    "design_pid gain": (lambda x: design_pid(1.0, **{**DESIGN, "lower_gain_margin_db": x}), 10.5),
    "respond dt": (lambda x: respond(LAG, MOVE, x), 0.5),
    "respond duration": (lambda x: respond(LAG, MOVE, 0.1, duration=x), 0.5),
    "loop dt": (lambda x: LOOP.respond(MOVE, x), 0.5),
    "loop duration": (lambda x: LOOP.respond(MOVE, 0.1, duration=x), 0.5),
    "loop settling target": (lambda x: LOOP.respond(MOVE, 0.1).settling_time(x, 0.1), 1.5),
    "loop settling tolerance": (lambda x: LOOP.respond(MOVE, 0.1).settling_time(3.0, x), 1.5),
    "sampled_loop_transfer dt": (LOOP.sampled_loop_transfer, 0.5),
    "sampled_loop_transfer delay": (lambda x: LOOP.sampled_loop_transfer(0.1, delay=x), 0.5),
    "zero_order_hold dt": (lambda x: zero_order_hold(LAG, x), 0.5),
    "zero_order_hold delay": (lambda x: zero_order_hold(LAG, 0.1, delay=x), 0.5),
    "loop_margins delay": (lambda x: loop_margins(LAG, delay=x), 0.5),
    "fft_frequency_response dt": (lambda x: fft_frequency_response(MOVE, x), 0.5),
    "null_omegas": (lambda x: null_omegas(MOVE, x), 1.5),
    "null_by_size": (lambda x: null_by_size(LIMITS, [1.0], x), 1.5),
    "place_null distance": (lambda x: place_null(x, LIMITS, 4.0), 5.5),
    "place_null frequency": (lambda x: place_null(5.5, LIMITS, x), 3.5),
    "place_null damping": (lambda x: place_null(5.5, LIMITS, 4.0, damping=x), 2.0**-6),
    "vibration_map damping": (lambda x: vibration_map(LIMITS, [1.0], [2.0], x), 0.5),
    "periodic_response amplitude": (lambda x: periodic_response(LIMITER, x, 1.0), 1.5),
    "periodic_response omega": (lambda x: periodic_response(LIMITER, 1.0, x), 1.5),
    "conformance tolerance": (lambda x: conformance(*_log(), LIMITS, tolerance=x), 0.5),
    "conformance resolution": (lambda x: conformance(*_log(), LIMITS, resolution=x), 2.0**-20),
}

# name -> call, and a good value as a list; a single number will do, too, unless told otherwise
ARRAYS = {
    "Trajectory breaks": (lambda x: Trajectory(x, [[0.0, 1.0, 2.0]]), [0.0, 1.5]),
    "Trajectory states": (lambda x: Trajectory([0.0, 1.0], x), [[0.0, 1.0, 2.5]]),
    "Trajectory durations": (lambda x: Trajectory([0.0, 1.0], [[0.0, 1.0, 2.0]], x), [1.0]),
    "Trajectory end_state": (
        lambda x: Trajectory([0.0, 1.0], [[0.0, 1.0, 2.0]], end_state=x),
        [0.0, 1.5, 0.0],
    ),
    "call": (MOVE, [0.5, 1.0]),
    "call beyond order": (lambda x: MOVE(x, 7), [0.5, 1.0]),
    "evaluate": (MOVE.evaluate, [0.5, 1.0]),
    "batch call": (BATCH, [0.5, 1.0]),
    "batch beyond order": (lambda x: BATCH(x, 7), [0.5, 1.0]),
    "batch evaluate": (BATCH.evaluate, [0.5, 1.0]),
    "Limits side of many": (lambda x: Limits(jerk=(-1.0, x)), [0.5, 1.5]),
    "Limits of many": (lambda x: Limits(jerk=x), [0.5, 1.0, 1.5]),
    "distances": (lambda x: min_time_moves(x, LIMITS), [0.5, 1.0]),
    "starts": (lambda x: min_time_moves([1.0, 2.0], LIMITS, start=x), [0.5, 1.0]),
    "transfers starts": (lambda x: min_time_transfers(x, [3.0], LIMITS), [[0.5, 0.0]]),
    "transfers ends": (lambda x: min_time_transfers([0.0], x, LIMITS), [[0.5, 0.0]]),
    "transfer start": (lambda x: min_time_transfer(x, 2.0, LIMITS), [0.5, 0.25]),
    "transfer end": (lambda x: min_time_transfer(0.0, x, LIMITS), [0.5, 0.25]),
    "velocity_transfer start": (lambda x: velocity_transfer(x, 0.5, LIMITS), [0.5, 0.25]),
    "s_curve_move start": (lambda x: s_curve_move(1.0, start=x, **CURVE_RATES), [0.5, 0.25]),
    "follower state": (lambda x: FOLLOWER.step(x, 1.0), [0.5, 0.25]),
    "follower output": (FOLLOWER.output, [0.5, 0.25]),
    "follower commands": (FOLLOWER.run, [0.5, 0.25]),
    "follower velocities": (
        lambda x: FOLLOWER.run([1.0, 1.0], command_velocities=x),
        [0.5, 0.25],
    ),
    "follower initial": (lambda x: FOLLOWER.run([1.0], initial=x), [0.5, 0.25]),
    "step_response": (FILTER.step_response, [0.5, 0.25]),
    "initial_state": (lambda x: respond(LAG, MOVE, 0.1, initial_state=x), [0.5]),
    "frequency_response": (lambda x: frequency_response(MOVE, x), [0.5, 0.25]),
    "filter frequency_response": (lambda x: frequency_response(FILTER, x), [0.5, 0.25]),
    "cascaded_lags": (lambda x: cascaded_lags(MOVE, x), [0.5, 0.25]),
    "residual_vibration": (lambda x: residual_vibration(MOVE, x), [0.5, 0.25]),
    "residual damping": (lambda x: residual_vibration(MOVE, 1.0, x), [0.5, 0.25]),
    "vibration_map distances": (lambda x: vibration_map(LIMITS, x, [1.0]), [0.5, 0.25]),
    "vibration_map frequencies": (lambda x: vibration_map(LIMITS, [1.0], x), [0.5, 0.25]),
    "null_by_size distances": (lambda x: null_by_size(LIMITS, x, 4.0), [5.5, 5.25]),
    "describing amplitude": (lambda x: describing_function(LIMITER, x, 1.0), [0.5, 0.25]),
    "describing omega": (lambda x: describing_function(LIMITER, 1.0, x), [0.5, 0.25]),
    "lag response": (
        lambda x: first_order_lag(describing_function(LIMITER, 2.0, [1.0, 2.0])).response(x),
        [0.5, 0.25],
    ),
    "denominator": (lambda x: many_loop_margins([1.0], x), [1.0, 1.5, 0.5]),
    "delays": (lambda x: many_loop_margins([1.0], [1.0, 1.0, 0.0], delay=x), [0.5, 0.25]),
    "servo inertia": (lambda x: servo_margins(x, PID(1.0, 1.0, 2.0)), [0.5, 0.25]),
    "servo gain": (lambda x: servo_margins(1.0, PID(1.0, 1.0, 2.0), gain=x), [0.5, 0.25]),
    "conformance times": (lambda x: conformance(x, READINGS[1][0], LIMITS), READINGS[0].tolist()),
    "conformance positions": (
        lambda x: conformance(READINGS[0], x, LIMITS, resolution=1e-6),
        READINGS[1][0].tolist(),
    ),
}


def _log():
    return READINGS[0], READINGS[1][0]


REGISTRY = pint.UnitRegistry()
SECOND = np.timedelta64(1, "s")
NO_NUMBERS = {
    "text": "1.5",
    "bytes": b"1.5",
    "bytearray": bytearray(b"15"),
    "complex": 1.5 + 0j,
    "numpy complex": np.complex128(1.5),
    "truth": True,
    "numpy truth": np.True_,
    "timedelta": datetime.timedelta(seconds=1.5),
    "date": datetime.datetime(2026, 1, 1),
    "timedelta64": SECOND,
    "datetime64": np.datetime64("2026-01-01"),
    "pandas timedelta": pd.Timedelta(seconds=1),
    "pandas NA": pd.NA,
    "masked": np.ma.masked,
    "no dimension, masked": np.ma.array(1.5, mask=True),
    "mapping": {0: 1.5, 1: 2.5},
    "set": {-1.5, 2.5},
    "object": object(),
    "quantity": REGISTRY.Quantity(1.5, "mm"),
    "array of text": np.array("1.5"),
}
NO_ARRAYS = {
    **NO_NUMBERS,
    "table": pd.DataFrame({-1.5: [0.5, 1.0], 2.5: [0.5, 1.0]}),
    "small table": pd.DataFrame([[0.5, 1.0]]),
    "texts": ["0.5", "1.0"],
    "complexes": [0.5, 1j],
    "truths": [0.5, True],
    "gap": [0.5, None],
    "ragged": [[0.5], [0.5, 1.0]],
    "masked array": np.ma.array([0.5, 1.0], mask=[False, True]),
    "masked inside": [[0.5, np.ma.masked]],
    "timedeltas": [SECOND, SECOND],
    "array of timedeltas": np.array([SECOND, 2 * SECOND]),
    "Series of timedeltas": pd.Series(pd.to_timedelta([1, 2], unit="s")),
    "Series of categories": pd.Series([0.5, 1.0], dtype="category"),
    "categories": pd.Categorical([0.5, 1.0]),
    "Series of texts": pd.Series(["0.5", "1.0"]),
    "Series of dates": pd.Series(pd.to_datetime(["2026-01-01", "2026-01-02"])),
    "quantities": REGISTRY.Quantity([0.5, 1.0], "mm"),
    "list of quantities": [REGISTRY.Quantity(0.5, "mm")] * 2,
    "array of truths": np.array([True, False]),
    "generator": (x for x in [0.5, 1.0]),
    "records": np.array([(0.5, 1.0)], dtype=[("x", float), ("v", float)]),
}
EXPECTED = r"expected (a number|a positive number|positive numbers|Limits)"


def _answer(call, bad):
    """Return what a call says to bad input, None where it is one right line."""
    try:
        call(bad)
    except TypeError as error:
        told = str(error)
        return None if re.search(EXPECTED, told) and "\n" not in told else told
    except Exception as error:  # which is what this looks for
        return repr(error)
    return "accepted"


@pytest.mark.parametrize("bad", NO_ARRAYS.values(), ids=NO_ARRAYS)
def test_what_is_no_number_is_refused_wherever_one_is_expected(bad):
    answers = {name: _answer(call, bad) for name, (call, _) in NUMBERS.items()}
    assert not {name: told for name, told in answers.items() if told}


@pytest.mark.parametrize("bad", NO_ARRAYS.values(), ids=NO_ARRAYS)
def test_what_is_no_array_of_numbers_is_refused_wherever_one_is_expected(bad):
    answers = {name: _answer(call, bad) for name, (call, _) in ARRAYS.items()}
    assert not {name: told for name, told in answers.items() if told}


def _same(one, other):
    return repr(_plain(one)) == repr(_plain(other))


def _plain(result):
    """Return a result as numbers that can be compared."""
    if isinstance(result, np.ndarray):
        return result.tolist()
    if isinstance(result, tuple | list):
        return [_plain(part) for part in result]
    if isinstance(result, control.TimeResponseData):
        return _plain([result.time, result.outputs])
    if is_dataclass(result):
        return {field.name: _plain(getattr(result, field.name)) for field in fields(result)}
    if hasattr(result, "__dict__"):
        shown = {name: value for name, value in vars(result).items() if name[0] != "_"}
        return {name: _plain(value) for name, value in shown.items() if not callable(value)}
    return result


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_means_the_same_in_every_form(name):
    call, value = NUMBERS[name]
    result = call(value)
    forms = [
        np.float64(value),
        np.float32(value),
        np.longdouble(value),
        np.array(value),
        np.array(value, dtype=np.float32),
        np.array(value, dtype=object),
        np.ma.array(value),
        Fraction(value),
        Decimal(value),
    ]
    for form in some(forms, 4):
        if name != "conformance resolution" or np.float32(value) == value:
            assert _same(call(form), result), (name, form)


@pytest.mark.parametrize("name", ARRAYS)
def test_an_array_means_the_same_in_every_form(name):
    call, value = ARRAYS[name]
    array = np.array(value)
    forms = [array, array.tolist(), np.ma.array(array), array.astype(object)]
    if (array.astype(np.float32) == array).all():
        forms += [array.astype(np.float32), np.asfortranarray(array)]
    if array.ndim == 1:
        forms += [pd.Series(array, index=range(len(array), 0, -1)), pd.Index(array)]
        forms += [[Fraction(x) for x in value], [np.array(x) for x in value]]
    forms.append(tuple(value))
    if name.startswith("Limits"):  # where a list or a tuple is a pair
        value, forms = array, [form for form in forms if not isinstance(form, list | tuple)]
    result = call(value)
    for form in some(forms, 4):
        assert _same(call(form), result), (name, form)


def test_a_pair_means_the_same_in_every_form():
    for pair in ((-1.0, 1.5), [-1, Fraction(3, 2)], (np.float32(-1), np.array(1.5))):
        assert Limits(jerk=pair) == Limits(jerk=(-1.0, 1.5))


def test_the_line_names_the_type_and_the_remedy():
    frame = pd.DataFrame({"x": [0.0], "v": [1.0]})
    with pytest.raises(TypeError, match=r"^start = .*, not DataFrame; give the columns meant"):
        min_time_transfer(frame, 1.0, LIMITS)
    with pytest.raises(TypeError, match=r"^dt = .*, not timedelta; .* total_seconds\(\)$"):
        MOVE.sample(datetime.timedelta(seconds=1))
    with pytest.raises(TypeError, match=r"^distance = .*: expected a number, not Quantity; .*m_as"):
        min_time_move(REGISTRY.Quantity(1.0, "m"), LIMITS)
    with pytest.raises(TypeError, match=r"not ndarray of timedelta64\[s\]; divide it by"):
        MOVE(np.array([SECOND]))
    with pytest.raises(TypeError, match=r"; leave out or fill what is masked$"):
        MOVE(np.ma.array([0.0, 1.0], mask=[False, True]))


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (10 * 0.96, "9.6"),
        (9.600000000000001, "9.6"),
        (0.1 + 0.2, "0.3"),
        (-0.0, "0.0"),
        (np.float64(-0.25), "-0.25"),
        (1e-9, "1e-09"),
        (float("inf"), "inf"),
        ([0.1 + 0.2, 1], "[0.3, 1]"),
        ("nm", "'nm'"),
    ],
)
def test_messages_show_numbers_without_their_last_rounding_error(value, told):
    assert shown(value) == told


@pytest.mark.parametrize("value", [0.5 / 0.7, 0.5 / 600.0, 0.4 / 420.0, 1e-3, 5e8 / 3])
def test_a_bound_to_be_kept_is_rounded_down(value):
    told = float(rounded_down(value))
    assert 0.999 * value < told <= value
