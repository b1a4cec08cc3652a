"""Pictures of conformance: panels, labels, limits and the extremes of long logs."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jounce.analysis.log_conformance import conformance
from jounce.plots.conformance import plot_band, plot_conformance
from jounce.shaping import Limits, min_time_move


def a_log(count):
    move = min_time_move(1.5, Limits(velocity=1.0, acceleration=2.0, jerk=20.0))
    times = np.linspace(-0.2, move.duration + 0.2, count)
    return times, move(times) + 1e-5 * np.random.default_rng(0).standard_normal(count)


@pytest.fixture(scope="module")
def report():
    return conformance(*a_log(1500), Limits(velocity=1.2, acceleration=(-1.5, 2.5)))


def test_three_panels_with_labels_limits_and_verdicts(report):
    figure = report.plot(unit="mm", time_unit="ms")
    assert isinstance(figure, Figure)
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["velocity\n[mm/ms]", "acceleration\n[mm/ms²]", "jerk\n[mm/ms³]"]
    assert figure.axes[-1].get_xlabel() == "time [ms]"
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles == [
        "velocity: kept",
        "acceleration +: kept,  acceleration −: broken",
        "jerk: no limit",
    ]
    for k, ax in enumerate(figure.axes, start=1):
        dashed = [line.get_ydata()[0] for line in ax.lines if line.get_linestyle() == "--"]
        assert dashed == [side for side in report.limits.bounds(k) if np.isfinite(side)]
        depth = {line.get_label(): line.get_zorder() for line in ax.lines}
        assert depth.get("limit", 0.0) < depth["fit"]
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["error bar, 95 %", "fit", "limit"]
    FigureCanvasAgg(figure).draw()


def test_no_unit_is_made_up(report):
    figure = plot_conformance(report)
    assert figure.axes[0].get_ylabel() == "velocity"
    assert figure.axes[-1].get_xlabel() == "time [s]"


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("count", [300, 20_000])
def test_curves_show_the_extremes_of_the_log(count, k):
    found = conformance(*a_log(count), Limits(velocity=1.2))
    ax = Figure().subplots()
    assert plot_band(found, k, ax=ax) is ax
    curve = ax.lines[0].get_ydata()
    assert len(curve) <= 3000
    assert curve.max() == found.band(k).values.max()
    assert curve.min() == found.band(k).values.min()
    corners = ax.collections[0].get_paths()[0].vertices[:, 1]
    band = found.band(k)
    assert corners.max() == (band.values + band.error).max()
    low, high = ax.get_ylim()
    assert low < curve.min() < curve.max() < high


def test_a_log_at_rest_is_drawn():
    found = conformance(np.arange(50.0), np.ones(50), Limits(jerk=1.0), resolution=0.1)
    figure = found.plot()
    FigureCanvasAgg(figure).draw()
    assert figure.axes
    for ax in figure.axes:
        low, high = ax.get_ylim()
        assert -np.inf < low < high < np.inf


def test_nothing_is_drawn_in_a_pause():
    times, positions = a_log(1500)
    times = np.where(times > 1.0, times + 5.0, times)
    figure = conformance(times, positions, Limits(velocity=1.2)).plot()
    for ax in figure.axes:
        curves = [line.get_xdata() for line in ax.lines if line.get_label() == "fit"]
        assert len(curves) == len(ax.collections) == 2
        assert curves[0][-1] < 1.01
        assert curves[1][0] > 5.99
    assert len(figure.legends[0].get_texts()) == 3
