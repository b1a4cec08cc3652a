"""The picture of a loop's response shows what is in it."""

import matplotlib.pyplot as plt
import numpy as np

from jounce.plant import PID, Axis, Controller, FlexibleMode, Friction, Inertia, ServoLoop
from jounce.shaping import Limits, min_time_move

MOVE = min_time_move(0.5, Limits(velocity=1.0, acceleration=8.0, jerk=200.0))


def test_a_sticking_flexible_axis_shows_load_limit_and_bands():
    axis = Axis(
        2.0,
        modes=FlexibleMode(20.0, 0.02, load_fraction=0.3),
        friction=Friction(3.0),
        torque_limit=14.0,
        current_lag=1e-3,
    )
    controller = Controller(PID(1200.0, 3000.0, 60.0), sample_time=1e-3)
    response = ServoLoop(axis, controller).respond(MOVE, 1e-3, duration=1.0)
    figure = response.plot(unit="mrad", torque_unit="N m", scale=1e-3)
    above, middle, below = figure.axes
    assert [line.get_label() for line in above.lines] == ["command", "measured", "load"]
    np.testing.assert_array_equal(middle.lines[1].get_ydata(), response.load_error / 1e-3)
    assert [line.get_ydata()[0] for line in below.lines[2:]] == [14.0, -14.0]
    assert [text.get_text() for text in below.get_legend().get_texts()].count("stuck") == 1
    assert len(above.patches) == len(response.stick_intervals) > 1
    plt.close(figure)


def test_an_ideal_loop_shows_no_more_than_it_has():
    response = ServoLoop(Inertia(2.0), PID(80.0, 100.0, 20.0)).respond(MOVE, 0.01)
    figure = response.plot()
    assert [len(ax.lines) for ax in figure.axes] == [2, 1, 1]
    plt.close(figure)
