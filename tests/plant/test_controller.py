"""Controllers: discretised filters, the core against k(z), refusals."""

from math import comb, factorial, pi

import control
import numpy as np
import pytest
from scipy.signal import lfilter

from jounce.analysis import loop_margins
from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleMode,
    LeadLag,
    LowPass,
    Notch,
    Ramp,
    ServoLoop,
    Sine,
    TorqueSteps,
    Wind,
    as_controller,
    chain_axis,
    inverse_feedforward,
    low_frequency_feedforward,
)
from jounce.shaping import Limits, Trajectory, min_time_move

T = 1e-3
PID_LAW = PID(1200.0, 4000.0, 60.0, derivative_filter=1.5e-3)
CASCADE = CascadedPI(25.0, 60.0, 0.05, velocity_filter=0.5e-3)
FILTERS = [
    Notch(30.0, zero_damping=0.03, pole_damping=0.5),
    Notch(30.0, 40.0, zero_damping=0.03, pole_damping=0.5),
    LeadLag(10.0, 90.0),
    LowPass(150.0),
    LowPass(150.0, order=1),
]


def of_sections(sections, z):
    """Return what sections do at z."""
    value = 1.0
    for b0, b1, b2, a1, a2 in sections:
        value *= (b0 + b1 / z + b2 / z**2) / (1 + a1 / z + a2 / z**2)
    return value


@pytest.mark.parametrize("element", FILTERS, ids=repr)
def test_tustin_keeps_the_filter_at_its_own_frequency_and_at_dc(element):
    sections = Controller(PID_LAW, filters=element, sample_time=T).sections
    s = 2j * pi * element.prewarp_hz
    assert of_sections(sections, np.exp(s * T)) == pytest.approx(
        element.transfer()(s), rel=1e-10, abs=1e-12
    )
    assert of_sections(sections, 1.0) == pytest.approx(1.0, rel=1e-12)
    assert element.transfer()(0) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("element", FILTERS, ids=repr)
def test_matched_keeps_poles_and_dc(element):
    sections = Controller(
        PID_LAW, filters=element, sample_time=T, discretisation="matched"
    ).sections
    assert of_sections(sections, 1.0) == pytest.approx(1.0, rel=1e-11)
    for pole in element.transfer().poles():
        assert abs(of_sections(sections, np.exp(pole * T) * (1 + 1e-9))) > 1e5


@pytest.mark.parametrize("element", FILTERS, ids=repr)
def test_a_held_filter_has_the_step_response_of_the_filter(element):
    sections = Controller(PID_LAW, filters=element, sample_time=T, discretisation="hold").sections
    z = np.exp(2j * pi * 20.0 * T)
    held = control.sample_system(control.ss(element.transfer()), T, "zoh")
    assert of_sections(sections, z) == pytest.approx(complex(held(z)), rel=1e-9)


def test_any_system_is_a_filter():
    lag = control.tf([1.0], [0.01, 1.0])
    own = Controller(PID_LAW, filters=[lag], sample_time=T).sections
    given = Controller(PID_LAW, filters=[control.sample_system(lag, T, "tustin")], sample_time=T)
    z = np.exp(2j * pi * 20.0 * T)
    assert of_sections(own, z) == pytest.approx(of_sections(given.sections, z), rel=1e-9)


@pytest.mark.parametrize("sensor", ["motor", "load"])  # with both CS is of the load's alone
@pytest.mark.parametrize("law", [PID_LAW, CASCADE], ids=["pid", "cascade"])
def test_the_core_runs_what_the_sampled_controller_says(law, sensor):
    """The answer to an error of one sample of the encoder is −CS's impulse response."""
    axis = Axis(
        2.0,
        modes=FlexibleMode(60.0, 0.05, load_fraction=0.2),
        viscous=1.0,
        current_lag=1e-4,
        sensor=sensor,
    )
    controller = Controller(law, filters=FILTERS[3:], sample_time=T, delay=1.7e-3)
    loop = ServoLoop(axis, controller)
    noise = np.zeros(200)
    noise[3] = 1e-3
    response = loop.respond(Ramp(0.0), T, duration=0.2, noise=noise)
    expected = control.forced_response(loop.sensitivity().CS, np.arange(200) * T, noise)
    np.testing.assert_allclose(
        response.run.samples[:, 2], -expected.outputs, rtol=0, atol=1e-11 * 60.0
    )


def test_the_sampled_loop_has_the_poles_of_the_core_in_free_motion():
    """Free motion of a two-encoder loop obeys the characteristic polynomial."""
    axis = Axis(2.0, modes=FlexibleMode(60.0, 0.05, load_fraction=0.2), sensor="both")
    loop = ServoLoop(axis, Controller(CASCADE, sample_time=T, delay=0.4e-3))
    push = TorqueSteps([0.0, 0.01], [1.0, -1.0])
    response = loop.respond(Ramp(0.0), T, duration=1.2, disturbance=push)
    characteristic = np.poly(loop.sensitivity().S.poles()).real
    y = response.position[20:300]
    left = np.convolve(y, characteristic, mode="valid")
    assert np.abs(left).max() < 1e-11 * np.abs(y).max()


