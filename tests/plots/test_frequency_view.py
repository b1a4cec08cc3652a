"""Pictures of shapers: labelled, with units, and of the data that they are given."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jounce.analysis.frequency_view import (
    cascaded_lags,
    frequency_response,
    null_by_size,
    vibration_map,
)
from jounce.plots import frequency_view as plots
from jounce.shaping import JerkFilter, Limits, min_time_move

LIMITS = Limits(velocity=2.0, acceleration=4.0, jerk=20.0)


@pytest.fixture
def ax() -> Axes:
    return Figure().subplots()


def render(figure: Figure) -> None:
    FigureCanvasAgg(figure).draw()


def legend(ax: Axes) -> list[str]:
    return [text.get_text() for text in ax.legend().get_texts()]


def test_responses_by_name(ax):
    omega = np.linspace(-1.0, 50.0, 300)
    move = min_time_move(5.0, LIMITS)
    responses = {
        "S-curve": frequency_response(move, omega),
        "filter": frequency_response(JerkFilter(2.0, 6), omega),
    }
    assert plots.plot_frequency_responses(responses, ax=ax) is ax
    assert legend(ax) == ["S-curve", "filter"]
    frequency, gain = ax.lines[0].get_data()
    shown = omega > 0.0
    np.testing.assert_allclose(frequency, omega[shown] / (2.0 * np.pi))
    np.testing.assert_array_equal(gain, responses["S-curve"].gain_db[shown])
    assert ax.get_xlabel() == "frequency [Hz]"
    assert ax.get_ylabel() == "|v(jω)| / R [dB]"
    assert ax.get_ylim()[0] == -120.0
    render(ax.figure)


def test_responses_in_cycles_per_duration(ax):
    move = min_time_move(5.0, LIMITS)
    response = frequency_response(move, 2.0 * np.pi / move.duration)
    plots.plot_frequency_responses({"one": response}, ax=ax, duration=move.duration)
    assert ax.lines[0].get_xdata() == pytest.approx([1.0])
    assert ax.get_xlabel() == "cycles per duration"


def test_a_map(ax):
    distances, frequencies = [4.0, -1.0, 0.02], np.geomspace(0.5, 20.0, 30)
    vibration = vibration_map(LIMITS, distances, frequencies, 0.02)
    assert plots.plot_vibration_map(vibration, ax=ax, unit="mm") is ax
    [mesh] = ax.collections
    level = 20.0 * np.log10(vibration.relative[::-1])  # by increasing size
    shown = np.asarray(mesh.get_array()).reshape(30, 3)
    np.testing.assert_allclose(shown, np.maximum(level, -80.0).T)
    assert mesh.get_clim() == (-80.0, 0.0)
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert ax.get_xlabel() == "distance [mm]"
    assert ax.get_ylabel() == "mode: frequency [Hz]"
    assert "damping 0.02" in ax.get_title()
    [bar] = [other for other in ax.figure.axes if other is not ax]
    assert bar.get_ylabel() == "residual amplitude / distance [dB]"
    render(ax.figure)


def test_a_map_of_its_own_figure_and_of_one_point():
    for distances, frequencies in (([1.0, 2.0], [1.0, 2.0, 3.0]), ([1.0], [2.0])):
        ax = vibration_map(LIMITS, distances, frequencies).plot()
        assert ax.get_xscale() == "linear"
        assert "damping" not in ax.get_title()
        render(ax.figure)


def test_vibration_by_size(ax):
    vibration = vibration_map(LIMITS, [3.0, 0.1, 0.5], [2.0, 5.0])
    plots.plot_vibration_by_size(vibration, ax=ax, unit="m", time_unit="min")
    assert legend(ax) == ["2 /min", "5 /min"]
    distances, percent = ax.lines[0].get_data()
    assert distances.tolist() == [0.1, 0.5, 3.0]
    expected = 100.0 * vibration.relative[[1, 2, 0], 0]
    np.testing.assert_allclose(percent, np.maximum(expected, 1e-4))
    assert ax.get_ylabel() == "residual amplitude / distance [%]"
    assert ax.get_yscale() == "log"
    render(ax.figure)


def test_nulls_by_size():
    nulls = null_by_size(LIMITS, [0.02, 1.0, 5.0], 5.0)
    ax = nulls.plot()
    stays, moves = ax.lines[:2]
    assert stays.get_xdata().tolist() == [1.0, 5.0]
    assert stays.get_ydata() == pytest.approx([5.0, 5.0])
    assert moves.get_xdata().tolist() == [0.02]
    assert legend(ax) == ["stays", "moves with the distance", "asked for"]
    assert ax.get_ylabel() == "nearest null: frequency [Hz]"
    render(ax.figure)


def test_nulls_that_are_not_there():
    ax = null_by_size(Limits(1.0, (-1.0, 3.0)), [1.0, 2.0], 2.0).plot()
    render(ax.figure)
    assert np.isnan(ax.lines[1].get_ydata()).all()


@pytest.mark.parametrize("match", ["delay", "rates"])
def test_lags_and_their_error(match):
    omega = np.linspace(0.0, 60.0, 400)
    result = cascaded_lags(min_time_move(5.0, LIMITS), omega, match=match)
    figure = result.plot()
    gains, errors = figure.axes
    assert legend(gains) == ["exact", "3 lags", "exact gain at −3 dB"]
    np.testing.assert_array_equal(gains.lines[0].get_ydata(), result.exact.gain_db[1:])
    np.testing.assert_array_equal(gains.lines[1].get_ydata(), result.approximation.gain_db[1:])
    np.testing.assert_array_equal(errors.lines[0].get_ydata(), result.error_db[1:])
    assert errors.get_xlabel() == "frequency [Hz]"
    assert errors.get_ylim()[0] <= result.error_db.min()
    assert f"{abs(result.error_to_corner_db):.2f} dB" in errors.get_title()
    render(figure)
    one = cascaded_lags(min_time_move(5.0, Limits(1.0)), [1.0, 2.0]).plot()
    assert legend(one.axes[0])[1] == "1 lag"
