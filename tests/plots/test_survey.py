"""Pictures: labelled, with units and legends, and without any state left behind."""

from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tiers import some

from jounce.app import load_scenario, survey_file
from jounce.plots import survey as plots

EXAMPLES = Path(__file__).parents[2] / "examples"
OF_SURVEY = ("plot_loop_gain", "plot_loop_phase", "plot_nichols", "plot_sensitivities")
OF_MOVE = ("plot_move", "plot_torque", "plot_tracking_error", "plot_wrong_inertia")
SEVERAL_CURVES = ("plot_nichols", "plot_sensitivities", *OF_MOVE)

LINEAR = """
plant.inertia = "MASS"
controller.gains = {kp = "KP", ki = "KI", kr = "KR"}
limits.axis = {acceleration = "ACCELERATION"}
moves = [{name = "go", distance = "DISTANCE", settle_to = "TOLERANCE"}]
"""


@pytest.fixture
def ax() -> Axes:
    return Figure().subplots()


def drawn(name: str, found, ax: Axes) -> Axes:
    draw = getattr(plots, name)
    if name == "plot_step":
        return draw(found.step, ax=ax)
    return draw(found, ax=ax) if name in OF_SURVEY else draw(found, found.moves[0], ax=ax)


def render(figure: Figure) -> None:
    figure.draw_without_rendering()


@pytest.mark.parametrize("name", [*OF_SURVEY, *OF_MOVE, "plot_step"])
def test_each_returns_its_labelled_axes(telescope, ax, name):
    assert drawn(name, telescope, ax) is ax
    assert ax.get_title()
    for label in (ax.get_xlabel(), ax.get_ylabel()):
        assert label
        assert "[" in label or label == "position / step"
    if name in SEVERAL_CURVES:
        entries = [text.get_text() for text in ax.get_legend().get_texts()]
        assert len(entries) == len(set(entries)) >= 2
    render(ax.figure)


@pytest.mark.parametrize("name", OF_MOVE)
def test_moves_are_shown_in_the_units_of_the_scenario(telescope, rubin, name):
    unit = {"plot_torque": "[N m]"}
    for found, position in ((telescope, "[arcsec]"), (rubin, "[deg]")):
        ax = drawn(name, found, Figure().subplots())
        assert unit.get(name, position) in ax.get_ylabel()
        assert ax.get_xlabel() == "time [s]"
        assert found.moves[0].name in ax.get_title()


def test_curves_are_those_of_the_result(telescope, ax):
    plots.plot_loop_gain(telescope, ax=ax)
    frequency, gain = ax.lines[0].get_data()
    controller = telescope.loop.controller
    s = 2j * np.pi * frequency
    loop = (controller.kr * s**2 + controller.kp * s + controller.ki) / s**3
    np.testing.assert_allclose(gain, 20 * np.log10(np.abs(loop)), atol=1e-9)
    assert frequency[0] < 1.0 < frequency[-1]


def test_the_phase_is_unwrapped_from_minus_270_to_minus_90(telescope, ax):
    plots.plot_loop_phase(telescope, ax=ax)
    _, phase = ax.lines[0].get_data()
    assert phase[0] == pytest.approx(-270, abs=5)
    assert phase[-1] == pytest.approx(-90, abs=5)
    assert np.all(np.diff(phase) > 0)


def test_the_move_reaches_its_distance_in_arcsec(telescope, ax):
    plots.plot_move(telescope, telescope.moves[0], ax=ax)
    for line in ax.lines:
        assert line.get_ydata()[0] == pytest.approx(0.0, abs=1e-12)
        assert line.get_ydata()[-1] == pytest.approx(60.0, abs=0.05)


def test_marks_carry_the_margins(telescope):
    texts = [
        text.get_text()
        for name in ("plot_loop_gain", "plot_loop_phase", "plot_step")
        for text in drawn(name, telescope, Figure().subplots()).texts
    ]
    for fact in ("1 Hz", "12 dB", "45°", "39.85 %"):
        assert any(fact in text for text in texts)


@pytest.mark.parametrize("name", ["telescope", "rubin"])
def test_the_survey_on_one_page(name, request):
    found = request.getfixturevalue(name)
    figure = found.plot()
    assert isinstance(figure, Figure)
    assert len(figure.axes) == 9
    assert figure.get_suptitle() == found.scenario.title
    assert all(ax.get_xlabel() and ax.get_ylabel() and ax.get_title() for ax in figure.axes)
    assert all(ax.lines for ax in figure.axes)


