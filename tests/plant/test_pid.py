"""The PID and its design: margins by plain complex arithmetic, published gains, errors."""

from cmath import phase
from math import degrees, inf, log10, nan, pi, radians

import control
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import MAGNITUDES, UNIT_FACTORS

from jounce.plant import PID, Inertia, design_pid

RATES = ("measured", "differenced")
THOMPSON = {"crossover_hz": 1.0, "phase_margin_deg": 45.0, "lower_gain_margin_db": 12.0}


def open_loop(gains, moment, omega):
    s = 1j * omega
    return (gains.kp + gains.ki / s + gains.kr * s) / moment / s**2


def specifications():
    return st.fixed_dictionaries(
        {
            "crossover_hz": MAGNITUDES,
            "phase_margin_deg": st.floats(0.5, 89.5),
            "lower_gain_margin_db": st.floats(1.5, 60.0),
        }
    )


@given(wanted=specifications(), magnitude=MAGNITUDES, unit=UNIT_FACTORS)
def test_the_three_margins_are_exactly_those_asked_for(wanted, magnitude, unit):
    """With L = −|L|·e^(jφ) at crossover; the gain limit by Routh: kr·kp·κ² > J·ki·κ."""
    moment = magnitude * unit
    gains = design_pid(moment, **wanted)
    text = f"design_pid({moment!r}, **{wanted})"
    response = open_loop(gains, moment, 2 * pi * wanted["crossover_hz"])
    assert abs(response) == pytest.approx(1.0, rel=1e-13), text
    assert degrees(phase(-response)) == pytest.approx(wanted["phase_margin_deg"], abs=1e-11), text
    routh = gains.kr * gains.kp / (moment * gains.ki)
    assert 20 * log10(routh) == pytest.approx(wanted["lower_gain_margin_db"], abs=1e-11), text
    assert min(gains.kr, gains.kp, gains.ki) > 0.0, text


@given(wanted=specifications())
def test_the_gain_margin_is_where_the_loop_becomes_unstable(wanted):
    """By the closed loop's own poles, on either side of the limit; no upper limit up to 80 dB."""
    gains = design_pid(1.0, **wanted)
    unit = 2 * pi * wanted["crossover_hz"]
    cubic = np.array([gains.kr / unit, gains.kp / unit**2, gains.ki / unit**3])
    limit = 10 ** (-wanted["lower_gain_margin_db"] / 20)
    for factor, stable in ((0.99, False), (1.01, True), (1 / limit, True), (1e4 / limit, True)):
        poles = np.roots([1.0, *(factor * limit * cubic)])
        assert bool(poles.real.max() < 0.0) is stable, f"{wanted}, gain × {factor * limit}"


@given(
    wanted=st.fixed_dictionaries(
        {
            "crossover_hz": st.sampled_from([1e-3, 1.0, 50.0]),
            "phase_margin_deg": st.floats(0.5, 89.5),
            "lower_gain_margin_db": st.floats(0.05, 60.0) | st.floats(0.05, 1.5),
        }
    )
)
@example(wanted={"crossover_hz": 1.0, "phase_margin_deg": 64.5, "lower_gain_margin_db": 1.0})
def test_no_other_crossover_has_a_smaller_phase_margin(wanted):
    """All crossovers are the roots of J²ω⁶ = (ki − kr·ω²)² + kp²ω²; the margin is the least."""
    try:
        gains = design_pid(1.0, **wanted)
    except ValueError:
        return  # refusing such specifications is an answer, too
    unit = 2 * pi * wanted["crossover_hz"]
    kr, kp, ki = gains.kr / unit, gains.kp / unit**2, gains.ki / unit**3
    squares = np.roots([1.0, -(kr**2), 2 * kr * ki - kp**2, -(ki**2)])
    real = squares.real[(np.abs(squares.imag) < 1e-9) & (squares.real > 0)]
    margins = [degrees(phase(-open_loop(gains, 1.0, unit * x**0.5))) for x in real]
    least = min(margins, key=abs)
    text = f"design_pid(1.0, **{wanted}): margins {margins} at {real**0.5} of the crossover asked"
    assert least == pytest.approx(wanted["phase_margin_deg"], abs=1e-4), text


