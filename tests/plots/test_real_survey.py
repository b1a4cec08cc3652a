"""Pictures of real loops: labelled, with units, and the numbers of the survey on them."""

from functools import cache
from math import inf

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from real_loops import ARCSEC, AXIS, GAINS, LABELS, SMOOTH, J, move, real_survey

from jounce.analysis import Labels, Move, survey
from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Controller,
    FlexibleMode,
    InertiaFeedforward,
    ServoLoop,
)
from jounce.plots import plot_loop_response, plot_survey, plot_survey_details


def texts(figure):
    """Return all that is written on a figure."""
    figure.draw_without_rendering()
    found = [figure.get_suptitle(), *(text.get_text() for text in figure.texts)]
    for ax in figure.axes:
        found += [ax.get_title(), ax.get_xlabel(), ax.get_ylabel()]
        legend = ax.get_legend()
        if legend is not None:
            found += [legend.get_title().get_text(), *(t.get_text() for t in legend.get_texts())]
    return "\n".join(found)


def test_the_first_page_has_margins_error_torque_and_sensitivities():
    found = real_survey()
    figure = plot_survey(found, figure=Figure())
    assert len(figure.axes) == 4
    text = texts(figure)
    for part in (
        "Telescope azimuth",
        f"phase margin {found.margins.phase_margin_deg:.3g}°",
        f"|S|, peak {found.margins.sensitivity_peak:.3g}",
        "required |S| ≤ 2",
        "tolerance ±0.05 arcsec",
        "limit ±150 N m",
        "torque [N m]",
        "command − load [arcsec]",
        "requirements met: 3 of 4, missed: load_settling",
        ", linear part",
    ):
        assert part in text
    torque = figure.axes[3]
    low, high = torque.get_ylim()
    assert low < -150.0 < 150.0 < high


def test_the_error_is_drawn_as_large_as_it_is():
    found = real_survey()
    error = plot_survey(found, figure=Figure()).axes[2]
    configured = error.get_lines()[1].get_ydata()
    peak = found.moves[0].configured.peak_load_error / ARCSEC
    assert np.abs(configured).max() == pytest.approx(peak, rel=1e-3)
    assert error.get_yscale() == "symlog"


def test_the_details_have_units_and_end_at_half_the_samples():
    figure = plot_survey_details(real_survey(), figure=Figure())
    text = texts(figure)
    for part in (
        "left ringing [arcsec]",
        "|PS| [arcsec/(N m)]",
        "|CS| [N m/arcsec]",
        "10 N m on the load",
        "Errors of the load by source",
        "sidereal: rms",
        "Unit step without feedforward, linear part",
    ):
        assert part in text
    compliance = figure.axes[1].get_lines()[0].get_xdata()
    assert compliance[-1] == pytest.approx(500.0)


def test_a_loop_without_limit_noise_and_tracking_has_fewer_panels():
    loop = ServoLoop(AXIS, GAINS, InertiaFeedforward(J))
    found = survey(loop, [SMOOTH, move()], labels=LABELS)
    page = plot_survey(found, figure=Figure())
    text = texts(page)
    assert "limit" not in text
    assert "linear part" not in text
    details = texts(plot_survey_details(found, figure=Figure()))
    assert "grows for ever" not in details
    assert "Tracking" not in details
    assert found.noise_gain.value == inf
    empty = survey(loop, [], labels=LABELS)
    assert "Error of the load" not in texts(plot_survey(empty, figure=Figure()))


def test_a_response_is_drawn_with_its_limit_and_tolerance():
    response = real_survey().moves[0].configured.response
    figure = plot_loop_response(
        response,
        tolerance=0.05 * ARCSEC,
        unit="arcsec",
        torque_unit="N m",
        scale=ARCSEC,
        figure=Figure(),
    )
    text = texts(figure)
    for part in ("position\n[arcsec]", "error\n[arcsec]", "torque\n[N m]", "limit ±150 N m"):
        assert part in text
    assert "tolerance ±0.05 arcsec" in text


def test_a_response_draws_itself():
    figure = real_survey().moves[0].configured.response.plot(tolerance=1e-6)
    assert [ax.get_ylabel() for ax in figure.axes] == ["position", "error", "torque"]
    plt.close(figure)


@cache
def stiff_survey():
    """Return the survey of a crane: |L| has a peak well above 0 dB, and the step no overshoot."""
    pendulum = FlexibleMode(0.3, 0.003, load_fraction=0.7, held=True)
    axis = Axis(8000.0, modes=[pendulum], viscous=500.0, encoder_step=1e-4)
    controller = Controller(CascadedPI(1.5, 60e3), sample_time=0.02, delay=0.02)
    there = Move(
        name="there", distance=10.0, bounds=(1.2, 0.3, 1.0), limits_name="axis", settle_to=0.02
    )
    return survey(ServoLoop(axis, controller), [there], labels=Labels("Crane", "length", "m", 1.0))


def test_the_legend_of_the_open_loop_hides_no_curve():
    open_loop = plot_survey(stiff_survey(), figure=Figure()).axes[0]
    FigureCanvasAgg(open_loop.figure).draw()
    box = open_loop.get_legend().get_window_extent()
    for line in open_loop.get_lines():
        if len(line.get_xdata()) != 2:
            points = open_loop.transData.transform(line.get_xydata())
            assert not any(box.contains(*point) for point in points)


def test_a_step_that_peaks_late_is_labelled_inside_its_panel():
    loop = ServoLoop(Axis(1.0), Controller(PID(1.0, 0.0, 8.0), sample_time=0.01))
    details = plot_survey_details(survey(loop, [], labels=LABELS), figure=Figure())
    [step] = [ax for ax in details.axes if ax.get_title().startswith("Unit step")]
    FigureCanvasAgg(details).draw()
    [label] = step.texts
    inside, box = step.get_window_extent(), label.get_window_extent()
    assert inside.x0 < box.x0
    assert box.x1 < inside.x1


def test_few_sources_of_error_are_thin_bars_over_whole_decades():
    details = plot_survey_details(stiff_survey(), figure=Figure())
    [budget] = [ax for ax in details.axes if ax.get_title() == "Errors of the load by source"]
    FigureCanvasAgg(details).draw()
    assert not any(label.get_text() for label in budget.get_xticklabels(minor=True))
    low, high = np.log10(budget.get_xlim())
    assert high - low >= 1.0
    assert (low, high) == pytest.approx((round(low), round(high)))
    bottom, top = budget.get_ylim()
    assert bottom - top >= 4.0 * budget.patches[0].get_height()