def test_no_rounding_error_is_given_as_a_peak(telescope, ax):
    plots.plot_tracking_error(telescope, telescope.moves[0], ax=ax)
    entries = [text.get_text() for text in ax.get_legend().get_texts()]
    assert not any("e-1" in entry for entry in entries)


@pytest.mark.parametrize("example", ["telescope", "rubin"])
def test_legends_hide_no_curve(request, example):
    figure = request.getfixturevalue(example).plot()
    render(figure)
    hidden = [
        (ax.get_title(), line.get_label())
        for ax in figure.axes
        for line in ax.lines
        if ax.get_legend() and len(line.get_xdata()) > 2 and lies_under_legend(ax, line)
    ]
    assert hidden == []


def lies_under_legend(ax: Axes, line) -> bool:
    box = ax.get_legend().get_window_extent()
    x, y = ax.transData.transform(np.column_stack(line.get_data())).T
    return bool(np.any((box.x0 < x) & (x < box.x1) & (box.y0 < y) & (y < box.y1)))


def linear(folder: Path, **values: str):
    text = LINEAR
    for key, value in values.items():
        text = text.replace(key, value)
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return survey_file(path)


TINY = {"MASS": "1e-12 kg", "KP": "1e-18 N/m", "KI": "0 N/(m s)", "KR": "1e-15 N s/m",
        "ACCELERATION": "1e-9 um/s^2", "DISTANCE": "1e-6 um", "TOLERANCE": "1e-9 um"}  # fmt: skip
HUGE = {"MASS": "1e9 kg", "KP": "1e15 N/m", "KI": "1e17 N/(m s)", "KR": "1e12 N s/m",
        "ACCELERATION": "1e6 m/s^2", "DISTANCE": "-1e9 m", "TOLERANCE": "1 m"}  # fmt: skip


@pytest.mark.parametrize("values", [TINY, HUGE], ids=["tiny", "huge"])
def test_extreme_sizes(tmp_path, values):
    found = linear(tmp_path, **values)
    figure = found.plot()
    render(figure)
    assert any("force [N]" in ax.get_ylabel() for ax in figure.axes)
    for ax in figure.axes:
        for line in ax.lines:
            assert np.all(np.isfinite(np.asarray(line.get_ydata(), dtype=float)))


def test_margins_that_do_not_exist(telescope):
    """A loop that never crosses one, or whose peaks lie at no frequency, is drawn all the same."""
    nothing = replace(
        telescope.margins,
        crossover_hz=float("nan"),
        phase_margin_deg=inf,
        lower_gain_margin_db=inf,
        lower_gain_margin_hz=float("nan"),
        bandwidth_hz=inf,
        modulus_margin=1.0,
        sensitivity_peak_hz=inf,
    )
    figure = replace(telescope, margins=nothing).plot()
    render(figure)
    assert len(figure.axes) == 9
    assert any("fall by any amount" in text.get_text() for text in figure.texts)


def test_an_upper_gain_margin_is_marked_below_the_line(telescope, ax):
    margins = replace(telescope.margins, upper_gain_margin_db=8.0, upper_gain_margin_hz=5.0)
    plots.plot_loop_gain(replace(telescope, margins=margins), ax=ax)
    assert any("upper" in text.get_text() and "8 dB" in text.get_text() for text in ax.texts)
    assert any(np.allclose(line.get_ydata(), [0.0, -8.0]) for line in ax.lines if
               len(line.get_ydata()) == 2)  # fmt: skip


def test_responses_that_do_not_settle(telescope, ax):
    move = telescope.moves[0]
    never = {name: replace(r, settling_time_s=inf) for name, r in move.responses.items()}
    plots.plot_tracking_error(telescope, replace(move, responses=never), ax=ax)
    assert len(ax.lines[0].get_xdata()) == len(move.configured.response.time)
    render(ax.figure)


@pytest.mark.parametrize("name", some([r"$\oops$", "costs $5 or $6", "100 % _a_ ^b^ {c}[d]"], 1))
def test_names_are_drawn_as_they_are(name):
    scenario = load_scenario(EXAMPLES / "telescope.toml")
    moves = (replace(scenario.moves[0], name=name),)
    figure = survey_file(replace(scenario, title=name, moves=moves)).plot()
    render(figure)
    assert figure.get_suptitle().replace("\\$", "$") == name
    titles = [figure._suptitle, *(ax.title for ax in figure.axes if "$" in ax.get_title())]
    assert not any(t.get_parse_math() and "$" in t.get_text().replace("\\$", "") for t in titles)
