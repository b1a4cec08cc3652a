"""Several measurements of one axis: the worst of them, and whether they differ beyond noise."""

import numpy as np
import pytest
from measured_loops import complex_noise

from jounce.analysis import MeasuredResponse, repeated_margins
from jounce.plant import PID

LINES = np.arange(1.0, 80.0)
S = 2j * np.pi * LINES
LAW = PID(900.0, 0.0, 0.0)


def plant(inertia, seed):
    exact = 1 / (S * (inertia * S + 30.0))
    off = 1e-3 * abs(exact) * complex_noise(np.random.default_rng(seed), 79)
    return MeasuredResponse(LINES, exact + off, 1e-3 * abs(exact), kind="plant")


def test_the_worst_is_named_and_the_spread_stands_beside_the_noise():
    positions = {"left": plant(1.0, 0), "middle": plant(1.5, 1), "right": plant(0.8, 2)}
    found = repeated_margins(positions, LAW)
    assert found.stable
    where, value = found.worst("phase_margin_deg")
    assert where == "middle"
    assert value == min(each.phase_margin_deg for each in found.margins.values())
    assert found.worst("sensitivity_peak")[0] == "middle"
    spread, noise = found.spread("phase_margin_deg")
    assert spread > 10 * noise
    assert "phase_margin_deg" in str(found)
    days = repeated_margins({str(day): plant(1.0, day) for day in range(6)}, LAW)
    spread, noise = days.spread("phase_margin_deg")
    assert 0.3 * noise < spread < 3 * noise


def test_what_is_not_known_or_not_there_is_told():
    with pytest.raises(ValueError, match="no measurement"):
        repeated_margins({}, LAW)
    found = repeated_margins({"one": plant(1.0, 0)}, LAW)
    with pytest.raises(ValueError, match="'stable' is not known"):
        found.worst("stable")
    with pytest.raises(ValueError, match="was not measured in any"):
        found.worst("lower_gain_margin_db")
