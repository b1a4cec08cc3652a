"""What needs a response in time says so of measured data, and names what takes them."""

import numpy as np
import pytest

from jounce.analysis import (
    MeasuredResponse,
    closed_responses,
    fit_axis,
    loop_margins,
    measured_survey,
    open_loop,
    repeated_margins,
)
from jounce.plant import PID, Inertia, ServoLoop, zero_order_hold

LINES = np.arange(1.0, 40.0)
LAW = PID(1000.0, 0.0, 60.0)
FRF = MeasuredResponse(LINES, 1 / LINES**2, kind="plant")


@pytest.mark.parametrize("data", [FRF, FRF.to_frd()], ids=["measured", "python-control"])
@pytest.mark.parametrize(
    "door",
    [lambda plant: ServoLoop(plant, PID(1.0, 0.0, 1.0)), lambda p: zero_order_hold(p, 0.1)],
    ids=["servo loop", "hold"],
)
def test_data_are_refused_with_a_remedy(data, door):
    with pytest.raises(TypeError, match=r"analysis\.fit_axis\(frf\)\.axis"):
        door(data)


@pytest.mark.parametrize(
    "of",
    [
        lambda data: loop_margins(data, controller=LAW).phase_margin_deg,
        lambda data: open_loop(data, LAW).response,
        lambda data: closed_responses(data, LAW).sensitivity,
        lambda data: repeated_margins({"one": data}, LAW).worst("phase_margin_deg")[1],
        lambda data: measured_survey(data, LAW).margins.phase_margin_deg,
        lambda data: fit_axis(data, modes=0, delay=0.0).axis.J,
    ],
    ids=["margins", "loop", "closed", "repeated", "survey", "fit"],
)
def test_python_controls_data_are_taken_for_a_plant(of):
    mass = MeasuredResponse(LINES, -1 / (2 * np.pi * LINES) ** 2, kind="plant")
    assert of(mass.to_frd()) == pytest.approx(of(mass))


@pytest.mark.parametrize("take", [open_loop, closed_responses, fit_axis, measured_survey])
def test_what_is_no_data_is_told(take):
    with pytest.raises(TypeError, match=r"measured = 3.0: expected a MeasuredResponse or a"):
        take(3.0)


def test_models_are_taken_as_before():
    assert ServoLoop(Inertia(1.0), PID(1.0, 0.0, 1.0)).axis.J == 1.0
    with pytest.raises(TypeError, match="expected Inertia, FlexibleInertia"):
        ServoLoop(3.0, PID(1.0, 0.0, 1.0))
