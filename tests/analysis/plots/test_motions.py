"""Pictures of motions: labelled, with units, and of the data that they are given."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jounce.analysis.plots import motions as plots
from jounce.shaping import CommandFollower, FollowerResponse, Limits, Trajectory, min_time_move

COMMANDS = [0.0, 1.0, 1.0, 1.0, 1.0, -2.0, -2.0, -2.0, 0.5, 0.5, 0.5, 0.5]


@pytest.fixture
def ax() -> Axes:
    return Figure().subplots()


@pytest.fixture(autouse=True)
def _no_pyplot_state():
    yield
    assert plt.get_fignums() == []


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


def test_a_trajectory_draws_itself_with_units():
    figure = min_time_move(1.0, Limits(acceleration=1.0)).plot(unit="deg", time_unit="min", scale=2)
    assert figure.axes[2].get_ylabel() == "acceleration\n[deg/min²]"
    assert max(figure.axes[0].lines[0].get_ydata()) == pytest.approx(0.5)


@pytest.mark.parametrize("order", [1, 2, 3, 6, 10])
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
