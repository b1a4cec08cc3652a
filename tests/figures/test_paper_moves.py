"""Figures 1 to 6 of the paper carry its closed forms, read off the curves."""

from functools import cache
from math import pi, sqrt

import numpy as np
import pytest
from drawn import curves, motion, peak_of, switches, words
from figures import paper_moves
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jounce.plots.style import ORDER_COLORS

COLUMNS = {1: 2, 3: 4, 6: 2}


@cache
def figure(number: int) -> Figure:
    return getattr(paper_moves, f"figure_{number}")()


def column(number: int, index: int) -> list[Axes]:
    return figure(number).axes[index :: COLUMNS[number]]


# Figures 1 and 3: minimum-time moves


@pytest.mark.parametrize(
    ("index", "distance", "times", "velocity"),
    [(0, 0.5, [0.0, sqrt(0.5), sqrt(2.0)], sqrt(0.5)), (1, 2.0, [0.0, 1.0, 2.0, 3.0], 1.0)],
    ids=["V not reached", "V reached"],
)
def test_figure_1_has_the_closed_forms_of_section_2(index, distance, times, velocity):
    panels = column(1, index)
    assert peak_of(panels[0]) == pytest.approx(distance, rel=1e-12)
    assert peak_of(panels[1]) == pytest.approx(velocity, rel=1e-12)
    assert peak_of(panels[2]) == 1.0
    assert switches(panels[0]) == pytest.approx(times, abs=1e-12)
    assert motion(*curves(panels[2])[0]) == pytest.approx((0.0, times[-1]), abs=1e-12)
    assert f"T = {times[-1]:.4f} s" in panels[0].get_title()


def switches_of_section_3(case: int, distance: float, v: float, a: float, w: float) -> list[float]:
    t_w, t_v = a / w, (2.0 * sqrt(v / w) if case == 3 else a / w + v / a)
    if case == 1:
        end = (32.0 * distance / w) ** (1.0 / 3.0)
        return [0.0, end / 4.0, 3.0 * end / 4.0, end]
    if case == 2:
        end = t_w + sqrt(t_w**2 + 4.0 * distance / a)
        return [0.0, t_w, end / 2.0 - t_w, end / 2.0 + t_w, end - t_w, end]
    end = distance / v + t_v
    if case == 3:
        return [0.0, t_v / 2.0, t_v, end - t_v, end - t_v / 2.0, end]
    return [0.0, t_w, t_v - t_w, t_v, end - t_v, end - t_v + t_w, end - t_w, end]


@pytest.mark.parametrize(
    ("case", "distance", "bound", "velocity", "acceleration"),
    [
        (1, 0.4, 1.0, 2.0 * (6.4 ** (1.0 / 3.0) / 4.0) ** 2, 2.0 * 6.4 ** (1.0 / 3.0) / 4.0),
        (2, 1.0, 1.0, (0.5 + sqrt(4.25)) / 2.0 - 0.5, 1.0),
        (3, 2.0, 2.0, 1.0, sqrt(2.0)),
        (4, 2.0, 1.0, 1.0, 1.0),
    ],
    ids=["neither", "A", "V", "both"],
)
def test_figure_3_has_the_closed_forms_of_section_3(case, distance, bound, velocity, acceleration):
    panels = column(3, case - 1)
    peaks = [peak_of(ax) for ax in panels]
    assert peaks == pytest.approx([distance, velocity, acceleration, 2.0], rel=1e-4)
    times = switches_of_section_3(case, distance, 1.0, bound, 2.0)
    for ax in panels:
        assert switches(ax) == pytest.approx(times, abs=1e-12)
    assert motion(*curves(panels[3])[0]) == pytest.approx((0.0, times[-1]), abs=1e-12)
    assert f"T = {times[-1]:.4f} s" in panels[0].get_title()


# Figure 2: following


def test_figure_2_keeps_its_limits_and_comes_to_rest_at_the_command():
    position, velocity, acceleration, _ = figure(2).axes
    [steps] = position.patches
    assert set(steps.get_data().values) == {4.0, 10.0, 2.0}
    assert peak_of(velocity) == pytest.approx(2.0, rel=1e-9)
    assert peak_of(acceleration) == pytest.approx(1.0, rel=1e-9)
    [(time, response)] = curves(position)
    assert response[-1] == pytest.approx(2.0, abs=1e-9)
    assert np.abs(response[(time > 4.0) & (time < 5.0)] - 4.0).max() < 1e-9
    assert response[time > 9.5].min() > 2.0 - 1e-9


