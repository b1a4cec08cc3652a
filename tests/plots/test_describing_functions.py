"""Pictures of describing functions: the data that they are given, labels with units."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jounce.analysis.frequency_view.describing_functions import (
    describing_function,
    periodic_response,
)
from jounce.analysis.frequency_view.nearest_lag import first_order_lag
from jounce.plots import describing_functions as plots
from jounce.shaping import Limits

LIMITER = Limits(velocity=1.0)
SIZES, OMEGA = np.array([0.1, 1.0, 10.0]), np.geomspace(0.01, 100.0, 50)


@pytest.fixture
def ax():
    return Figure().subplots()


@pytest.fixture
def swept():
    return describing_function(LIMITER, SIZES[:, None], OMEGA)


def legend(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_gain_and_phase_with_lags(swept):
    lag = first_order_lag(swept)
    upper = plots.plot_describing_function(swept, lag=lag, time_unit="min")
    upper, lower = upper.figure.axes
    FigureCanvasAgg(upper.figure).draw()
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("|N| [dB]", "phase [deg]")
    assert (upper.get_xlabel(), lower.get_xlabel()) == ("", "ω [rad/min]")
    for ax, values, lags in (
        (upper, swept.gain_db, 20.0 * np.log10(np.abs(lag.response(OMEGA)))),
        (lower, swept.phase_deg, np.degrees(np.angle(lag.response(OMEGA)))),
    ):
        assert legend(ax) == ["A = 0.1", "A = 1", "A = 10", "first-order lag"]
        for i in range(3):
            np.testing.assert_array_equal(ax.lines[i].get_data(), [OMEGA, values[i]])
            np.testing.assert_array_equal(ax.lines[3 + i].get_data(), [OMEGA, lags[i]])
            assert ax.lines[3 + i].get_linestyle() == "--"
            assert tuple(ax.lines[3 + i].get_color()) == tuple(ax.lines[i].get_color())


def test_results_draw_themselves(swept, ax):
    assert swept.plot(ax) is ax
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), swept.gain_db[0])
    assert len(swept.plot().figure.axes) == 2


def test_over_amplitude_at_constant_frequency(ax):
    swept = describing_function(LIMITER, SIZES, np.array([[1.0], [2.0]]))
    plots.plot_describing_phase(swept, ax=ax)
    assert ax.get_xlabel() == "amplitude A"
    assert legend(ax) == ["ω = 1", "ω = 2"]
    np.testing.assert_array_equal(ax.lines[1].get_data(), [SIZES, swept.phase_deg[1]])


@pytest.mark.parametrize("omega", [2.0, [2.0], OMEGA], ids=["scalar", "one", "row"])
def test_a_single_curve_or_point(omega, ax):
    swept = describing_function(LIMITER, 1.0, omega)
    swept.plot(ax)
    [line] = ax.lines
    np.testing.assert_array_equal(line.get_ydata(), np.atleast_1d(swept.gain_db))
    assert line.get_marker() == ("o" if np.size(omega) == 1 else "")
    FigureCanvasAgg(ax.figure).draw()


def test_of_many_curves_some_are_labelled(ax):
    swept = describing_function(LIMITER, np.geomspace(0.1, 10.0, 50)[:, None], OMEGA)
    swept.plot(ax)
    assert len(ax.lines) == 50
    assert len(legend(ax)) <= 8


def test_amplitudes_and_frequencies_in_pairs_are_refused(ax):
    with pytest.raises(ValueError, match="both change along the last axis"):
        describing_function(LIMITER, [1.0, 2.0], [1.0, 2.0]).plot(ax)


def test_one_period(ax):
    period = periodic_response(LIMITER, 1.0, 1.5)
    assert plots.plot_periodic_response(period, ax=ax, unit="deg", time_unit="min") is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [min]", "position\n[deg]")
    assert legend(ax) == ["command", "output"]
    np.testing.assert_array_equal(ax.lines[0].get_data(), [period.time, period.command])
    np.testing.assert_array_equal(ax.lines[1].get_data(), [period.time, period.output])
    FigureCanvasAgg(period.plot().figure).draw()
