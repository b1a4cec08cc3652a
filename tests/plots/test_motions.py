"""Pictures of motions: labelled, with units, and of the data that they are given."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from tiers import some

from jounce.plots import motions as plots
from jounce.shaping import (
    CommandFollower,
    FollowerResponse,
    Limits,
    Trajectory,
    min_jerk_move,
    min_time_move,
)
from jounce.shaping.optimal.binding import BINDING_RTOL
from jounce.shaping.recursive_s_curve import recursive_s_curve

COMMANDS = [0.0, 1.0, 1.0, 1.0, 1.0, -2.0, -2.0, -2.0, 0.5, 0.5, 0.5, 0.5]


@pytest.fixture
def ax() -> Axes:
    return Figure().subplots()


@pytest.fixture(params=[2, 3], ids=["order 2", "order 3"])
def response(request) -> FollowerResponse:
    limits = Limits.from_bounds([1.0, 2.0, 8.0][: request.param])
    return CommandFollower(limits, dt=0.25).run(COMMANDS)


def render(figure: Figure) -> None:
    FigureCanvasAgg(figure).draw()


def legend(ax: Axes) -> list[str]:
    return [text.get_text() for text in ax.legend().get_texts()]


# A trajectory and its derivatives


def test_limits_are_drawn_where_they_hold_the_motion_back():
    """A seven-piece move: jerk, acceleration, jerk, velocity, jerk, acceleration, jerk."""
    limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    move = min_time_move(1.0, limits)
    _, velocity, acceleration, jerk = plots.plot_trajectory(move, limits=limits, scale=0.5).axes
    assert [len(ax.patches) for ax in (velocity, acceleration, jerk)] == [1, 2, 4]
    cruise = velocity.patches[0]
    assert [cruise.get_x(), cruise.get_x() + cruise.get_width()] == pytest.approx(
        move.breaks[3:5].tolist()
    )
    dashed = [
        [y.get_ydata()[0] for y in ax.lines if y.get_linestyle() == "--"]
        for ax in (velocity, acceleration, jerk)
    ]
    assert dashed == [[4.0], [-20.0, 20.0], [-200.0, 200.0]]


def bands(figure: Figure) -> list[list[tuple[float, float]]]:
    """Return start and end of the colour bands of each panel."""
    return [[(b.get_x(), b.get_x() + b.get_width()) for b in ax.patches] for ax in figure.axes]


@pytest.mark.parametrize("distance", [1.0, -1.0])
def test_without_limits_the_bands_are_where_a_derivative_stays_at_its_peak(distance):
    """Of a move whose bounds are all reached these are the bands of its limits."""
    limits = Limits(velocity=2.0, acceleration=10.0, jerk=100.0)
    move = min_time_move(distance, limits)
    found = move.plot()
    assert bands(found) == bands(move.plot(limits))
    assert [len(panel) for panel in bands(found)] == [0, 1, 2, 4]
    assert [len(ax.lines) for ax in found.axes] < [len(ax.lines) for ax in move.plot(limits).axes]
    assert bands(min_time_move(0.0, limits).plot()) == [[], [], [], []]


def thick(ax: Axes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return times and values of the thick curves of a panel."""
    return [
        (line.get_xdata()[at], line.get_ydata()[at])
        for line in ax.lines
        if line.get_color() == plots.ORANGE and line.get_linewidth() > 2.0
        for at in [np.isfinite(line.get_ydata())]
    ]


def many_pieces() -> tuple[Trajectory, Limits]:
    limits = Limits(1.5, 6.0, 60.0, 700.0, 1e4, 1.5e5)
    return recursive_s_curve(1.0, limits), limits


