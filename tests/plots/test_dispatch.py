"""Every kind of result has one picture, found by its type."""

import subprocess
import sys

import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure

import jounce.analysis
import jounce.fmu
import jounce.plant
import jounce.shaping.trajectory
from jounce.plots import dispatch, draw
from jounce.shaping import CommandFollower, Limits, drawing, min_time_move

LIMITS = Limits(velocity=1.0, acceleration=2.0)
MOVE = min_time_move(3.0, LIMITS)


def test_a_trajectory_is_drawn_in_panels_with_the_options_of_its_function():
    figure = draw(MOVE, limits=LIMITS, unit="deg")
    assert isinstance(figure, Figure)
    assert figure.axes[0].get_ylabel() == "position\n[deg]"


def test_a_response_is_drawn_in_the_axes_given():
    _, ax = plt.subplots()
    response = CommandFollower(LIMITS, dt=0.1).run([1.0, 1.0])
    assert drawing.draw(response, ax) is ax
    assert ax.has_data()


def test_several_panels_do_not_fit_into_axes():
    _, ax = plt.subplots()
    with pytest.raises(TypeError, match="a Trajectory is drawn in several panels; leave ax out"):
        drawing.draw(MOVE, ax)


def test_what_has_no_picture_is_refused():
    with pytest.raises(TypeError, match=r"^a dict has no picture: expected a result such as"):
        draw({})


def test_pictures_are_loaded_when_first_asked_for():
    code = (
        "import sys; from jounce.shaping import Limits, min_time_move; "
        "move = min_time_move(1.0, Limits(1.0)); "
        "assert not any(n.startswith(('matplotlib', 'jounce.plots')) for n in sys.modules); "
        "import matplotlib; matplotlib.use('agg'); move.plot(); "
        "assert 'jounce.plots' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_kind_is_a_result_and_every_picture_a_function():
    kinds = {**dispatch._PANELS, **dispatch._SINGLE}
    modules = (jounce.shaping, jounce.plant, jounce.analysis, jounce.fmu, jounce.shaping.trajectory)
    for kind, place in kinds.items():
        assert any(hasattr(module, kind) for module in modules), kind
        assert callable(dispatch._picture(place))
