"""The axis: closed forms at random frequencies, equal descriptions, refusals."""

from math import inf, nan, pi, sqrt

import control
import numpy as np
import pytest

from jounce.plant import (
    Axis,
    FlexibleInertia,
    FlexibleMode,
    Friction,
    Inertia,
    as_axis,
    chain_axis,
    system_axis,
)

POINTS = [0.7j, 3.0 + 2.0j, 40.0j, 1.0 + 300.0j]


def impedance_of_three_modes(s, modes, J, viscous):
    """Return motor and load per torque of free-free modes with friction on the motor."""
    a = np.array([1.0] + [mode.motor_shape for mode in modes])
    b = np.array([1.0] + [mode.load_shape for mode in modes])
    w = 2 * pi * np.array([0.0] + [mode.frequency_hz for mode in modes])
    z = np.array([0.0] + [mode.damping for mode in modes])
    matrix = J * np.diag(s * s + 2 * z * w * s + w**2) + viscous * s * np.outer(a, a)
    q = np.linalg.solve(matrix, a.astype(complex))
    return a @ q, b @ q


@pytest.mark.parametrize("s", POINTS)
def test_free_modes_are_the_modal_sum(s):
    modes = [
        FlexibleMode(18.0, 0.01, motor_shape=0.9, load_shape=-0.8),
        FlexibleMode(31.0, 0.015, motor_shape=0.6, load_shape=0.35),
        FlexibleMode(57.0, 0.02, motor_shape=0.4, load_shape=-0.2),
    ]
    motor, load = impedance_of_three_modes(s, modes, 12.0, 2.0)
    for sensor, expected in (("motor", motor), ("load", load)):
        axis = Axis(12.0, modes=modes, viscous=2.0, sensor=sensor, current_lag=1e-3)
        lagged = expected / (1 + 1e-3 * s)
        assert axis.system()(s)[0, 0] == pytest.approx(lagged, rel=1e-12)
        assert axis.system()(s)[1, 0] == pytest.approx(s * lagged, rel=1e-12)
        assert axis.transfer()(s) == pytest.approx(lagged, rel=1e-10)
    assert axis.system()(s)[2, 0] == pytest.approx(load / (1 + 1e-3 * s))
    assert axis.system()(s)[5, 0] == pytest.approx(motor / (1 + 1e-3 * s))


@pytest.mark.parametrize("s", POINTS)
@pytest.mark.parametrize("sensor", ["motor", "load"])
def test_one_mode_is_the_flexible_inertia_free_or_held(s, sensor):
    short = FlexibleInertia(2.0, 10.0, 0.02, load_fraction=0.3, sensor=sensor)
    mode = FlexibleMode(
        short.antiresonance_hz, short.antiresonance_damping, load_fraction=0.3, held=True
    )
    held = Axis(2.0, modes=mode, sensor=sensor)
    for axis in (as_axis(short), held):
        assert axis.system()(s)[0, 0] == pytest.approx(short.transfer()(s), rel=1e-12)
        assert axis.transfer()(s) == pytest.approx(short.transfer()(s), rel=1e-12)


@pytest.mark.parametrize("s", POINTS)
def test_a_chain_is_its_impedance_matrix(s):
    m, k, c = [1.0, 2.0, 0.5], [800.0, 3000.0], [0.3, 0.1]
    stiff = np.array([[k[0], -k[0], 0], [-k[0], sum(k), -k[1]], [0, -k[1], k[1]]])
    damp = np.array([[c[0], -c[0], 0], [-c[0], sum(c), -c[1]], [0, -c[1], c[1]]])
    matrix = np.diag(m) * s * s + damp * s + stiff
    matrix[0, 0] += 0.2 * s + 5.0
    matrix[2, 2] += 0.4 * s
    y = np.linalg.solve(matrix, [1.0, 0.0, 0.0])
    pushed = np.linalg.solve(matrix, [0.0, 0.0, 1.0])
    axis = chain_axis(m, k, c, viscous=0.2, load_viscous=0.4, spring=5.0, sensor="load")
    response = axis.system()(s)
    assert response[5, 0] == pytest.approx(y[0], rel=1e-11)
    assert response[2, 0] == pytest.approx(y[2], rel=1e-11)
    assert response[2, 2] == pytest.approx(pushed[2], rel=1e-11)
    assert axis.transfer()(s) == pytest.approx(y[2], rel=1e-9)