@pytest.mark.parametrize("law", [PID(1200.0, 0.0, 60.0), CascadedPI(25.0, 60.0)], ids=["pd", "p"])
@pytest.mark.parametrize("sensor", ["motor", "both"])
def test_an_integral_without_gain_makes_no_loop_unstable(law, sensor):
    axis = Axis(2.0, modes=FlexibleMode(60.0, 0.05, load_fraction=0.2), sensor=sensor)
    wind = Wind("first_order", 1.0, corner_hz=1.0)
    for controller in (Controller(law), Controller(law, sample_time=T, delay=T)):
        loop = ServoLoop(axis, controller)
        margins = loop_margins(loop)
        assert margins.phase_margin_deg > 20.0
        assert loop.deviations(wind).load > 0.0
        assert loop_margins(loop.loop_transfer()).crossover_hz == margins.crossover_hz


def test_a_cascade_is_the_pid_that_it_says():
    kp = 60.0 * (25.0 + 1 / 0.05)
    pid = PID(kp, 60.0 * 25.0 / 0.05, 60.0)
    move = min_time_move(0.2, Limits(velocity=1.0, acceleration=8.0, jerk=100.0))
    axis = Axis(2.0, viscous=1.0)
    plain = ServoLoop(axis, CascadedPI(25.0, 60.0, 0.05)).respond(move, 0.01, duration=0.6)
    same = ServoLoop(axis, pid).respond(move, 0.01, duration=0.6)
    np.testing.assert_allclose(plain.position, same.position, atol=1e-14)
    lagging = ServoLoop(axis, CascadedPI(25.0, 60.0, velocity_feedforward=0.0))
    behind = lagging.respond(Ramp(0.3), 0.1, duration=3.0)
    assert behind.error[-1] == pytest.approx(0.3 * (1 / 25.0 + 1.0 / 60.0 / 25.0), rel=1e-6)


def test_the_load_follows_exactly_with_the_exact_inverse():
    powers = np.arange(7)  # of 12012 ∫ x⁶(1 − x)⁶ dx: smooth up to the derivative 6
    c = [12012 * comb(6, k) * (-1) ** k / (7 + k) * 0.2 / 0.4 ** (7 + k) for k in powers]
    states = np.zeros((1, 14))
    states[0, 7:] = [value * factorial(7 + k) for k, value in enumerate(c)]
    move = Trajectory([0.0, 0.4], states)
    chain = chain_axis([1.0, 2.0, 0.5], [8000.0, 3000.0], viscous=0.7)
    forward = inverse_feedforward(chain, move)
    assert forward.order == 6
    response = ServoLoop(chain, PID(800.0, 2000.0, 60.0), forward).respond(move, 0.01, duration=0.6)
    assert response.peak_load_error < 2e-11
    assert np.abs(response.twist).max() > 1e-4
    nearly = low_frequency_feedforward(chain)
    assert {k: nearly.torque[k] for k in (2, 4)} == pytest.approx(
        {k: forward.torque[k] for k in (2, 4)}, rel=1e-12
    )


def test_friction_feedforward_follows_the_sign_of_the_command():
    from jounce.plant import Friction

    axis = Axis(2.0, friction=Friction(3.0), viscous=0.5)
    law = PID(2842.45, 0.0, 98.0)
    for controller, part in ((law, 0.01), (Controller(law, sample_time=T), 0.3)):
        errors = []
        for gain in (0.0, 3.0):
            loop = ServoLoop(axis, controller, Feedforward({1: 0.5, 2: 2.0}, friction=gain))
            response = loop.respond(Sine(0.01, 1.0), T, duration=2.0)
            errors.append(np.abs(response.error[1000:]).max())
        assert errors[1] < part * errors[0]


