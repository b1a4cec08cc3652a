"""Figures 7 to 10 of the paper: the filter's, the spectra's and the loop's published numbers."""

from dataclasses import replace
from functools import cache
from math import factorial, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from drawn import curves, motion
from figures import paper_loops
from matplotlib.figure import Figure
from scipy.integrate import quad
from scipy.stats import gamma

from jounce.app import load_scenario
from jounce.shaping import perfect_spline

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def figure(number: int) -> Figure:
    return getattr(paper_loops, f"figure_{number}")()


# Figures 7 and 8: filters


def test_figure_7_has_a_step_response_within_1_percent_from_1_0431_s():
    ax = figure(7).axes[0]
    [(time, response)] = curves(ax)
    np.testing.assert_allclose(response, gamma.cdf(time, 6, scale=1.0 / (4.0 * pi)), atol=1e-12)
    assert response.max() <= 1.0
    assert np.interp(0.99, response[:300], time[:300]) == pytest.approx(1.0431, abs=5e-5)
    [mark] = [line.get_data() for line in ax.lines if line.get_marker() == "o"]
    assert np.ravel(mark) == pytest.approx([1.0431, 0.99], abs=5e-5)
    assert any("1.0431 s" in text.get_text() for text in ax.texts)


def test_figure_7_bounds_the_jerk_of_an_acceleration_limited_move():
    _, position, acceleration, jerk = figure(7).axes
    before, after = curves(acceleration)
    assert np.abs(before[1]).max() == pytest.approx(0.2)
    assert motion(*before) == pytest.approx((0.0, 2.0 * sqrt(1.0 / 0.2)), abs=1e-12)
    assert np.abs(after[1]).max() < 0.2
    steepest = 4.0 * pi * 5.0**5 * np.exp(-5.0) / factorial(5)  # of the step response
    [(_, values)] = curves(jerk)
    assert values.max() == pytest.approx(0.2 * steepest, rel=1e-3)
    assert values.min() == pytest.approx(-0.4 * steepest, rel=1e-3)
    (time, command), (later, filtered) = curves(position)
    half = np.interp(0.5, filtered, later) - np.interp(0.5, command, time)
    assert half == pytest.approx(6.0 / (4.0 * pi), abs=0.01)


def gain_by_quadrature(order: int, frequency: float) -> float:
    spline = perfect_spline(1.0, order, 1.0)
    spline = spline.stretch(1.0 / spline.duration)
    value, _ = quad(
        lambda t: float(spline(t, "velocity")) * np.cos(2.0 * pi * frequency * (t - 0.5)), 0.0, 1.0
    )
    return abs(value)


def gains() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {line.get_label(): line.get_data() for line in figure(8).axes[0].lines}


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_figure_8_has_the_corner_of_each_order(order):
    [(label, (frequency, gain))] = [
        item for item in gains().items() if f"order {order}:" in item[0]
    ]
    assert f"then {20 * order} dB/decade" in label
    first = np.flatnonzero(gain < -40.0)[0]
    corner = float(np.interp(3.0103, -gain[:first], frequency[:first]))
    assert f"{corner:.3f} Hz" in label
    assert gain_by_quadrature(order, corner) == pytest.approx(sqrt(0.5), abs=1e-4)
    for at in (0.5, 3.7, 11.0):
        drawn = 10.0 ** (np.interp(at, frequency, gain) / 20.0)
        assert drawn == pytest.approx(gain_by_quadrature(order, at), abs=2e-4)


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_figure_8_rolls_off_under_the_envelope_of_each_order(order):
    """The jumps of derivative n add up to 2nD: |H| ≤ 2nD/(R·ωⁿ)."""
    [(frequency, gain)] = [data for name, data in gains().items() if f"order {order}:" in name]
    bound = factorial(order - 1) * 4.0 ** (order - 1)
    envelope = 20.0 * np.log10(2.0 * order * bound / (2.0 * pi * frequency) ** order)
    below = (envelope - gain)[frequency > 3.0]
    assert below.min() >= -1e-6
    for part in np.array_split(below, 3):
        assert part.min() < 12.0


def test_figure_8_has_the_nulls_of_a_triangle_and_the_filter_beside():
    label, (frequency, gain) = next(iter(gains().items()))
    assert label.startswith("order 2")
    for null in (2.0, 4.0, 6.0, 8.0):
        near = np.abs(frequency / null - 1.0) < 0.005
        assert gain[near].min() < -100.0
    label, (frequency, gain) = list(gains().items())[-1]
    corner = 2.0 * sqrt(2.0 ** (1.0 / 6.0) - 1.0)
    assert f"{corner:.3f} Hz, then 120 dB/decade" in label
    expected = -60.0 * np.log10(1.0 + (frequency / 2.0) ** 2)
    np.testing.assert_allclose(gain, expected, atol=1e-9)
    falls = np.interp(3.0103, -gain, frequency)
    assert falls == pytest.approx(corner, rel=1e-4)


# Figure 10: the loop


def test_figure_10_has_the_margins_of_section_7_and_40_percent_of_overshoot():
    gain, nichols, step, phase, _, move = figure(10).axes
    texts = [text.get_text() for ax in (gain, phase, step) for text in ax.texts]
    for fact in ("crossover 1 Hz", "12 dB", "45°", "39.85 %"):
        assert any(fact in text for text in texts)
    frequency, level = gain.lines[0].get_data()
    assert np.interp(1.0, frequency, level) == pytest.approx(0.0, abs=0.01)
    turned, height = nichols.lines[0].get_data()
    assert np.interp(-180.0, turned, height) == pytest.approx(12.0, abs=0.05)
    assert np.interp(-135.0, turned, height) == pytest.approx(0.0, abs=0.05)
    assert step.lines[0].get_ydata().max() == pytest.approx(1.40, abs=0.005)
    assert all(line.get_ydata()[-1] == pytest.approx(60.0, abs=0.05) for line in move.lines)
    assert [line.get_ydata().max() > 61.0 for line in move.lines] == [False, False, True, False]


def test_figure_10_surveys_the_example_of_the_telescope():
    example = load_scenario(EXAMPLES / "telescope.toml")
    drawn = paper_loops._telescope()
    moves = tuple(
        replace(move, distance=own.distance, settle_to=own.settle_to)
        for move, own in zip(example.moves, drawn.moves, strict=False)
    )
    assert drawn == replace(example, path=drawn.path, moves=moves, modes=())
    assert drawn.moves[0].distance == pytest.approx(example.moves[0].distance, rel=1e-14)
    assert drawn.moves[0].settle_to == pytest.approx(example.moves[0].settle_to, rel=1e-14)