CURVES = {
    "seven pieces": lambda: (
        min_time_move(1.0, Limits(2.0, 10.0, 100.0)),
        Limits(2.0, 10.0, 100.0),
    ),
    "backwards": lambda: (min_time_move(-1.0, Limits(9.0, (-2.0, 1.0))), Limits(9.0, (-2.0, 1.0))),
    "optimal": lambda: (
        min_time_move(1.0, Limits(1.3, 9.0, snap=900.0)),
        Limits(1.3, 9.0, snap=900.0),
    ),
    "many pieces": many_pieces,
    "only touches": lambda: (min_jerk_move(1.0, duration=1.0), Limits(1.875, 5.7735, 60.0)),
}


@pytest.mark.parametrize("name", CURVES)
def test_a_curve_is_thick_where_and_only_where_it_is_at_a_bound(name):
    move, limits = CURVES[name]()
    panels = move.plot(limits, scale=0.5).axes
    assert thick(panels[0]) == []
    for k, ax in enumerate(panels[1:], start=1):
        bounds, extremes, drawn = limits.bounds(k), move.extremes(k), thick(ax)
        near = [bound * (1.0 - BINDING_RTOL) for bound in bounds]
        reached = [extremes[0] <= near[0], extremes[1] >= near[1]]
        assert len(drawn) == sum(reached), f"{name}, derivative {k}"
        for time, values in drawn:
            np.testing.assert_allclose(0.5 * values, move(time, k), rtol=1e-13)
            low, high = 0.5 * values.min(), 0.5 * values.max()
            assert high <= near[0] or low >= near[1], f"{name}, derivative {k}"
        grid = np.linspace(move.start_time, move.end_time, 5000)
        at = grid[(move(grid, k) <= near[0]) | (move(grid, k) >= near[1])]
        times = np.concatenate([[-np.inf], *(time for time, _ in drawn)])
        gaps = [np.abs(times - t).min() for t in at]
        assert max(gaps, default=0.0) <= 1e-2 * move.duration, f"{name}, derivative {k}"


def test_a_touch_shows():
    """The polynomial of least jerk meets its greatest velocity for an instant only, halfway."""
    limits = Limits(velocity=1.875)
    velocity = min_jerk_move(1.0, duration=1.0).plot(limits).axes[1]
    [(time, _)] = thick(velocity)
    assert len(velocity.patches) == 0
    assert 0.48 < time.min() < 0.5 < time.max() < 0.52


def test_a_single_sample_at_a_bound_is_a_dot():
    """A triangle in acceleration: its tip is at the bound at one break only."""
    jerk = 1e6
    move = min_time_move(1.0, Limits(jerk=jerk))
    limits = Limits(acceleration=move.peak("acceleration") / (1.0 - BINDING_RTOL * (1.0 - 1e-9)))
    figure = move.plot(limits)
    tips = [line for line in figure.axes[2].lines if line.get_linewidth() > 2.0]
    assert len(tips) == 2
    for line in tips:
        [start] = line.get_markevery()
        assert np.isfinite(line.get_ydata()[start])
        assert line.get_marker() == "o"
    render(figure)


def test_without_limits_no_peak_is_marked_as_a_bound():
    move, _ = many_pieces()
    assert [thick(ax) for ax in move.plot().axes] == [[]] * 7


@pytest.mark.parametrize("limits", ["x", 3.0, (1.0, 2.0), {"jerk": 1.0}], ids=str)
def test_limits_of_another_kind_are_refused(limits):
    move = min_time_move(1.0, Limits(jerk=1.0))
    for plot in (move.plot, lambda limits: plots.plot_trajectory(move, limits=limits)):
        with pytest.raises(TypeError, match=r"^limits = .*: expected Limits, such as Limits"):
            plot(limits)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_a_scale_that_is_not_positive_is_refused(scale):
    with pytest.raises(ValueError, match=f"^scale = {scale}: expected a positive"):
        min_time_move(1.0, Limits(jerk=1.0)).plot(scale=scale)


@pytest.mark.parametrize("limits", [None, Limits(jerk=1.0)], ids=["free", "limits"])
def test_a_point_is_a_dot_in_every_panel(limits):
    figure = min_time_move(0.0, Limits(jerk=1.0), start=3.0).plot(limits)
    for ax, value in zip(figure.axes, [3.0, 0.0, 0.0, 0.0], strict=True):
        [dot] = [line for line in ax.lines if line.get_marker() == "o"]
        assert [list(values) for values in dot.get_data()] == [[0.0], [value]]
    render(figure)


