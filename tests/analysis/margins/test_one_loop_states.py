"""Margins of loops given by states: mixed, undriven, cancelling, badly scaled."""

import control
import numpy as np
import pytest
from one_loops import STABLE_RANDOM, S, delayed_pid, exact_pid, pid_loop, stable_random_margins

from jounce.analysis.margins import loop_margins


def test_integrators_hidden_by_a_change_of_states_stay_at_zero():
    """Rounding would split a triple integrator into poles near 1e-5, and limit the gain at DC."""
    rng = np.random.default_rng(7)
    loop = control.ss(pid_loop(*exact_pid()))
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    turned = control.ss(turn @ loop.A @ turn.T, turn @ loop.B, loop.C @ turn.T, 0)
    margins = loop_margins(turned)
    assert margins.phase_crossovers_hz == pytest.approx((0.4214465481280992,), rel=1e-12)
    assert margins.lower_gain_margin_db == pytest.approx(12, rel=1e-12)


def test_modes_that_cancel_count_in_stability_but_not_in_crossings():
    cancelling = control.ss((S + 2) / (S + 3)) * control.ss(1 / (S * (S + 2)))
    twice = control.ss(-np.eye(2), np.ones((2, 1)), np.ones((1, 2)), 0)
    apart = control.ss(np.diag([-1.0, -2.0]), [[1], [1]], [[1, -1]], 0)
    for loop, same in (
        (cancelling, 1 / (S * (S + 3))),
        (twice, 2 / (S + 1)),
        (apart, 1 / ((S + 1) * (S + 2))),
    ):
        margins, expected = loop_margins(loop), loop_margins(same)
        assert margins.crossovers_hz == pytest.approx(expected.crossovers_hz, rel=1e-12)
        assert margins.modulus_margin == pytest.approx(expected.modulus_margin, rel=1e-12)
        assert margins.phase_margin_deg == pytest.approx(expected.phase_margin_deg, rel=1e-12)
    assert np.min(abs(loop_margins(cancelling).closed_loop_poles + 2)) < 1e-12


def test_mixing_the_states_changes_nothing():
    """A turned companion form hides which coefficients were zero."""
    rng = np.random.default_rng(11)
    for loop in (5 / (S + 1) ** 3, delayed_pid(order=1), 0.3 * (S + 2) / (S * (S**2 + S + 4))):
        system = control.ss(loop)
        turn = np.linalg.qr(rng.standard_normal(system.A.shape))[0]
        turned = control.ss(turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T, system.D)
        margins, expected = loop_margins(turned), loop_margins(loop)
        for name in ("phase_margin_deg", "crossover_hz", "modulus_margin", "disk_margin"):
            assert getattr(margins, name) == pytest.approx(getattr(expected, name), rel=1e-9)
        assert margins.upper_gain_margin_db == pytest.approx(
            expected.upper_gain_margin_db, rel=1e-6
        )


def test_an_undriven_state_leaves_the_margins_alone():
    """Unscaled beside a companion form, such a state would drown its small coefficients."""
    for loop, expected in stable_random_margins()[:40]:
        system = control.ss(loop)
        zeros = np.zeros((system.nstates, 1))
        a = np.block([[system.A, zeros], [zeros.T, -np.ones((1, 1))]])
        b, c = np.vstack([system.B, [[0]]]), np.hstack([system.C, [[1]]])
        margins = loop_margins(control.ss(a, b, c, system.D))
        assert margins.modulus_margin == pytest.approx(expected.modulus_margin, rel=1e-7)
        assert margins.crossovers_hz == pytest.approx(expected.crossovers_hz, rel=1e-7)


def test_rounded_undamped_modes_do_not_count_as_phase_crossovers():
    system = control.ss((S**2 + 0.5) / (S * (S**2 + 1)))
    for seed in range(10):
        turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
        turned = control.ss(turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T, 0)
        margins = loop_margins(turned)
        assert not any(abs(2 * np.pi * hz - 1) < 1e-3 for hz in margins.phase_crossovers_hz)


def test_crossovers_of_badly_scaled_states_lie_on_the_unit_circle():
    loop = STABLE_RANDOM[83]
    system = control.ss(loop)
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal(system.A.shape))[0]
    a, b, c = turn @ system.A @ turn.T, turn @ system.B, system.C @ turn.T
    for hz in loop_margins(control.ss(a, b, c, 0)).crossovers_hz:
        value = c @ np.linalg.solve(2j * np.pi * hz * np.eye(len(a)) - a, b)
        assert abs(value[0, 0]) == pytest.approx(1, rel=1e-7)
