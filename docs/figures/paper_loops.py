"""Figures 7 to 10 of Thompson's "Snap, Crackle, and Pop": filter, spectra, survey of the loop."""

from __future__ import annotations

from math import radians
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from jounce.analysis.frequency_view import (
    corner_omega,
    frequency_response,
    null_omegas,
    rollover_db_per_decade,
)
from jounce.analysis.specification import Move, Specification
from jounce.app.scenario import FilterSection, Scenario
from jounce.app.scenario_survey import survey_file
from jounce.plots import survey as panels
from jounce.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    ORDER_COLORS,
    finish,
    unit_label,
    with_rest,
)
from jounce.shaping import (
    JerkFilter,
    Limits,
    Trajectory,
    min_time_move,
    perfect_spline,
)
from jounce.shaping.derivatives import derivative_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_JERK_FILTER = JerkFilter(corner_hz=2.0, order=6)
_ACCELERATION = 0.2  # deg/s²


def figure_7() -> Figure:
    """Draw the linear jerk filter: six lags with a corner of 2 Hz.

    Its step response has no overshoot and stays within 1 % from 1.0431 s on. Behind a move of
    1 deg that has nothing but its acceleration limited, to 0.2 deg/s², it gives a command of
    bounded jerk, half a second later.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section V.
    """
    figure = Figure(figsize=(10.5, 6.6), layout="constrained")
    (step, position), (acceleration, jerk) = figure.subplots(2, 2)
    _draw_filter_step(ax=step)
    move = min_time_move(1.0, Limits(acceleration=_ACCELERATION))
    filtered = _JERK_FILTER.respond(move, dt=0.005)
    before = np.append(with_rest(move), filtered.time[-1])
    after = np.append(before[0], filtered.time)
    for k, ax in ((0, position), (2, acceleration), (3, jerk)):
        if k < 3:
            ax.plot(before, move(before, k), color=GREY, label="acceleration-limited move")
        ax.plot(after, np.append(0.0, filtered.states[k]), color=BLUE, label="behind the filter")
        name = derivative_name(k)
        finish(ax, f"1 deg: {name}", "time [s]", name + unit_label("deg", "s", k))
        ax.legend(loc="upper right" if k == 2 else "lower right")
    return figure


def figure_8() -> Figure:
    """Draw shapers as low-pass filters: the spectrum of velocity over distance.

    Perfect splines of order 2 to 6, of equal duration T, stand beside the filter of Figure 7.
    The paper's R/T = 2π is read as a distance of 2π in T = 1 s; as v/R does not depend on the
    distance, the axis counts cycles per duration, too. Behind the corner come nulls, under an
    envelope that falls by 20 dB per decade for every order.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VI.
    """
    shapers: dict[str, tuple[Trajectory | JerkFilter, str, str]] = {
        f"order {n}": (_spline_of_one_second(n), color, "-") for n, color in ORDER_COLORS.items()
    }
    shapers["6 lags of 2 Hz"] = (_JERK_FILTER, "black", "--")
    figure = Figure(figsize=(9.0, 5.8), layout="constrained")
    ax = figure.subplots()
    grid = frequency = np.geomspace(0.1, 20.0, 1500)
    for name, (shaper, color, style) in shapers.items():
        if isinstance(shaper, Trajectory):
            nulls = null_omegas(shaper, 2.0 * np.pi * grid[-1]) / (2.0 * np.pi)
            frequency = np.sort(np.concatenate([grid, nulls]))
        gain = frequency_response(shaper, 2.0 * np.pi * frequency).gain_db
        corner, fall = corner_omega(shaper) / (2.0 * np.pi), rollover_db_per_decade(shaper)
        label = f"{name}: −3 dB at {corner:.3f} Hz, then {fall:.0f} dB/decade"
        ax.semilogx(frequency, gain, style, color=color, linewidth=1.2, label=label)
    ax.set_xlim(grid[0], grid[-1])
    ax.set_ylim(-150.0, 5.0)
    ax.legend(loc="lower left")
    title = "Perfect splines of 1 s, and the jerk filter"
    finish(ax, title, "frequency [Hz], or cycles per duration T", "|v(jω)| / R [dB]")
    return figure


def figure_10() -> Figure:
    """Draw the survey of the loop: a telescope axis under a PID controller.

    Designed for a crossover of 1 Hz, a phase margin of 45° and a lower gain margin of 12 dB,
    the loop overshoots a step by 40 %. A move of 60 arcsec at 0.2 deg/s² behind the filter of
    Figure 7 it follows without overshoot, once the commanded acceleration is fed forward.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.
    """
    found = survey_file(_telescope())
    figure = Figure(figsize=(14.0, 7.6), layout="constrained")
    (gain, nichols, step), (phase, closed, move) = figure.subplots(2, 3)
    panels.plot_loop_gain(found, ax=gain)
    panels.plot_loop_phase(found, ax=phase)
    panels.plot_nichols(found, ax=nichols)
    panels.plot_sensitivities(found, ax=closed)
    panels.plot_step(found.step, ax=step)
    panels.plot_move(found, found.moves[0], ax=move)
    return figure


def _draw_filter_step(*, ax: Axes) -> None:
    """Draw the step response of the filter, and from when on it stays within 1 %."""
    tolerance = 0.01
    settled = _JERK_FILTER.settling_time(tolerance)
    time = np.linspace(0.0, 1.5, 401)
    ax.plot(time, _JERK_FILTER.step_response(time), color=BLUE, label="6 lags of 2 Hz")
    ax.axhspan(1.0 - tolerance, 1.0 + tolerance, color=GREY, alpha=0.25, label="±1 %")
    ax.plot(settled, 1.0 - tolerance, "o", color=ORANGE)
    ax.annotate(
        f"within 1 %\nfrom {settled:.4f} s on",
        (settled, 1.0 - tolerance),
        xytext=(0, -12),
        textcoords="offset points",
        va="top",
        color=ORANGE,
    )
    finish(ax, "Step response of the jerk filter", "time [s]", "position / step")
    ax.legend(loc="lower right")


def _spline_of_one_second(order: int) -> Trajectory:
    spline = perfect_spline(2.0 * np.pi, order, 1.0)
    return spline.stretch(1.0 / spline.duration)


def _telescope() -> Scenario:
    """Return the telescope axis of Section VII, as examples/telescope.toml describes it."""
    arcsec = radians(1.0 / 3600.0)
    move = Move(
        name="60 arcsec step",
        distance=60.0 * arcsec,
        bounds=(np.inf, radians(_ACCELERATION)),
        limits_name="axis",
        settle_to=0.05 * arcsec,
    )
    return Scenario(
        path=Path("telescope"),
        title="Telescope axis (Thompson, Section VII)",
        motion="angle",
        position_unit="arcsec",
        inertia=1.0,
        gains="design",
        specification=Specification(1.0, 45.0, 12.0),
        feedforward_inertia=1.0,
        inertia_error=0.1,
        filter=FilterSection(_JERK_FILTER.corner_hz, _JERK_FILTER.order),
        moves=(move,),
    )
