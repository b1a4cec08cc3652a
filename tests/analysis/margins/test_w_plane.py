"""Discrete loops, against z evaluated on the unit circle and poles found in z."""

import math

import control
import numpy as np
import pytest

from jounce.analysis.margins import loop_margins
from jounce.analysis.margins.factoring import factored

S, Z = control.tf("s"), control.tf("z")
DT = 0.05
LOOPS = {
    "double integrator": 40 * (Z - 0.9) * 0.00125 * (Z + 1) / ((Z - 1) ** 2 * (Z - 0.1)),
    "lag": control.sample_system(control.ss(3 / (S * (S + 1))), DT),
    "resonance": control.sample_system(control.ss(2 * (S + 5) / (S**2 + 0.2 * S + 30)), DT),
    "dead beat": control.tf([0.5], [1, -1, 0, 0], DT),
    "pole at minus one": control.tf([0.1], [1, 1], DT),
    "direct": control.tf([0.4, 0.1], [1, -0.7], DT),
    "conditionally stable": control.tf([2.2, -3.96, 1.785], [1, -3, 3, -1], DT),
}
LOOPS["double integrator"].dt = DT


def on_circle(system, hz):
    return system(np.exp(2j * np.pi * np.asarray(hz) * DT))


def closed_poles(system, factor=1.0):
    return control.feedback(control.ss(system) * factor).poles()


@pytest.mark.parametrize("name", LOOPS)
def test_factors_give_the_values_on_the_unit_circle(name):
    loop = factored(LOOPS[name])
    omega = np.geomspace(0.1, 1e3, 50)
    z = np.exp(1j * loop.radians(omega) * DT)
    assert loop.values(omega) == pytest.approx(LOOPS[name](z), rel=1e-9), name


@pytest.mark.parametrize("name", LOOPS)
def test_the_closed_loop_poles_are_those_in_z(name):
    margins = loop_margins(LOOPS[name])
    expected = closed_poles(LOOPS[name])
    found = np.asarray(margins.closed_loop_poles)
    assert found.size == expected.size
    for pole in expected:
        assert abs(found - pole).min() < 1e-7, name
    assert margins.stable == bool(np.all(abs(expected) < 1)), name
    assert margins.dt == DT


@pytest.mark.parametrize("name", [name for name in LOOPS if name != "pole at minus one"])
def test_margins_are_those_of_a_dense_search_around_the_circle(name):
    system = LOOPS[name]
    margins = loop_margins(system)
    assert margins.stable
    hz = np.linspace(1e-6, 0.5 / DT, 100_001)
    loop = on_circle(control.tf(system), hz)  # polynomials are soon evaluated
    assert margins.modulus_margin == pytest.approx(abs(1 + loop).min(), rel=1e-6)
    assert margins.complementary_peak == pytest.approx(abs(loop / (1 + loop)).max(), rel=1e-6)
    crossing = np.flatnonzero(np.diff(np.sign(abs(loop) - 1)))
    assert len(margins.crossovers_hz) == crossing.size
    if crossing.size:
        angle = np.degrees(abs(np.angle(-loop[crossing])))
        assert margins.phase_margin_deg == pytest.approx(angle.min(), abs=0.02)


@pytest.mark.parametrize("name", LOOPS)
def test_a_gain_margin_takes_the_loop_to_the_unit_circle(name):
    margins = loop_margins(LOOPS[name])
    for side, sign in (("lower", -1), ("upper", 1)):
        margin = getattr(margins, f"{side}_gain_margin_db")
        if math.isfinite(margin):
            factor = 10 ** (sign * margin / 20)
            assert abs(closed_poles(LOOPS[name], factor)).max() == pytest.approx(1.0, abs=1e-7)
            hz = getattr(margins, f"{side}_gain_margin_hz")
            assert factor * on_circle(LOOPS[name], hz) == pytest.approx(-1.0, abs=1e-7)


def test_half_the_sampling_frequency_is_the_last():
    """0.5/(z + 0.2) is real and negative at z = −1 alone."""
    margins = loop_margins(control.tf([0.5], [1, 0.2], DT))
    assert margins.upper_gain_margin_hz == pytest.approx(0.5 / DT, rel=1e-15)
    assert margins.upper_gain_margin_db == pytest.approx(20 * math.log10(0.8 / 0.5), rel=1e-12)


def test_sampling_quickly_gives_the_margins_of_continuous_time():
    loop = control.ss(3 / (S * (S + 1) * (S / 20 + 1)))
    slow = loop_margins(loop)
    dt = 1e-5
    quick = loop_margins(control.sample_system(loop, dt))
    assert quick.crossover_hz == pytest.approx(slow.crossover_hz, rel=1e-4)
    assert quick.phase_margin_deg == pytest.approx(slow.phase_margin_deg, rel=1e-4)
    assert quick.upper_gain_margin_db == pytest.approx(slow.upper_gain_margin_db, rel=1e-3)
    # half a sample of the hold, to the first order
    lag = math.degrees(math.pi * slow.crossover_hz * dt)
    difference = slow.phase_margin_deg - quick.phase_margin_deg
    assert difference == pytest.approx(lag, rel=1e-2)


def test_an_unstable_loop_names_its_pole_in_z():
    text = loop_margins(100 * LOOPS["lag"]).summary()
    assert "UNSTABLE: closed-loop pole at z = " in text


def test_a_whole_delay_in_the_loop_costs_its_phase():
    lag = LOOPS["lag"]
    delayed = lag * control.ss(control.tf([1], [1, 0], DT))
    crossover = loop_margins(lag).crossover_hz
    lost = loop_margins(lag).phase_margin_deg - loop_margins(delayed).phase_margin_deg
    assert lost == pytest.approx(360 * crossover * DT, rel=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_states_that_are_mixed_keep_the_gain(seed):
    """A double integrator in balanced coordinates, rounded, behind a differenced PID.

    L = (40 + 100·T/(z − 1) + 12·(z − 1)/(T·z))·T²/4·(z + 1)/(z − 1)²
    """
    dt, share = 1e-3, 3.26
    mix = np.array([[share, 0.5 / share], [share, -0.5 / share]])
    a = mix @ np.array([[1.0, dt], [0.0, 1.0]]) @ np.linalg.inv(mix)
    rounding = np.random.default_rng(seed).integers(-4, 5, (2, 2)) * np.finfo(float).eps
    plant = control.ss(
        a + rounding, mix @ [[dt**2 / 4], [dt / 2]], [[1.0, 0.0]] @ np.linalg.inv(mix), 0, dt
    )
    integral = control.ss(1.0, 1.0, 100.0 * dt, 40.0 + 12.0 / dt, dt)
    difference = control.ss(0.0, 1.0, -12.0 / dt, 0.0, dt)
    found = loop_margins((integral + difference) * plant)

    def exact(omega):
        w = 2.0 * np.exp(0.5j * omega * dt) * 1j * np.sin(0.5 * omega * dt)  # z − 1, all digits
        controller = 40.0 + 100.0 * dt / w + 12.0 / dt * w / (1.0 + w)
        return controller * dt**2 / 4.0 * (w + 2.0) / w**2

    at = exact(2.0 * np.pi * found.crossover_hz)
    assert abs(at) == pytest.approx(1.0, rel=1e-8)
    assert found.phase_margin_deg == pytest.approx(180.0 + np.degrees(np.angle(at)), rel=1e-8)
