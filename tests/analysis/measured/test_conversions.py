"""L, S, T and PS of one loop, made from one another with their error bars."""

import numpy as np
import pytest
from measured_loops import complex_noise

from jounce.analysis import MeasuredResponse, closed_responses, open_loop, plant_response
from jounce.plant import PID

LINES = np.arange(1.0, 60.0)
JW = 2j * np.pi * LINES
PLANT = 1 / (JW * (JW + 3))
LAW = PID(400.0, 300.0, 20.0, derivative_filter=1e-3)
C = LAW.transfer()(JW)
S = 1 / (1 + C * PLANT)
KINDS = {
    "plant": PLANT,
    "loop": C * PLANT,
    "sensitivity": S,
    "process-sensitivity": PLANT * S,
    "complementary": 1 - S,
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_gives_the_loop_and_its_error_bars(kind):
    rng = np.random.default_rng(0)
    sigma = 1e-5 * abs(KINDS[kind])
    controller = LAW if kind in ("plant", "process-sensitivity") else None
    repeats = [
        open_loop(
            MeasuredResponse(LINES, KINDS[kind] + sigma * complex_noise(rng, 59), sigma, kind=kind),
            controller,
        )
        for _ in range(200)
    ]
    off = np.array([each.response for each in repeats]) - C * PLANT
    assert np.sqrt((abs(off) ** 2).mean(axis=0)) == pytest.approx(repeats[0].sigma, rel=0.25)
    plant = plant_response(MeasuredResponse(LINES, KINDS[kind], kind=kind), LAW)
    assert plant.response == pytest.approx(PLANT)
    assert plant.kind == "plant"


def test_closed_responses_have_bands_and_limits():
    frf = MeasuredResponse(LINES, PLANT, 0.01 * abs(PLANT), kind="plant")
    both = closed_responses(frf, LAW)
    assert both.sensitivity == pytest.approx(S)
    assert both.sensitivity + both.complementary == pytest.approx(np.ones(59))
    low, high = both.band("sensitivity")
    assert (low < abs(S)).all()
    assert (abs(S) < high).all()
    peak = abs(S).max()
    assert both.above(0.99 * peak).tolist() == LINES[abs(S) > 0.99 * peak].tolist()
    with pytest.raises(ValueError, match="probability"):
        both.band(probability=1.0)