def test_figure_2_brakes_along_the_parabola():
    plane = figure(2).axes[3]
    parabolas = [line.get_data() for line in plane.lines if line.get_linestyle() == ":"]
    assert len(parabolas) == 3
    time = curves(figure(2).axes[0])[0][0]
    x, v = next(line.get_data() for line in plane.lines if len(line.get_xdata()) == len(time))
    braking = (time > 13.0) & (time < 15.0)
    np.testing.assert_allclose(v[braking] ** 2, 2.0 * (x[braking] - 2.0), atol=1e-9)
    drawn = parabolas[0]  # of the lowest command
    np.testing.assert_allclose(np.interp(v[braking], drawn[1], drawn[0]), x[braking], atol=1e-4)


# Figures 4 and 6: higher derivatives

PEAKS = {
    4: [(2.0 - sqrt(2.0)) / 96.0, 0.0214466, 0.2071068],
    5: [4.205065e-4, 1.691704e-3, 0.01475425, 0.1545085],
    6: [2.297433e-5, 9.931350e-5, 1.0216272e-3, 8.974596e-3, 0.1339746],
}
BOUNDS = {4: 384.0, 5: 6144.0, 6: 122880.0}


@pytest.mark.parametrize("order", BOUNDS)
def test_figure_4_has_the_bounds_peaks_and_switches_of_section_4(order):
    panels = {ax.get_ylabel().split("\n")[0]: ax for ax in figure(4).axes if ax.axison}
    names = ["position", "velocity", "acceleration", "jerk", "snap", "crackle", "pop"]
    color = ORDER_COLORS[order]
    drawn = [
        line.get_data()
        for name in names
        for line in panels[name].lines
        if line.get_color() == color
    ]
    assert len(drawn) == order + 1
    peaks = [float(np.abs(values).max()) for _, values in drawn]
    expected = [1.0, *(c * BOUNDS[order] for c in PEAKS[order]), BOUNDS[order]]
    assert peaks == pytest.approx(expected, rel=2e-4)
    time, highest = drawn[-1]
    jumps = time[np.flatnonzero(np.diff(highest))]
    instants = np.sin(np.arange(order + 1) * pi / (2.0 * order)) ** 2
    assert jumps == pytest.approx(instants, abs=1e-12)
    [key] = [ax for ax in figure(4).axes if not ax.axison]
    handle = next(h for h in key.get_legend().legend_handles if h.get_color() == color)
    assert f"±{BOUNDS[order]:,.0f} R/T" in words(key)[key.get_legend().legend_handles.index(handle)]


@pytest.mark.parametrize(
    ("order", "bound", "kappa"), [(4, 0.8, 1 / 6), (5, 6.4, 0.1850197375), (6, 76.8, 0.2029223745)]
)
def test_figure_6_has_the_rise_time_and_durations_of_longer_moves(order, bound, kappa):
    ramp = (0.2 / bound) ** (1.0 / (order - 2))
    without_cruise = 1.0 + 2.0 * sqrt(kappa * ramp**2 + 2.0 / 0.2)
    with_cruise = 2.0 / 0.4 + 0.4 / 0.2 + 1.0
    for index, duration in enumerate([without_cruise, with_cruise]):
        panels = column(6, index)
        line = next(h for h in panels[2].lines if h.get_color() == ORDER_COLORS[order])
        time, acceleration = line.get_data()
        full = time[np.flatnonzero(acceleration > 0.2 * (1.0 - 1e-12))[0]]
        assert full == pytest.approx(1.0, abs=1e-9)
        assert acceleration.max() == pytest.approx(0.2, rel=1e-12)
        assert motion(time, acceleration)[1] == pytest.approx(duration, rel=2e-3, abs=0.0)
        assert f"±{bound} deg/s" in words(panels[0])[order - 4]
        assert f"T = {duration:.3f} s" in words(panels[0])[order - 4]


def test_figure_6_bounds_pop_by_76_8_and_velocity_in_one_column():
    for index in (0, 1):
        assert peak_of(column(6, index)[4]) == pytest.approx(76.8, rel=1e-12)
    for index, highest in enumerate([0.6, 0.4]):
        for _, velocity in curves(column(6, index)[1]):
            assert velocity.max() == pytest.approx(highest, rel=0.03)
            assert index == 0 or velocity.max() <= 0.4 * (1.0 + 1e-12)
