"""The inertia: names, formulas, errors."""

from math import inf, nan

import control
import numpy as np
import pytest
from hypothesis import given
from strategies import MAGNITUDES, UNIT_FACTORS

from jounce.plant import Inertia


@given(magnitude=MAGNITUDES, unit=UNIT_FACTORS, omega=MAGNITUDES)
def test_both_forms_are_one_over_j_s_squared(magnitude, unit, omega):
    moment, s = magnitude * unit, 1j * omega
    plant = Inertia(moment)
    expected = 1.0 / (moment * s**2)
    position, rate = plant.system()(s)[:, 0]
    assert position == pytest.approx(expected, rel=1e-13), f"Inertia({moment!r}) at {s}"
    assert rate == pytest.approx(s * expected, rel=1e-13), f"Inertia({moment!r}) at {s}"
    assert plant.transfer()(s) == pytest.approx(expected, rel=1e-13), f"Inertia({moment!r}), {s}"


def test_signals_have_the_loops_names():
    system, transfer = Inertia(3.0).system(), Inertia(3.0).transfer()
    assert isinstance(system, control.StateSpace)
    assert isinstance(transfer, control.TransferFunction)
    assert (system.name, transfer.name) == ("plant", "plant")
    assert system.input_labels == transfer.input_labels == ["u"]
    assert system.output_labels == system.state_labels == ["y", "y_rate"]
    assert transfer.output_labels == ["y"]
    assert system.isctime(strict=True)


def test_a_constant_torque_accelerates_it():
    t = np.linspace(0.0, 4.0, 41)
    response = control.forced_response(Inertia(0.5).system(), t, np.full(41, 3.0))
    np.testing.assert_allclose(response.outputs, [3.0 * t**2, 6.0 * t], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("moment", [0.0, -1.0, nan, inf])
def test_an_inertia_that_is_not_positive_is_refused(moment):
    with pytest.raises(ValueError, match=f"J = {moment!r}: expected a positive, finite"):
        Inertia(moment)


def test_it_is_a_frozen_float():
    plant = Inertia(np.int64(2))
    assert type(plant.J) is float
    assert plant == Inertia(2.0)
    with pytest.raises(AttributeError):
        plant.J = 3.0
