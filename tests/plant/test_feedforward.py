"""The inertia feedforward: names, formulas, errors."""

from math import inf, nan

import control
import pytest

from jounce.plant import InertiaFeedforward


@pytest.mark.parametrize("estimate", [0.0, 1e-9, 2.5, 7e8])
@pytest.mark.parametrize("omega", [1e-3, 1.0, 400.0])
def test_both_forms_are_j_hat_times_the_acceleration(estimate, omega):
    feedforward, s = InertiaFeedforward(estimate), 1j * omega
    assert feedforward.transfer()(s) == pytest.approx(estimate * s**2, rel=1e-14)
    assert feedforward.system()(s) * s**2 == pytest.approx(estimate * s**2, rel=1e-14)


def test_signals_have_the_loops_names():
    system, transfer = InertiaFeedforward(1.0).system(), InertiaFeedforward(1.0).transfer()
    assert isinstance(system, control.StateSpace)
    assert system.nstates == 0
    assert system.input_labels == ["r_acceleration"]
    assert transfer.input_labels == ["r"]
    assert system.output_labels == transfer.output_labels == ["u_feedforward"]
    assert (system.name, transfer.name) == ("feedforward", "feedforward")


@pytest.mark.parametrize(
    ("estimate", "expected"),
    [(-1e-3, "a number ≥ 0"), (nan, "a finite"), (inf, "a finite"), (-inf, "a finite")],
)
def test_an_estimate_that_is_negative_or_not_finite_is_refused(estimate, expected):
    with pytest.raises(ValueError, match=f"J_hat = {estimate!r}: expected {expected}"):
        InertiaFeedforward(estimate)


def test_it_is_a_frozen_float():
    feedforward = InertiaFeedforward(2)
    assert type(feedforward.J_hat) is float
    assert feedforward == InertiaFeedforward(2.0)
    with pytest.raises(AttributeError):
        feedforward.J_hat = 3.0