def test_a_trajectory_draws_itself_with_units():
    figure = min_time_move(1.0, Limits(acceleration=1.0)).plot(unit="deg", time_unit="min", scale=2)
    assert figure.axes[2].get_ylabel() == "acceleration\n[deg/min²]"
    assert max(figure.axes[0].lines[0].get_ydata()) == pytest.approx(0.5)


@pytest.mark.parametrize("order", some([1, 2, 3, 6, 10], 3))
def test_trajectories(order):
    limits = Limits.from_bounds([*[None] * (order - 1), 4.0**order])
    move = min_time_move(-2.0, limits, start=1.0)
    figure = plots.plot_trajectory(move, unit="mm", scale=0.5)
    assert isinstance(figure, Figure)
    assert len(figure.axes) == order + 1
    assert figure.axes[0].get_ylabel() == "position\n[mm]"
    assert figure.axes[1].get_ylabel() == "velocity\n[mm/s]"
    assert figure.axes[-1].get_xlabel() == "time [s]"
    if order >= 2:
        assert "[mm/s²]" in figure.axes[2].get_ylabel()
    if order == 10:
        assert "[mm/s¹⁰]" in figure.axes[10].get_ylabel()
    time, position = figure.axes[0].lines[0].get_data()
    assert position[[0, -1]] == pytest.approx([2.0, -2.0])
    assert time[[0, -1]] == pytest.approx([0.0, move.duration])
    for k, ax in enumerate(figure.axes):
        values = ax.lines[0].get_ydata()
        if k > 0:
            assert np.abs(values).max() == pytest.approx(move.peak(k) / 0.5, rel=1e-2)
    if order == 2:
        render(figure)


def test_the_jumps_of_the_highest_derivative_are_upright():
    move = min_time_move(1.0, Limits(jerk=32.0))
    time, jerk = plots.plot_trajectory(move, unit="m").axes[-1].lines[0].get_data()
    for switch in move.switch_times[1:-1]:
        near = np.flatnonzero(np.abs(time - switch) < 1e-12)
        assert sorted(jerk[near]) == pytest.approx([-32.0, 32.0])


def test_a_trajectory_without_a_unit_or_motion():
    for distance in (1.0, 0.0):
        figure = plots.plot_trajectory(min_time_move(distance, Limits(acceleration=1.0)))
        assert "[]" not in figure.axes[0].get_ylabel()
        render(figure)


def test_switches_are_marked():
    move = min_time_move(10.0, Limits(1.0, 1.0))
    for ax in plots.plot_trajectory(move, time_unit="min").axes:
        marks = [line.get_xdata()[0] for line in ax.lines[1:]]
        assert marks == move.switch_times.tolist() == [0.0, 1.0, 10.0, 11.0]
    assert ax.get_xlabel() == "time [min]"


# Several motions


@pytest.mark.parametrize(
    ("derivative", "label"),
    [(0, "position\n[deg]"), (1, "velocity\n[deg/s]"), (3, "jerk\n[deg/s³]")],
)
def test_motions_are_drawn_by_name(ax, derivative, label):
    motions = {f"{n} deg": min_time_move(float(n), Limits(1.0, 1.0, 4.0)) for n in range(1, 7)}
    assert plots.plot_motions(motions, derivative, ax=ax, unit="deg") is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", label)
    assert legend(ax) == list(motions)
    assert len({line.get_linestyle() for line in ax.lines[:4]}) == 4
    for line, motion in zip(ax.lines, motions.values(), strict=True):
        time, values = line.get_data()
        np.testing.assert_array_equal(values, motion(time, derivative))
        assert time[[0, -1]].tolist() == [0.0, motion.end_time]
        assert values.max() == pytest.approx(motion.extremes(derivative)[1], rel=1e-3)
    render(ax.figure)


