"""The flexible inertia: the two equations of motion solved anew, poles and zeros, errors."""

from math import inf, nan, pi, sqrt

import control
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import MAGNITUDES, UNIT_FACTORS
from tiers import some

from jounce.plant import FlexibleInertia, Inertia

SENSORS = ["motor", "load"]
FRACTIONS = st.floats(0.01, 0.99)
DAMPINGS = st.sampled_from([0.0, 1e-4, 0.01, 0.3, 0.99])


def two_bodies(axis):
    """Return J_motor, J_load, k and c: in the spring's mode the two move about their centre."""
    motor, load = (1 - axis.load_fraction) * axis.J, axis.load_fraction * axis.J
    reduced = 1 / (1 / motor + 1 / load)
    omega = 2 * pi * axis.frequency_hz
    return motor, load, reduced * omega**2, 2 * axis.damping * omega * reduced


def positions(axis, s):
    """Return y_motor and y_load for a unit torque: the two equations of motion, in 50 digits."""
    with mpmath.workdps(50):
        motor, load, k, c = map(mpmath.mpf, two_bodies(axis))
        s = mpmath.mpc(s)
        link = c * s + k
        matrix = mpmath.matrix([[motor * s * s + link, -link], [-link, load * s * s + link]])
        return [complex(y) for y in mpmath.lu_solve(matrix, [1, 0])]


def outputs_at(system, s):
    """Return C(sI − A)⁻¹B in 50 digits: python-control's, without scaling, loses digits."""
    with mpmath.workdps(50):
        a, b, c = (mpmath.matrix(part.tolist()) for part in (system.A, system.B, system.C))
        states = mpmath.lu_solve(mpmath.mpc(s) * mpmath.eye(len(a)) - a, b)
        return np.array([complex(y) for y in c * states])


@given(
    moment=MAGNITUDES, unit=UNIT_FACTORS, frequency=MAGNITUDES, damping=DAMPINGS,
    fraction=FRACTIONS, sensor=st.sampled_from(SENSORS),
    ratio=MAGNITUDES.filter(lambda x: abs(x - 1) > 1e-3),
    turn=st.sampled_from([1j, 0.2 + 1j, 1.0]),
)  # fmt: skip
def test_both_forms_solve_the_equations_of_motion(
    moment, unit, frequency, damping, fraction, sensor, ratio, turn
):
    axis = FlexibleInertia(
        moment * unit, frequency / unit, damping, load_fraction=fraction, sensor=sensor
    )
    s = turn * ratio * 2 * pi * axis.frequency_hz
    motor, load = positions(axis, s)
    y = motor if sensor == "motor" else load
    size = abs(1 / (axis.J * s**2)) + abs(motor) + abs(load)
    slack = size / min(1.0, abs((s / 2 / pi / axis.frequency_hz) ** 2 + 1))  # near resonance
    text = f"{axis!r} at {s}"
    assert axis.transfer()(s) == pytest.approx(y, rel=0, abs=1e-13 * slack), text
    found, units = outputs_at(axis.system(), s), np.array([1.0, abs(s), 1.0, 1.0])
    expected = np.array([y, s * y, load, load - motor])
    np.testing.assert_allclose(
        found / units, expected / units, rtol=0, atol=1e-13 * slack, err_msg=text
    )


@given(frequency=MAGNITUDES, damping=DAMPINGS, fraction=FRACTIONS)
def test_resonance_and_antiresonance_are_poles_and_zeros(frequency, damping, fraction):
    axis = FlexibleInertia(3.0, frequency, damping, load_fraction=fraction)
    transfer, unit = axis.transfer(), 2 * pi * frequency
    poles = transfer.poles() / unit
    swinging = poles[abs(poles) > 0.5]
    assert np.sort(abs(poles))[:2] == pytest.approx([0.0, 0.0], abs=1e-7)
    expected = [-damping + turn * sqrt(1 - damping**2) for turn in (-1j, 1j)]
    assert_same(swinging, expected)
    share, ratio = axis.antiresonance_hz / frequency, axis.antiresonance_damping
    expected = [share * (-ratio + turn * sqrt(1 - ratio**2)) for turn in (-1j, 1j)]
    assert_same(transfer.zeros() / unit, expected)
    on_load = FlexibleInertia(3.0, frequency, damping, load_fraction=fraction, sensor="load")
    zeros = on_load.transfer().zeros() / unit
    assert_same(zeros, [-0.5 / damping] if damping else [])


