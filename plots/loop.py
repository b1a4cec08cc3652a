"""Pictures of a survey's loop: gain, phase, Nichols, closed loop and step, each in Axes."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MultipleLocator

from ..analysis.surveyed_loop import decaying_poles
from .style import BLUE, CURVE_POINTS, GREEN, GREY, ORANGE, RED, finish

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..analysis.loop_survey import Survey
    from ..analysis.step_response import StepResponse
    from ..shaping.pieces import FloatArray


def plot_loop_gain(survey: Survey, *, ax: Axes) -> Axes:
    """Draw |L| against frequency, with crossover and gain margins marked."""
    frequency, loop = loop_curve(survey)
    margins = survey.margins
    ax.semilogx(frequency, _db(loop), color=BLUE)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    ax.plot(margins.crossover_hz, 0.0, "o", color=ORANGE)
    ax.annotate(
        f"crossover {margins.crossover_hz:.4g} Hz",
        (margins.crossover_hz, 0.0),
        xytext=(8, 6),
        textcoords="offset points",
        color=ORANGE,
    )
    for level, at, name in (
        (margins.lower_gain_margin_db, margins.lower_gain_margin_hz, "lower"),
        (-margins.upper_gain_margin_db, margins.upper_gain_margin_hz, "upper"),
    ):
        if isfinite(level):
            ax.plot([at, at], [0.0, level], "-o", color=RED, markersize=4)
            ax.annotate(
                f"{name} gain margin\n{abs(level):.4g} dB",
                (at, min(level, 0.0)),
                xytext=(18, -4),
                textcoords="offset points",
                ha="right",
                va="top",
                color=RED,
            )
    return finish(ax, "Open loop: gain", "frequency [Hz]", "|L| [dB]")


def plot_loop_phase(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the phase of L against frequency, with the phase margin marked."""
    frequency, loop = loop_curve(survey)
    margins = survey.margins
    ax.semilogx(frequency, _phase_deg(loop), color=BLUE)
    ax.axhline(-180.0, color=GREY, linewidth=0.8)
    if isfinite(margins.crossover_hz):
        at = margins.crossover_hz
        phase = float(np.interp(np.log(at), np.log(frequency), _phase_deg(loop)))
        ax.plot([at, at], [-180.0, phase], "-o", color=ORANGE, markersize=4)
        ax.annotate(
            f"phase margin\n{margins.phase_margin_deg:.4g}°",
            (at, 0.5 * (phase - 180.0)),
            xytext=(8, -10),
            textcoords="offset points",
            color=ORANGE,
        )
    return finish(ax, "Open loop: phase", "frequency [Hz]", "phase of L [deg]")


def plot_nichols(survey: Survey, *, ax: Axes) -> Axes:
    """Draw gain against phase of L, with the critical point and the circle |S| = peak."""
    _, loop = loop_curve(survey)
    ax.plot(_phase_deg(loop), _db(loop), color=BLUE, label="L")
    ax.plot(-180.0, 0.0, "+", color=RED, markersize=12, markeredgewidth=2, label="critical point")
    modulus = survey.margins.modulus_margin
    if modulus < 1.0:
        circle = -1.0 + modulus * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, CURVE_POINTS))
        phase = np.degrees(np.angle(-circle)) - 180.0
        label = f"|1 + L| = {modulus:.3f}"
        ax.plot(phase, _db(circle), "--", color=RED, linewidth=1.0, label=label)
    ax.set_ylim(-40.0, 40.0)
    ax.xaxis.set_major_locator(MultipleLocator(45.0))
    ax.legend(loc="lower left")
    return finish(ax, "Nichols", "phase of L [deg]", "|L| [dB]")