def test_the_jumps_of_motions_are_upright(ax):
    """Both sides of each break are drawn, next to each other."""
    motion = Trajectory([1.0, 2.0, 4.0], [[0.0, 1.0, 3.0], [7.0, -2.0, -5.0]])
    for derivative, (before, after) in enumerate([(2.5, 7.0), (4.0, -2.0), (3.0, -5.0)]):
        plots.plot_motions({"m": motion}, derivative, ax=ax, time_unit="min")
        time, values = ax.lines[-1].get_data()
        near = np.flatnonzero(np.abs(time - 2.0) < 1e-12)
        assert values[near] == pytest.approx([before, after])
        assert (np.diff(time) >= 0.0).all()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [min]", "acceleration")


def test_a_motion_that_stands_still_and_none(ax):
    plots.plot_motions({"still": min_time_move(0.0, Limits(jerk=1.0), start=2.0)}, 0, ax=ax)
    assert ax.lines[0].get_ydata().tolist() == [2.0]
    assert len(plots.plot_motions({}, 0, ax=Figure().subplots()).lines) == 0
    render(ax.figure)


# A follower


def test_following_shows_commands_as_steps_and_the_position(ax, response):
    assert plots.plot_following(response, ax=ax, unit="mm") is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "position\n[mm]")
    assert sorted(legend(ax)) == ["command", "position"]
    time, position = ax.lines[0].get_data()
    np.testing.assert_array_equal(time, response.time)
    np.testing.assert_array_equal(position, response.states[0])
    [steps] = [patch for patch in ax.patches if patch.get_label() == "command"]
    values, edges, _ = steps.get_data()
    np.testing.assert_array_equal(values, COMMANDS)
    np.testing.assert_allclose(edges, 0.25 * np.arange(len(COMMANDS) + 1), atol=1e-14)
    render(ax.figure)


def test_a_command_is_drawn_over_the_interval_in_which_it_is_followed(ax, response):
    """The position begins to move in the interval of the first command that is not zero."""
    plots.plot_following(response, ax=ax)
    values, edges, _ = ax.patches[0].get_data()
    moved = response.time[np.flatnonzero(response.states[0])[0]]
    assert values[edges[1:] == moved].tolist() == [1.0]
    assert ax.get_ylabel() == "position"


def test_the_phase_plane_is_velocity_against_position(ax, response):
    assert plots.plot_phase_plane(response, ax=ax, unit="mm", time_unit="min") is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("position [mm]", "velocity\n[mm/min]")
    curve, marks = ax.lines
    np.testing.assert_array_equal(curve.get_data(), response.states[:2])
    assert legend(ax) == ["command changes"]
    assert marks.get_linestyle() == "None"
    np.testing.assert_array_equal(marks.get_data(), response.states[:2, [0, 4, 7]])
    render(ax.figure)


def test_without_a_change_of_command_nothing_is_marked(ax):
    response = CommandFollower(Limits(1.0, 1.0), dt=0.1).run([1.0] * 5)
    plots.plot_phase_plane(response, ax=ax)
    assert ax.lines[1].get_xdata().size == 0
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("position", "velocity")
    render(ax.figure)


def test_a_single_sample(ax):
    response = CommandFollower(Limits(1.0, 1.0), dt=0.1).run([1.0])
    plots.plot_following(response, ax=ax)
    plots.plot_phase_plane(response, ax=ax)
    assert len(ax.lines[0].get_xdata()) == 1
    render(ax.figure)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 3e4])
def test_no_label_of_a_move_leaves_the_picture(scale):
    move = min_time_move(-9.99, Limits(velocity=8.88, acceleration=77.7, jerk=7e3, snap=6e5))
    figure = plots.plot_trajectory(move, unit="arcsec", scale=scale, figure=Figure())
    FigureCanvasAgg(figure).draw()
    drawn, page = figure.get_tightbbox(), figure.get_size_inches()
    assert (drawn.min >= 0.0).all()
    assert (drawn.max <= page).all()
