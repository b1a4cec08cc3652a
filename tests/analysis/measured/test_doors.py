"""What needs a response in time says so of measured data, and names what takes them."""

import numpy as np
import pytest

from jounce.analysis import MeasuredResponse
from jounce.plant import PID, Inertia, ServoLoop, zero_order_hold

LINES = np.arange(1.0, 40.0)
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


def test_models_are_taken_as_before():
    assert ServoLoop(Inertia(1.0), PID(1.0, 0.0, 1.0)).axis.J == 1.0
    with pytest.raises(TypeError, match="expected Inertia, FlexibleInertia"):
        ServoLoop(3.0, PID(1.0, 0.0, 1.0))