def test_a_lead_makes_up_for_the_delay():
    move = min_time_move(0.5, Limits(velocity=1.0, acceleration=8.0, jerk=100.0))
    controller = Controller(PID(500.0, 500.0, 50.0), sample_time=4e-3, delay=3e-3)
    errors = [
        ServoLoop(Axis(2.0), controller, Feedforward({2: 2.0}, lead=lead)).respond(move, 1e-3)
        for lead in (0.0, 5e-3)
    ]
    assert errors[1].peak_error < 0.15 * errors[0].peak_error


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Controller(PID_LAW, delay=1e-3), "delay = 0.001 without a sample time"),
        (
            lambda: Controller(
                PID_LAW, filters=Notch(600.0, zero_damping=0.1, pole_damping=0.5), sample_time=T
            ),
            "Nyquist frequency of 500 Hz",
        ),
        (lambda: Controller(PID_LAW, anti_windup="some"), "anti_windup = 'some'"),
        (lambda: Controller(PID_LAW, discretisation="euler"), "'tustin', 'matched' or 'hold'"),
        (lambda: BackCalculation(0.0), "tracking_time = 0.0"),
        (
            lambda: Controller(PID_LAW, sample_time=T, anti_windup=BackCalculation(1e-4)),
            "give 0.0005 or more",
        ),
        (lambda: Clamp(-1.0), "integral_limit = -1.0"),
        (lambda: LowPass(1.0, order=3), "order = 3"),
        (lambda: PID(1.0, 1.0, 1.0, derivative_filter=-1.0), "derivative_filter = -1.0"),
        (lambda: CascadedPI(1.0, 1.0, 0.0), "reset_time = 0.0"),
        (lambda: Controller(PID_LAW).sampled(), "has no samples"),
        (lambda: Controller(PID_LAW, sample_time=T).transfer(), "has no k"),
        (lambda: ServoLoop(Axis(1.0), Controller(PID_LAW, sample_time=T)).system(), "digital"),
        (lambda: ServoLoop(Axis(1.0), PID_LAW, Feedforward(lead=1.0)), "lead = 1.0"),
        (
            lambda: inverse_feedforward(
                Axis(1.0, modes=FlexibleMode(9.0, 0.1, motor_shape=1.4, load_shape=-1.3))
            ),
            "the inverse of this axis is unstable",
        ),
    ],
)
def test_what_no_controller_is_gets_one_line(make, words):
    with pytest.raises((ValueError, TypeError), match=words) as refusal:
        make()
    assert "\n" not in str(refusal.value)


def test_a_law_alone_is_a_continuous_controller():
    assert as_controller(PID_LAW) == Controller(PID_LAW)
    with pytest.raises(TypeError, match="expected PID, CascadedPI or Controller"):
        ServoLoop(Axis(1.0), 3.0)


def gain_at(controller, hz):
    """Return what the filters of a digital controller make of a sine, by running them."""
    x = np.cos(2 * np.pi * hz * T * np.arange(4000))
    for b0, b1, b2, a1, a2 in controller.sections:
        x = lfilter([b0, b1, b2], [1.0, a1, a2], x)
    return np.abs(2.0 * np.mean(x[2000:] * np.exp(-2j * np.pi * hz * T * np.arange(2000))))


@pytest.mark.parametrize("hz", [420.0, 437.0, 470.0])
def test_a_notch_near_nyquist_is_warned_of_and_matched_stops_more_beside_it(hz):
    notch = Notch(hz, zero_damping=0.05, pole_damping=0.5)
    beside = 0.93 * hz
    asked = abs(notch.transfer()(2j * np.pi * beside))
    with pytest.warns(
        UserWarning, match=f"Notch at {hz:g} Hz, .* Nyquist frequency of 500 Hz"
    ) as w:
        tustin = Controller(PID_LAW, filters=notch, sample_time=T)
    (told,) = map(str, (each.message for each in w))
    assert "discretisation = 'matched'" in told
    matched = Controller(PID_LAW, filters=notch, sample_time=T, discretisation="matched")
    assert gain_at(tustin, beside) > 2.0 * asked
    assert gain_at(matched, beside) < 1.3 * asked
    remedy = float(told.rpartition(" ")[2])
    Controller(PID_LAW, filters=notch, sample_time=remedy)


@pytest.mark.parametrize(
    "element", [LowPass(410.0), LowPass(410.0, order=1), LeadLag(390.0, 441.0)]
)
def test_other_filters_near_nyquist_are_warned_of_with_a_sample_time_that_is_silent(element):
    with pytest.warns(UserWarning, match="is distorted; use a sample time up to") as w:
        Controller(PID_LAW, filters=element, sample_time=T)
    Controller(PID_LAW, filters=element, sample_time=float(str(w[0].message).rpartition(" ")[2]))


def test_a_held_notch_that_stops_nothing_is_warned_of():
    notch = Notch(200.0, zero_damping=0.1, pole_damping=0.5)
    with pytest.warns(UserWarning, match="discretisation = 'tustin'"):
        held = Controller(PID_LAW, filters=notch, sample_time=T, discretisation="hold")
    assert gain_at(held, 200.0) > 0.6
    assert gain_at(Controller(PID_LAW, filters=notch, sample_time=T), 200.0) < 0.21


def test_a_notch_whose_poles_lie_above_nyquist_is_refused():
    skew = Notch(50.0, 600.0, zero_damping=0.1, pole_damping=0.5)
    with pytest.raises(ValueError, match=r"use a sample time below 0\.0008333"):
        Controller(PID_LAW, filters=skew, sample_time=T)