@pytest.mark.parametrize("inertia", [2.5, Inertia(2.5)])
def test_the_published_specifications_give_these_gains(inertia):
    gains = design_pid(inertia, **THOMPSON)
    assert gains.kr == pytest.approx(5.402451 * 2.5, abs=5e-7 * 2.5)
    assert gains.kp / gains.kr == pytest.approx(5.167184, abs=5e-7)
    assert gains.ki / gains.kr == pytest.approx(7.012046, abs=5e-7)


def test_the_printed_gains_miss_the_specifications():
    """Thompson's kr = 11.09 J, ki = 6.286 kr, kp = 3.187 kr: 1.750 Hz, 73.0°, 15.0 dB."""
    kr = 11.09
    gains = PID(kp=3.187 * kr, ki=6.286 * kr, kr=kr)
    omega = 2 * pi * np.linspace(1.7, 1.8, 100_001)
    crossover = omega[np.abs(np.abs(open_loop(gains, 1.0, omega)) - 1.0).argmin()]
    assert crossover / (2 * pi) == pytest.approx(1.750, abs=5e-4)
    margin = degrees(phase(-open_loop(gains, 1.0, crossover)))
    assert margin == pytest.approx(73.0, abs=0.05)
    assert 20 * log10(gains.kr * gains.kp / gains.ki) == pytest.approx(15.0, abs=0.05)


@pytest.mark.parametrize("moment", [1e-200, 1e-150, 1e-9, 1e9, 1e150, 1e200])
def test_gains_are_proportional_to_any_inertia(moment):
    one, many = design_pid(1.0, **THOMPSON), design_pid(moment, **THOMPSON)
    for name in ("kp", "ki", "kr"):
        expected = getattr(one, name) * moment
        assert getattr(many, name) == pytest.approx(expected, rel=1e-14, abs=0.0), name


@pytest.mark.parametrize("unit", [1e-60, 1e-6, 1e6, 1e60])
def test_gains_scale_with_the_unit_of_time(unit):
    one = design_pid(1.0, **THOMPSON)
    other = design_pid(1.0, **(THOMPSON | {"crossover_hz": unit}))
    assert other.kr == pytest.approx(one.kr * unit, rel=1e-13, abs=0.0)
    assert other.kp == pytest.approx(one.kp * unit**2, rel=1e-13, abs=0.0)
    assert other.ki == pytest.approx(one.ki * unit**3, rel=1e-13, abs=0.0)


@pytest.mark.parametrize(
    "wanted", [{"crossover_hz": 1e-120}, {"crossover_hz": 1e120}, {"crossover_hz": 1e300}]
)
def test_gains_beyond_the_range_of_a_double_are_refused(wanted):
    """The integral gain grows with the cube of the crossover; neither inf nor 0 is an answer."""
    with pytest.raises(ValueError, match="range of a double"):
        design_pid(1.0, **(THOMPSON | wanted))


@pytest.mark.parametrize("name", list(THOMPSON))
@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_specification_that_is_not_finite_is_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a"):
        design_pid(1.0, **(THOMPSON | {name: value}))


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_a_crossover_that_is_not_positive_is_refused(value):
    with pytest.raises(ValueError, match=f"crossover_hz = {value!r}: expected a positive"):
        design_pid(1.0, **(THOMPSON | {"crossover_hz": value}))


@pytest.mark.parametrize("value", [0.0, -45.0, 90.0, 120.0, 360.0])
def test_a_phase_margin_outside_0_to_90_is_refused(value):
    with pytest.raises(ValueError, match=f"phase_margin_deg = {value!r}: .*between 0 and 90 deg"):
        design_pid(1.0, **(THOMPSON | {"phase_margin_deg": value}))


