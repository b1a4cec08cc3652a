"""What pictures have in common: times on both sides of jumps, units, text taken literally."""

import numpy as np
import pytest
from matplotlib.colors import is_color_like
from matplotlib.figure import Figure

from jounce.plots import style
from jounce.shaping import Limits, Trajectory, min_time_move, perfect_spline


@pytest.mark.parametrize("order", [1, 3, 10])
def test_curve_times_have_both_sides_of_every_jump(order):
    move = perfect_spline(1.0, order, 1.0).delay(3.0)
    time = style.curve_times(move)
    assert time[[0, -1]].tolist() == [move.start_time, move.end_time]
    assert (np.diff(time) > 0.0).all()
    assert len(time) >= style.CURVE_POINTS
    highest = move(time, order)
    for switch in move.switch_times[1:-1]:
        at = np.flatnonzero(time == switch)[0]
        assert highest[at - 1] == -highest[at] != 0.0


def test_curve_times_of_a_point_and_of_many_pieces():
    assert style.curve_times(min_time_move(0.0, Limits(jerk=1.0))).tolist() == [0.0]
    pieces = 1000
    states = np.zeros((pieces, 3))
    time = style.curve_times(Trajectory(np.arange(pieces + 1.0), states))
    assert len(time) == 8 * pieces + 1


def test_rest_is_drawn_before_and_after():
    move = min_time_move(4.0, Limits(acceleration=1.0)).delay(-1.0)
    time = style.with_rest(move)
    assert time[[0, -1]] == pytest.approx([-1.2, 3.2])
    acceleration = move(time, "acceleration")
    assert acceleration[[0, 1, -1]].tolist() == [0.0, 0.0, 0.0]
    assert acceleration[2] == 1.0
    assert time[1] == pytest.approx(time[2], abs=1e-15)
    assert move(time)[[0, 1, -1]] == pytest.approx([0.0, 0.0, 4.0])


@pytest.mark.parametrize(
    ("unit", "k", "expected"),
    [
        ("deg", 0, "\n[deg]"),
        ("deg", 1, "\n[deg/s]"),
        ("mm", 2, "\n[mm/s²]"),
        ("R", 10, "\n[R/s¹⁰]"),
        ("", 3, ""),
    ],
)
def test_units_of_derivatives(unit, k, expected):
    assert style.unit_label(unit, "s", k) == expected


def test_text_between_dollars_is_no_mathematics():
    assert style.plain("costs $5 or $6") == r"costs \$5 or \$6"


def test_an_axes_is_finished_with_title_labels_and_grid():
    ax = Figure().subplots()
    assert style.finish(ax, "title", "time [s]", "gain [dB]") is ax
    assert (ax.get_title(), ax.get_xlabel(), ax.get_ylabel()) == ("title", "time [s]", "gain [dB]")
    assert any(line.get_visible() for line in ax.get_xgridlines())


def test_colours_are_colours_and_differ():
    colors = list(style.ORDER_COLORS.values())
    assert len(set(colors)) == len(colors) == 5
    assert all(map(is_color_like, [*colors, style.GREY]))
