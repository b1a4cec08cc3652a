"""Sensitivity curves of shapers and moves on one scale."""

from math import asin, pi, sqrt

import numpy as np
import pytest

from jounce.analysis import residual_vibration, sensitivity_of_shapers
from jounce.shaping import Limits, Trajectory, input_shaper, min_time_move

MOVE = min_time_move(-2.0, Limits(velocity=2.0, acceleration=4.0, jerk=20.0))


def test_shapers_and_moves_are_on_one_scale():
    """A shaper on a very fast move is that shaper; a shaped move is the product."""
    zv = input_shaper("ZV", 3.0, 0.02)
    fast = min_time_move(1.0, Limits(jerk=1e13))
    curves = sensitivity_of_shapers(
        {"ZV": zv, "shaped step": zv.shape(fast), "move": MOVE, "shaped": zv.shape(MOVE)},
        *(3.0, 0.02),
        ratios=[0.7, 0.9, 1.0, 1.2],
    )
    assert curves.residual.shape == (4, 4)
    np.testing.assert_allclose(curves.residual[1], curves.residual[0], atol=1e-3)
    np.testing.assert_allclose(
        curves.residual[3], curves.residual[0] * curves.residual[2], atol=1e-13
    )
    np.testing.assert_allclose(
        curves.residual[2], residual_vibration(MOVE, 3.0 * curves.ratios, 0.02) / 2.0
    )
    assert curves.durations[0] == zv.duration
    assert curves.names == ("ZV", "shaped step", "move", "shaped")


def test_insensitivity_is_that_of_the_closed_forms():
    """Undamped, ZV leaves |cos(πr/2)|, and each derivative one factor of it more."""
    kinds = {kind: input_shaper(kind, 5.0) for kind in ("ZV", "ZVD", "ZVDD")}
    curves = sensitivity_of_shapers(kinds, 5.0, ratios=np.linspace(0.2, 1.8, 3201))
    expected = [4 / pi * asin(0.05 ** (1 / n)) for n in (1, 2, 3)]
    np.testing.assert_allclose(curves.insensitivity(0.05), expected, rtol=1e-5)
    ei = sensitivity_of_shapers({"EI": input_shaper("EI", 5.0)}, 5.0)
    assert ei.insensitivity(0.05)[0] == pytest.approx(0.399, abs=1e-3)
    assert ei.insensitivity(0.04)[0] == 0.0
    assert ei.insensitivity(10.0)[0] == 1.0


def test_it_is_drawn_and_shown():
    curves = sensitivity_of_shapers({"ZV": input_shaper("ZV", 5.0), "move": MOVE}, 5.0, 0.01)
    ax = curves.plot()
    assert len(ax.lines) == 3
    assert "ZV, 0.1" in ax.get_legend().get_texts()[0].get_text()
    assert repr(curves) == "ShaperSensitivity(ZV, move; frequency_hz=5.0, damping=0.01)"
    assert sqrt(curves.ratios[0] + curves.ratios[-1]) == pytest.approx(sqrt(2.0))


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: sensitivity_of_shapers({}, 5.0), "shapers = {}: expected"),
        (lambda: sensitivity_of_shapers([MOVE], 5.0), "expected a mapping of names"),
        (lambda: sensitivity_of_shapers({"x": 3}, 5.0), r"shapers\['x'\] = 3: expected a Traj"),
        (lambda: sensitivity_of_shapers({"m": MOVE}, 5.0, ratios=[1.0, 0.5]), "that increase"),
        (
            lambda: sensitivity_of_shapers({"m": Trajectory([0.0, 1.0], [[1.0, 0.0, 0.0]])}, 5.0),
            "goes nowhere",
        ),
    ],
)
def test_what_has_no_curve_gets_one_line(ask, words):
    with pytest.raises((TypeError, ValueError), match=words):
        ask()
