"""Pictures drawn without axes are pyplot's: plt.show() and plt.savefig() see them."""

import matplotlib.image
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from tiers import some

from jounce.analysis import (
    cascaded_lags,
    conformance,
    describing_function,
    frequency_response,
    null_by_size,
    periodic_response,
    servo_margins,
    vibration_map,
)
from jounce.app import load_scenario, survey_file
from jounce.fmu.cosimulation.cosimulation_result import CosimulationResult
from jounce.plant import PID
from jounce.plots import (
    plot_cascaded_lags,
    plot_conformance,
    plot_cosimulation,
    plot_describing_function,
    plot_describing_gain,
    plot_describing_phase,
    plot_following,
    plot_frequency_responses,
    plot_margin_contours,
    plot_motions,
    plot_null_by_size,
    plot_periodic_response,
    plot_phase_plane,
    plot_survey,
    plot_trajectory,
    plot_vibration_by_size,
    plot_vibration_map,
)
from jounce.shaping import CommandFollower, Limits, min_time_move

LIMITS = Limits(velocity=1.0, acceleration=2.0, jerk=20.0)
LIMITER = Limits(velocity=1.0)
MOVE = min_time_move(3.0, LIMITS)
TIMES, STATES = MOVE.sample(0.1)
FOLLOWING = CommandFollower(LIMITS, dt=0.1).run([1.0, 1.0, 0.0])
SURVEY = survey_file(load_scenario("examples/telescope.toml"))
LOG = conformance(TIMES, STATES[0], LIMITS, resolution=1e-6)
LAGS = cascaded_lags(MOVE, [1.0, 2.0, 3.0])
VIBRATION = vibration_map(LIMITS, [1.0, 2.0], [2.0, 3.0])
NULLS = null_by_size(LIMITS, [1.0, 2.0], 3.0)
SWEPT = describing_function(LIMITER, 1.0, [1.0, 2.0, 3.0])
PERIOD = periodic_response(LIMITER, 2.0, 1.0)
MARGINS = servo_margins([[1.0], [2.0]], PID(1.0, 1.0, 2.0), delay=[0.0, 0.01])
RUN = CosimulationResult(
    np.arange(3.0), {"a.y": np.arange(3.0)}, ("a.y",), ("a",), "jacobi", {}, {}
)

PANELS = {
    "move.plot": MOVE.plot,
    "survey.plot": SURVEY.plot,
    "conformance.plot": LOG.plot,
    "lags.plot": LAGS.plot,
    "describing.plot": SWEPT.plot,
    "plot_trajectory": lambda: plot_trajectory(MOVE, limits=LIMITS),
    "plot_survey": lambda: plot_survey(SURVEY),
    "plot_conformance": lambda: plot_conformance(LOG),
    "plot_cascaded_lags": lambda: plot_cascaded_lags(LAGS),
    "plot_describing_function": lambda: plot_describing_function(SWEPT),
    "plot_cosimulation": lambda: plot_cosimulation(RUN),
}
SINGLE = {
    "vibration.plot": VIBRATION.plot,
    "nulls.plot": NULLS.plot,
    "period.plot": PERIOD.plot,
    "margins.plot": lambda: MARGINS.plot([0.0, 0.01], [1.0, 2.0]),
    "plot_motions": lambda: plot_motions({"move": MOVE}, 1),
    "plot_following": lambda: plot_following(FOLLOWING),
    "plot_phase_plane": lambda: plot_phase_plane(FOLLOWING),
    "plot_frequency_responses": lambda: plot_frequency_responses(
        {"move": frequency_response(MOVE, [1.0, 2.0])}
    ),
    "plot_vibration_map": lambda: plot_vibration_map(VIBRATION),
    "plot_vibration_by_size": lambda: plot_vibration_by_size(VIBRATION),
    "plot_null_by_size": lambda: plot_null_by_size(NULLS),
    "plot_describing_gain": lambda: plot_describing_gain(SWEPT),
    "plot_describing_phase": lambda: plot_describing_phase(SWEPT),
    "plot_periodic_response": lambda: plot_periodic_response(PERIOD),
    "plot_margin_contours": lambda: plot_margin_contours(MARGINS, [0.0, 0.01], [1.0, 2.0]),
}
EVERY = {**PANELS, **SINGLE}


def inked(path):
    """Return which share of a saved picture is not white."""
    pixels = matplotlib.image.imread(path)[..., :3]
    return float((pixels.min(axis=-1) < 0.95).mean())


@pytest.mark.parametrize("name", EVERY)
def test_pyplot_shows_what_was_drawn(name):
    drawn = EVERY[name]()
    figure = drawn if isinstance(drawn, Figure) else drawn.figure
    assert plt.get_fignums() == [figure.number]
    assert plt.gcf() is figure


@pytest.mark.parametrize("name", some(EVERY, 3))
def test_pyplot_saves_what_was_drawn(name, tmp_path):
    EVERY[name]()
    plt.savefig(tmp_path / "picture.png", dpi=40)
    assert inked(tmp_path / "picture.png") > 5e-3


@pytest.mark.parametrize("draw", EVERY.values(), ids=EVERY)
def test_an_empty_current_figure_is_drawn_in_and_keeps_its_size(draw):
    mine = plt.figure(figsize=(9.0, 7.0))
    drawn = draw()
    assert (drawn if isinstance(drawn, Figure) else drawn.figure) is mine
    assert tuple(mine.get_size_inches()) == (9.0, 7.0)
    assert plt.get_fignums() == [mine.number]


@pytest.mark.parametrize("draw", SINGLE.values(), ids=SINGLE)
def test_one_panel_is_drawn_in_the_current_axes(draw):
    _, (left, right) = plt.subplots(1, 2)
    plt.sca(left)
    assert draw() is left
    assert left.has_data()
    assert not right.has_data()


@pytest.mark.parametrize("draw", PANELS.values(), ids=PANELS)
def test_several_panels_leave_alone_what_was_drawn_before(draw):
    before, ax = plt.subplots()
    [line] = ax.plot([0.0, 1.0])
    drawn = draw()
    figure = drawn if isinstance(drawn, Figure) else drawn.figure
    assert figure is not before
    assert plt.gcf() is figure
    assert before.axes == [ax]
    assert ax.lines[0] is line


def test_a_figure_given_is_drawn_in_without_pyplot():
    own = Figure()
    for draw in (
        lambda: plot_survey(SURVEY, figure=own),
        lambda: plot_trajectory(MOVE, figure=Figure()),
    ):
        draw()
    assert plt.get_fignums() == []
    assert tuple(own.get_size_inches()) == (15.0, 11.0)
