"""Factors of a loop: exact integrators, no spurious zeros, values as the system's own."""

import math

import control
import numpy as np
import pytest

from jounce.analysis.margins.factored_loop import HIGHEST, LOWEST, is_stable
from jounce.analysis.margins.factoring import factored

S = control.tf("s")


def mixed(system, seed=0):
    """Return the system with its states turned."""
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal(system.A.shape))[0]
    return control.ss(turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T, system.D)


def modal_loop(seed):
    """Return a PID on an inertia with random light modes, in parallel form."""
    rng = np.random.default_rng(seed)
    plant = control.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], 0)
    for omega in 10 ** rng.uniform(0.8, 2.5, 5):
        a = [[0, 1], [-(omega**2), -2 * omega * 10 ** rng.uniform(-3, -1.5)]]
        plant = plant + control.ss(a, [[0], [rng.uniform(0.02, 0.6)]], [[1, 0]], 0)
    return plant * control.ss((5 * S**2 + 28 * S + 35) / (S * (S / 400 + 1)))


@pytest.mark.parametrize("seed", range(20))
def test_a_modal_model_keeps_its_integrators(seed):
    loop = factored(modal_loop(seed))
    assert np.sum(loop.poles == 0) == 3
    assert loop.phase(np.array([LOWEST])) == pytest.approx(-1.5 * np.pi, abs=1e-12)


@pytest.mark.parametrize("masses", [[1.0, 2.0, 7.0], [0.3, 11.0, 5.0, 0.9]])
def test_a_free_chain_of_masses_keeps_its_rigid_body(masses):
    count = len(masses)
    difference = np.diff(np.eye(count), axis=0)
    stiffness = difference.T @ np.diag(900.0 + np.arange(count - 1)) @ difference
    inverse = np.diag(1 / np.array(masses))
    a = np.block(
        [
            [np.zeros((count, count)), np.eye(count)],
            [-inverse @ stiffness, -1e-3 * inverse @ stiffness],
        ]
    )
    b = np.concatenate([np.zeros(count), inverse[0]])[:, None]
    loop = factored(control.ss(a, b, np.eye(1, 2 * count), 0))
    assert np.sum(loop.poles == 0) == 2


def test_infinite_zeros_do_not_come_back_as_finite_ones():
    """The generalized eigenvalue problem gives some here, on most machines."""
    plant = control.ss((S + 2) / ((S + 1) ** 3 * (S + 30)))
    for seed in range(5):
        loop = factored(mixed(plant, seed))
        assert loop.zeros * loop.scale == pytest.approx(np.array([-2]), rel=1e-6)


@pytest.mark.parametrize("loop", [modal_loop(3), 5 * (S - 2) / ((S + 1) ** 3 * (S + 7)), S + 1])
def test_values_are_those_of_the_system(loop):
    factors = factored(loop)
    omega = np.logspace(-2, 3, 200)
    values = factors.values(omega / factors.scale)
    np.testing.assert_allclose(values, loop(1j * omega), rtol=1e-9)


def test_limits_are_values_like_any_other():
    loop = factored((2 * S + 3) / (S + 1))
    assert loop.values(np.array([LOWEST, HIGHEST])) == pytest.approx(np.array([3, 2]), rel=1e-14)
    assert [loop.hertz(omega) for omega in (LOWEST, HIGHEST)] == [0, math.inf]


def test_an_undamped_pole_is_not_stable():
    assert is_stable(np.array([-1e-9 + 1j, -1]))
    assert not is_stable(np.array([-1e-11 + 1j, -1]))
    assert not is_stable(np.array([0j]))
