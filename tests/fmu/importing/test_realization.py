"""Realisations of impulse responses: of random systems, and of those that are hard."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tiers import some

from jounce.fmu.importing.realization import impulse_response, realize
from jounce.plant import FlexibleInertia, Inertia, zero_order_hold


def slowly(system, count):
    """Return C·A^k·B from the recursion."""
    x, found = np.array(system.B), []
    for _ in range(count):
        found.append(system.C @ x)
        x = system.A @ x
    return np.array(found)


def frequency_error(found, system, omega):
    """Return the largest error over frequency, relative to the largest entry at each."""
    worst = 0.0
    for z in np.exp(1j * omega * system.dt):
        pair = [m.C @ np.linalg.solve(z * np.eye(len(m.A)) - m.A, m.B) for m in (found, system)]
        worst = max(worst, np.abs(pair[0] - pair[1]).max() / np.abs(pair[1]).max())
    return worst


@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.integers(1, 6),
    inputs=st.integers(1, 3),
    outputs=st.integers(1, 3),
)
def test_random_systems(seed, states, inputs, outputs):
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(states, states))
    a *= 0.95 / np.abs(np.linalg.eigvals(a)).max()
    system = control.ss(
        a, rng.normal(size=(states, inputs)), rng.normal(size=(outputs, states)), 0, 1.0,
        remove_useless_states=False,
    )  # fmt: skip
    found = realize(slowly(system, 60), 10)
    text = f"seed={seed}, states={states}, inputs={inputs}, outputs={outputs}"
    assert found.order <= states, text
    assert found.residual < 1e-9, text
    again = impulse_response(found.A, found.B, found.C, 60)
    expected = slowly(system, 60)
    peak = np.abs(expected).max()
    np.testing.assert_allclose(again, expected, rtol=0, atol=1e-8 * peak, err_msg=text)


@pytest.mark.parametrize(
    ("name", "order", "tolerance"),
    [("inertia", 2, 1e-8), ("flexible", 4, 1e-8), ("delayed", 4, 1e-7), ("modes", 10, 1e-6)],
)
@pytest.mark.parametrize("scale", some([1e-9, 1.0, 1e9], 2))
def test_plants_sampled_fast(name, order, tolerance, scale):
    """Integrators, light damping and dead time, from 0.01 Hz to half the sampling rate."""
    dt = 0.001
    modes = sum(control.tf([1], [1, 0.02 * w, w**2]) for w in (3.0, 20.0, 70.0, 300.0, 1500.0))
    systems = {
        "inertia": zero_order_hold(Inertia(2.0).system(), dt),
        "flexible": zero_order_hold(FlexibleInertia(2.0, 3.0, 0.02).system(), dt),
        "delayed": zero_order_hold(Inertia(2.0).system(), dt, delay=1.4e-3),
        "modes": zero_order_hold(modes, dt),
    }
    system = systems[name]
    found = realize(scale * slowly(system, 2000), 20)
    assert found.order == order
    found = realize(slowly(system, 2000), 20)
    omega = np.geomspace(2.0 * np.pi * 0.01, 0.999 * np.pi / dt, 100)
    assert frequency_error(found, system, omega) < tolerance


def test_units_do_not_matter():
    response = slowly(zero_order_hold(Inertia(2.0).system(), 0.001), 500)
    plain = realize(response, 6)
    scaled = realize(response * np.array([[1e-9], [1e12]]), 6)
    assert scaled.order == plain.order == 2
    np.testing.assert_allclose(
        impulse_response(scaled.A, scaled.B, scaled.C, 500),
        impulse_response(plain.A, plain.B, plain.C, 500) * np.array([[1e-9], [1e12]]),
        rtol=1e-9,
    )


def test_no_response_needs_no_state():
    found = realize(np.zeros((50, 2, 3)), 5)
    assert (found.order, found.residual) == (0, 0.0)
    assert impulse_response(found.A, found.B, found.C, 50).shape == (50, 2, 3)


@pytest.mark.parametrize("delay", [1, 3, 7])
def test_a_pure_delay(delay):
    response = np.zeros((50, 1, 1))
    response[delay - 1] = 2.5
    found = realize(response, 10)
    assert found.order == delay
    np.testing.assert_allclose(
        impulse_response(found.A, found.B, found.C, 50), response, rtol=0, atol=1e-12
    )


def test_what_no_small_system_has_shows_in_the_residual():
    noise = np.random.default_rng(3).normal(size=(400, 1, 1))
    assert realize(noise, 8).residual > 0.1