@pytest.mark.parametrize("value", [-4.0, -20.0])
def test_zeros_beyond_the_crossover_are_a_contradiction(value):
    """At 45° the zeros reach the crossover at a gain factor of cos 45°, −3.01 dB."""
    message = f"lower_gain_margin_db = {value!r} contradicts a phase margin of 45.0 deg.*positive"
    with pytest.raises(ValueError, match=message):
        design_pid(1.0, **(THOMPSON | {"lower_gain_margin_db": value}))


@pytest.mark.parametrize("value", [0.0, -1.0, -3.0])
def test_a_gain_margin_that_is_not_positive_is_refused(value):
    message = f"lower_gain_margin_db = {value!r}: expected a positive number of dB"
    with pytest.raises(ValueError, match=message):
        design_pid(1.0, **(THOMPSON | {"lower_gain_margin_db": value}))


@pytest.mark.parametrize("moment", [0.0, -1.0, nan, inf])
def test_an_inertia_that_is_not_positive_is_refused(moment):
    with pytest.raises(ValueError, match=f"J = {moment!r}: expected a positive"):
        design_pid(moment, **THOMPSON)


@pytest.mark.parametrize(
    "gains", [(3.0, 2.0, 0.5), (3.0, 0.0, 0.5), (0.0, 2.0, 0.0), (-1.0, 4.0, 2.0), (3.0, 0.0, 0.0)]
)
@pytest.mark.parametrize("omega", [1e-2, 0.7, 30.0])
def test_both_forms_are_the_ideal_controller(gains, omega):
    kp, ki, kr = gains
    controller, s = PID(kp=kp, ki=ki, kr=kr), 1j * omega
    expected = kp + ki / s + kr * s
    assert controller.transfer()(s) == pytest.approx(expected, rel=1e-14)
    error, rate = controller.system()(s)[0]
    assert error == pytest.approx(kp + ki / s, rel=1e-14)
    assert rate == pytest.approx(kr, rel=1e-14)
    assert error + s * rate == pytest.approx(expected, rel=1e-14)


def test_signals_have_the_loops_names():
    system, transfer = PID(1, 2, 3).system(), PID(1, 2, 3).transfer()
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == ["e", "e_rate"]
    assert transfer.input_labels == ["e"]
    assert system.output_labels == transfer.output_labels == ["u_feedback"]
    assert system.state_labels == ["e_integral"]
    assert (system.name, transfer.name) == ("controller", "controller")


def test_without_integral_gain_the_transfer_function_has_no_pole():
    assert PID(kp=1.0, ki=0.0, kr=2.0).transfer().poles().size == 0


# The digital controller


def run_by_hand(gains, dt, errors, rates=None):
    """Return the torques of a PID written out as a loop."""
    total = past = 0.0
    torques = []
    for i, e in enumerate(errors):
        total += dt * e
        rate = (e - past) / dt if rates is None else rates[i]
        torques.append(gains.kp * e + gains.ki * total + gains.kr * rate)
        past = e
    return torques


SETS = [(3.0, 2.0, 0.5), (3.0, 0.0, 0.5), (0.0, 2.0, 0.0), (-1.0, 4.0, 2.0), (3.0, 0.0, 0.0)]


