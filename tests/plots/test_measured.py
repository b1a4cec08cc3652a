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
    size = abs(PLANT.response * (1.0 if controller is None else 900.0))
    assert curve.get_ydata() == pytest.approx(20 * np.log10(size))


def test_the_bands_hold_the_response():
    figure = plot_measured_response(PLANT)
    [band] = figure.axes[0].collections
    low, high = band.get_datalim(figure.axes[0].transData).intervaly
    assert low < 20 * np.log10(abs(PLANT.response)).min()
    assert high > 20 * np.log10(abs(PLANT.response)).max()


def test_nyquist_shows_the_modulus_margin():
    loop = MeasuredResponse(LINES, 900 * PLANT.response, kind="loop")
    margins = loop_margins(loop)
    _, ax = plt.subplots()
    assert plot_measured_nyquist(loop, margins, ax=ax) is ax
    [disk] = ax.patches
    assert disk.get_radius() == pytest.approx(margins.modulus_margin)