def assert_same(found, expected):
    key = np.imag
    np.testing.assert_allclose(
        sorted(found, key=key), sorted(expected, key=key), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("fraction", some([0.1, 0.9, 0.5], 2))
def test_the_load_on_a_locked_motor_has_the_antiresonance(fraction, sensor):
    """λJ·ÿ + c·ẏ + k·y = 0 from y = 1: its decay and zero crossings, integrated."""
    axis = FlexibleInertia(0.7, 2.0, 0.05, load_fraction=fraction, sensor=sensor)
    _, load, k, c = two_bodies(axis)

    def rate(_, x):
        return x[1]

    rate.direction = -1.0  # its falling zeros are the maxima
    swing = solve_ivp(
        lambda _, x: [x[1], -(k * x[0] + c * x[1]) / load], (0.0, 10.0), [1.0, 0.0],
        events=rate, rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    maxima, peaks = swing.t_events[0][-5:], swing.y_events[0][-5:, 0]
    period, decay = (maxima[-1] - maxima[0]) / 4, np.log(peaks[0] / peaks[-1]) / 4
    damped = 1 / period
    ratio = decay / np.hypot(decay, 2 * pi)
    assert axis.antiresonance_damping == pytest.approx(ratio, rel=1e-7)
    assert axis.antiresonance_hz == pytest.approx(damped / sqrt(1 - ratio**2), rel=1e-7)


@pytest.mark.parametrize("sensor", SENSORS)
def test_far_below_its_resonance_it_is_an_inertia(sensor):
    axis = FlexibleInertia(2.5, 100.0, 0.01, load_fraction=0.3, sensor=sensor)
    s = 2j * pi * 0.01
    assert axis.transfer()(s) == pytest.approx(Inertia(2.5).transfer()(s), rel=1e-7)


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_torque_accelerates_the_centre_of_mass(sensor):
    axis = FlexibleInertia(0.5, 3.0, 0.02, load_fraction=0.3, sensor=sensor)
    t = np.linspace(0.0, 4.0, 401)
    y, _, load, twist = control.forced_response(axis.system(), t, np.full(401, 3.0)).outputs
    motor = load - twist
    np.testing.assert_allclose(0.7 * motor + 0.3 * load, 3.0 * t**2, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(y, motor if sensor == "motor" else load, rtol=0, atol=1e-12)
    assert twist.min() < -1e-3


@pytest.mark.parametrize("sensor", SENSORS)
def test_an_offset_of_position_is_an_offset_of_the_first_state_alone(sensor):
    system = FlexibleInertia(2.0, 5.0, 0.1, load_fraction=0.8, sensor=sensor).system()
    np.testing.assert_array_equal(system.A @ [1.0, 0.0, 0.0, 0.0], np.zeros(4))
    np.testing.assert_array_equal(system.C @ [1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0])


def test_signals_have_the_loops_names():
    axis = FlexibleInertia(3.0, 1.0, 0.0)
    system, transfer = axis.system(), axis.transfer()
    assert (system.name, transfer.name) == ("plant", "plant")
    assert system.input_labels == transfer.input_labels == ["u"]
    assert system.output_labels == ["y", "y_rate", "y_load", "twist"]
    assert system.state_labels == ["y", "y_rate", "twist", "twist_rate"]
    assert transfer.output_labels == ["y"]
    assert system.isctime(strict=True)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("J", 0.0, "J = 0.0: expected a positive"),
        ("J", nan, "J = nan: expected a positive"),
        ("frequency_hz", -1.0, "frequency_hz = -1.0: expected a positive"),
        ("frequency_hz", inf, "frequency_hz = inf: expected a positive"),
        ("damping", -0.01, r"damping = -0.01: expected a damping ratio from 0 to below 1"),
        ("damping", 1.0, r"damping = 1.0: expected a damping ratio from 0 to below 1 \(1 % is"),
        ("damping", nan, "damping = nan: expected a finite"),
        ("load_fraction", 0.0, r"load_fraction = 0.0: .*between 0 and 1 .*use Inertia"),
        ("load_fraction", 1.0, "load_fraction = 1.0: .*between 0 and 1"),
        ("load_fraction", inf, "load_fraction = inf: expected a finite"),
        ("sensor", "shaft", "sensor = 'shaft': expected 'motor' or 'load'"),
        ("sensor", None, "sensor = None: expected 'motor' or 'load'"),
        ("J", 5e-324, "beyond the range of a double: choose other units"),
        ("J", 1e-320, "beyond the range of a double: choose other units"),
        ("frequency_hz", 1e200, "beyond the range of a double: choose other units"),
        ("frequency_hz", 1e-200, "beyond the range of a double: choose other units"),
    ],
)
def test_a_parameter_outside_its_range_is_refused(name, value, message):
    good = {"J": 1.0, "frequency_hz": 2.0, "damping": 0.1, "load_fraction": 0.5}
    with pytest.raises(ValueError, match=message):
        FlexibleInertia(**(good | {name: value}))


@pytest.mark.parametrize("name", ["J", "frequency_hz", "damping", "load_fraction"])
def test_a_parameter_that_is_no_number_is_refused(name):
    good = {"J": 1.0, "frequency_hz": 2.0, "damping": 0.1, "load_fraction": 0.5}
    with pytest.raises(TypeError, match=f"{name} = '1': expected a number"):
        FlexibleInertia(**(good | {name: "1"}))


def test_it_is_frozen_floats():
    axis = FlexibleInertia(np.int64(2), 1, 0)
    assert [type(x) for x in (axis.J, axis.frequency_hz, axis.damping)] == [float] * 3
    assert axis == FlexibleInertia(2.0, 1.0, 0.0, load_fraction=0.5, sensor="motor")
    with pytest.raises(AttributeError):
        axis.J = 3.0
    with pytest.raises(TypeError):
        FlexibleInertia(2.0, 1.0, 0.0, 0.5)
