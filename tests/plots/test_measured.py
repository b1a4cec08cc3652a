"""Pictures of measured responses: what is drawn of plants and of loops."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from jounce.analysis import MeasuredResponse, loop_margins
from jounce.plant import PID
from jounce.plots import plot_measured_nyquist, plot_measured_response

LINES = np.arange(1.0, 80.0)
S = 2j * np.pi * LINES
PLANT = MeasuredResponse(LINES, 1 / (S * (S + 30)), 0.01 / abs(S * (S + 30)), kind="plant")
LAW = PID(900.0, 0.0, 0.0)


@pytest.mark.parametrize(("controller", "panels"), [(None, 2), (LAW, 4)])
def test_a_plant_has_two_panels_and_its_loop_four(controller, panels):
    figure = PLANT.plot(controller=controller)
    assert len(figure.axes) == panels
    curve = figure.axes[0].get_lines()[0]
    s = 2j * np.pi * curve.get_xdata()
    size = abs(1 / (s * (s + 30))) * (1.0 if controller is None else 900.0)
    assert curve.get_ydata() == pytest.approx(20 * np.log10(size), abs=0.02)


def test_the_bands_hold_the_response():
    figure = plot_measured_response(PLANT)
    [band] = figure.axes[0].collections
    low, high = band.get_datalim(figure.axes[0].transData).intervaly
    assert low < 20 * np.log10(abs(PLANT.response)).min()
    assert high > 20 * np.log10(abs(PLANT.response)).max()


def test_between_lines_the_circle_of_a_light_mode_is_drawn_round():
    def exact(hertz):
        s, mode = 2j * np.pi * hertz, 2 * np.pi * 61.5
        return 60 / s * (1 + mode**2 / (s**2 + 0.01 * mode * s + mode**2))

    loop = MeasuredResponse(LINES, exact(LINES), kind="loop")
    curve = plot_measured_response(loop).axes[1].get_lines()[0].get_xydata() @ [1, 1j]
    circle = curve[curve.real < -1.0]
    beside = exact(np.linspace(55.0, 70.0, 3001))
    assert abs(circle[:, None] - beside).min(axis=1).max() < 0.3
    assert abs(np.diff(circle)).max() < 5.0  # lines are 13 apart


def test_python_controls_data_are_drawn_as_a_plant_or_a_loop():
    data = PLANT.to_frd()
    assert len(plot_measured_response(data, controller=LAW).axes) == 4
    assert len(plot_measured_response(data).axes) == 4


def test_nyquist_shows_the_modulus_margin():
    loop = MeasuredResponse(LINES, 900 * PLANT.response, kind="loop")
    margins = loop_margins(loop)
    _, ax = plt.subplots()
    assert plot_measured_nyquist(loop, margins, ax=ax) is ax
    [disk] = ax.patches
    assert disk.get_radius() == pytest.approx(margins.modulus_margin)