def plot_sensitivities(survey: Survey, *, ax: Axes) -> Axes:
    """Draw the closed loop T = L/(1 + L) and the sensitivity S = 1/(1 + L)."""
    frequency, loop = loop_curve(survey)
    margins = survey.margins
    for values, color, name, peak, at in (
        (
            loop / (1.0 + loop),
            BLUE,
            "T",
            margins.complementary_peak,
            margins.complementary_peak_hz,
        ),
        (1.0 / (1.0 + loop), GREEN, "S", margins.sensitivity_peak, margins.sensitivity_peak_hz),
    ):
        label = f"|{name}|, peak {20.0 * np.log10(peak):.2f} dB"
        ax.semilogx(frequency, _db(values), color=color, label=label)
        if 0.0 < at < inf:
            ax.plot(at, 20.0 * np.log10(peak), "o", color=color, markersize=4)
    if isfinite(margins.bandwidth_hz):
        label = f"bandwidth {margins.bandwidth_hz:.4g} Hz"
        ax.axvline(margins.bandwidth_hz, color=GREY, linestyle=":", label=label)
    ax.set_ylim(-60.0, 15.0)
    ax.legend(loc="lower left", bbox_to_anchor=(0.3, 0.0))
    return finish(ax, "Closed loop T and sensitivity S", "frequency [Hz]", "magnitude [dB]")


def plot_step(step: StepResponse, *, ax: Axes) -> Axes:
    """Draw the unit step response with its overshoot and settling time."""
    shown = step.time <= 1.6 * step.settling_time_s + step.peak_time_s
    ax.plot(step.time[shown], step.position[shown], color=BLUE)
    ax.axhline(1.0, color=GREY, linewidth=0.8)
    ax.axhspan(0.98, 1.02, color=GREY, alpha=0.2, label="±2 %")
    ax.plot(step.peak_time_s, 1.0 + step.overshoot_percent / 100.0, "o", color=ORANGE)
    late = step.peak_time_s > 0.6 * step.time[shown][-1]
    ax.annotate(
        f"overshoot {step.overshoot_percent:.2f} %",
        (step.peak_time_s, 1.0 + step.overshoot_percent / 100.0),
        xytext=(0, -18) if late else (10, -3),
        textcoords="offset points",
        ha="right" if late else "left",
        color=ORANGE,
    )
    label = f"settled at {step.settling_time_s:.3g} s"
    ax.axvline(step.settling_time_s, color=GREY, linestyle=":", label=label)
    ax.legend(loc="lower right")
    return finish(ax, "Unit step without feedforward", "time [s]", "position / step")


def loop_curve(survey: Survey) -> tuple[FloatArray, Any]:
    """Return frequencies around the crossover [Hz] and L there, up to half the samples'."""
    frequency, points = loop_frequencies(survey)
    return frequency, survey.loop.open_model()(points)


def loop_frequencies(survey: Survey) -> tuple[FloatArray, Any]:
    """Return frequencies around the crossover [Hz], and where a transfer function is taken."""
    margins = survey.margins
    centre = margins.crossover_hz
    if not 0.0 < centre < inf:
        centre = float(np.abs(decaying_poles(margins)).max()) / (2.0 * np.pi)
    frequency = centre * np.logspace(-2.0, 2.0, CURVE_POINTS)
    if survey.is_ideal:
        return frequency, 2j * np.pi * frequency
    top = frequency[-1] if margins.dt is None else 0.5 / margins.dt
    frequency = np.geomspace(frequency[0], top, CURVE_POINTS)
    own = np.abs(margins.closed_loop_poles.imag) / (2.0 * np.pi)
    if margins.dt is not None:
        own = np.abs(decaying_poles(margins).imag) / (2.0 * np.pi)
    near = (own[own > 0.0][:, None] * (1.0 + np.linspace(-0.05, 0.05, 81))).ravel()
    frequency = np.unique(np.concatenate([frequency, near, [top]]))
    frequency = frequency[(frequency >= 0.01 * centre) & (frequency <= top)]
    points = 2j * np.pi * frequency
    return frequency, points if margins.dt is None else np.exp(points * margins.dt)


def _db(values: Any) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.abs(values)))


def _phase_deg(values: Any) -> FloatArray:
    """Return the unwrapped phase, its right end within (−360, 0]."""
    phase = np.degrees(np.unwrap(np.angle(values)))
    return np.asarray(phase - 360.0 * np.ceil(phase[-1] / 360.0))