@pytest.mark.parametrize("s", POINTS)
def test_two_held_modes_swing_on_the_motor(s):
    modes = [
        FlexibleMode(6.0, 0.01, load_fraction=0.3, held=True),
        FlexibleMode(11.0, 0.02, load_fraction=0.2, held=True),
    ]
    mass, load = 0.5 * s * s, None
    for mode in modes:
        w, z = 2 * pi * mode.frequency_hz, mode.damping
        share = (w * w + 2 * z * w * s) / (s * s + 2 * z * w * s + w * w)
        mass += mode.load_fraction * s * s * share
        load = share if load is None else load
    axis = Axis(4.0, modes=modes)
    assert axis.system()(s)[0, 0] == pytest.approx(1 / (4.0 * mass), rel=1e-11)
    assert axis.system()(s)[2, 0] == pytest.approx(load / (4.0 * mass), rel=1e-11)


def test_any_system_is_an_axis():
    flexible = FlexibleInertia(2.0, 10.0, 0.02, load_fraction=0.3)
    for system in (flexible.transfer(), control.ss(flexible.transfer())):
        axis = system_axis(system, friction=Friction(1.0, 2.0))
        assert pytest.approx(2.0, rel=1e-3) == axis.J
        assert axis.system()(3j)[0, 0] == pytest.approx(flexible.transfer()(3j), rel=1e-11)
        assert axis.dynamics.motor_rate.tolist() == [0.0, 1.0, 0.0, 0.0]
    assert as_axis(control.zpk([], [0.0, -1.0], 0.5)).transfer()(2j) == pytest.approx(
        0.5 / (2j * (2j + 1))
    )
    assert as_axis(Inertia(3.0)) == Axis(3.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Axis(-1.0), "J = -1.0"),
        (lambda: Axis(1.0, viscous=-2.0), "viscous = -2.0"),
        (lambda: Axis(1.0, torque_limit=1.0, constant_load=-2.0), "cannot hold"),
        (lambda: Axis(1.0, torque_limit=2.0, friction=Friction(1.0, 2.0)), "static friction of 2"),
        (lambda: Axis(1.0, torque_limit=1.0, friction=Friction(3.0)), "raise the limit above it"),
        (lambda: Friction(2.0, 1.0), "static = 1.0"),
        (lambda: FlexibleMode(6.0), "without its share"),
        (lambda: FlexibleMode(6.0, load_fraction=1.0), "load_fraction = 1.0"),
        (lambda: FlexibleMode(6.0, 1.0, load_fraction=0.5), "damping = 1.0"),
        (lambda: Axis(1.0, modes=[FlexibleMode(6.0, load_fraction=0.5)] * 2), "held=True"),
        (lambda: chain_axis([1.0, 2.0], [1.0, 2.0]), "expected 1 finite"),
        (lambda: system_axis(control.tf([1.0], [1.0, 1.0])), "two poles more"),
        (lambda: system_axis(control.tf([1.0, 0, 0], [1.0, 1.0])), "improper .* two poles more"),
        (lambda: system_axis(control.tf([nan], [1.0, 1.0, 0])), "system with nan in it"),
    ],
)
def test_what_no_axis_is_gets_one_line(make, words):
    with pytest.raises(ValueError, match=words) as refusal:
        make()
    assert "\n" not in str(refusal.value)


def test_a_load_that_helps_lets_a_weak_drive_move_one_way():
    axis = Axis(1.0, torque_limit=2.0, friction=Friction(1.0, 3.0), constant_load=-1.5)
    assert axis.torque_limit == 2.0


def test_defaults_are_ideal():
    axis = Axis(1.0)
    assert axis.torque_limit == inf
    assert axis.is_rigid
    assert not axis.is_nonlinear
    assert FlexibleMode(6.0, load_fraction=0.5).shapes == (1.0, -1.0)
    assert FlexibleMode(6.0, load_fraction=0.8).shapes == pytest.approx((2.0, -0.5))
    assert sqrt(FlexibleMode(6.0, load_fraction=0.5).omega / (12 * pi)) == 1.0