@pytest.mark.parametrize("gains", SETS)
@pytest.mark.parametrize("dt", [1e-4, 0.3])
@pytest.mark.parametrize("rate", ["measured", "differenced"])
def test_the_digital_controller_is_its_difference_equation(gains, dt, rate):
    gains, rng = PID(*gains), np.random.default_rng(7)
    errors, rates = rng.normal(size=(2, 50))
    digital = gains.sampled(dt, rate=rate)
    fed = np.array([errors, rates]) if rate == "measured" else errors[None, :]
    x, torques = np.zeros(digital.nstates), []
    for u in fed.T:
        torques.append((digital.C @ x + digital.D @ u)[0])
        x = digital.A @ x + digital.B @ u
    expected = run_by_hand(gains, dt, errors, rates if rate == "measured" else None)
    np.testing.assert_allclose(torques, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("gains", SETS)
@pytest.mark.parametrize("dt", [1e-4, 0.3])
@pytest.mark.parametrize("angle", [1e-2, 0.7, 3.0])
def test_the_digital_controller_has_the_transfer_functions_stated(gains, dt, angle):
    (kp, ki, kr), z = gains, np.exp(1j * angle)
    integral = ki * dt * z / (z - 1)
    measured, differenced = (PID(kp, ki, kr).sampled(dt, rate=r)(z) for r in RATES)
    size = abs(kp) + abs(integral)
    np.testing.assert_allclose(np.ravel(measured), [kp + integral, kr], rtol=0, atol=1e-13 * size)
    slope = kr * (z - 1) / (dt * z)
    assert differenced == pytest.approx(kp + integral + slope, abs=1e-13 * (size + 2 * kr / dt))


@pytest.mark.parametrize("rate", ["measured", "differenced"])
def test_sampled_ever_faster_it_becomes_the_controller(rate):
    gains, omega, distances = PID(3.0, 2.0, 0.5), 1.7, []
    for dt in (1e-2, 1e-3, 1e-4):
        k = np.ravel(gains.sampled(dt, rate=rate)(np.exp(1j * omega * dt)))
        value = k @ [1.0, 1j * omega] if rate == "measured" else k[0]
        distances.append(abs(value - gains.transfer()(1j * omega)))
    ratios = np.array(distances[:-1]) / distances[1:]
    np.testing.assert_allclose(ratios, 10.0, rtol=1e-2)
    assert distances[-1] < 2e-4


def test_signals_of_the_digital_controller():
    measured, differenced = (PID(1, 2, 3).sampled(0.1, rate=rate) for rate in RATES)
    assert measured.dt == differenced.dt == 0.1
    assert measured.input_labels == ["e", "e_rate"]
    assert differenced.input_labels == ["e"]
    assert measured.output_labels == differenced.output_labels == ["u_feedback"]
    assert measured.state_labels == ["e_integral"]
    assert differenced.state_labels == ["e_integral", "e_past"]
    assert (measured.name, differenced.name) == ("controller", "controller")
    assert PID(1, 2, 3).sampled(0.1).ninputs == 2
    for gains, rate in ((PID(1, 0, 0), "differenced"), (PID(1, 0, 3), "measured")):
        assert gains.sampled(0.1, rate=rate).nstates == 0
        assert gains.sampled(0.1, rate=rate).isdtime(strict=True)


@pytest.mark.parametrize("dt", [0.0, -1.0, nan, inf])
def test_a_dt_that_is_not_positive_is_refused(dt):
    with pytest.raises(ValueError, match=f"dt = {dt!r}: expected a positive"):
        PID(1.0, 1.0, 1.0).sampled(dt)


@pytest.mark.parametrize("rate", ["filtered", None, 1.0])
def test_another_rate_is_refused(rate):
    with pytest.raises(ValueError, match=f"rate = {rate!r}: expected 'measured' or 'differenced'"):
        PID(1.0, 1.0, 1.0).sampled(0.1, rate=rate)


def test_a_dt_out_of_proportion_to_the_gains_is_refused():
    for gains, dt in ((PID(1.0, 1e300, 1.0), 1e10), (PID(1.0, 1.0, 1e300), 1e-10)):
        with pytest.raises(ValueError, match=f"dt = {dt!r}: .*range of a double; choose other"):
            gains.sampled(dt, rate="differenced")


# Errors


@pytest.mark.parametrize("name", ["kp", "ki", "kr"])
@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_gain_that_is_not_finite_is_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} = {value!r}: expected a finite"):
        PID(**{"kp": 1.0, "ki": 1.0, "kr": 1.0, name: value})


def test_gains_are_frozen_floats():
    gains = PID(1, 2, np.float32(3))
    assert [type(gain) for gain in (gains.kp, gains.ki, gains.kr)] == [float] * 3
    with pytest.raises(AttributeError):
        gains.kp = 4.0


def test_design_needs_degrees_and_decibels():
    """The margins' units in the names: 45 deg is no π/4."""
    gains = design_pid(1.0, **(THOMPSON | {"phase_margin_deg": degrees(radians(45.0))}))
    assert gains == design_pid(1.0, **THOMPSON)
