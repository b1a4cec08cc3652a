"""The margins of a measured loop, with error bars by the delta method."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from .controller_values import ControllerValues, controller_values
from .conversions import Factored, factored_loop
from .crossings import Crossings, gain_crossings, phase_crossings
from .extremes import Extreme, complementary_inverse, disk, distance, least_of
from .loop_grid import RADIUS, LoopGrid, loop_grid
from .measured_response import MeasuredResponse, as_measured
from .result import MeasuredMargins
from .stability import Stability, lowest_slope_and_phase, relative_stability, stability
from .warnings_of_data import warnings_of
from .worst_cases import (
    worst_complementary,
    worst_disk,
    worst_distance,
    worst_gains,
    worst_phase,
)

_DB = 20.0 / np.log(10.0)
_REACH = sqrt(2.0) * RADIUS  # of a circle, in standard deviations along one direction


def measured_margins(
    measured: MeasuredResponse, controller: Any = None, *, measured_with: Any = None
) -> MeasuredMargins:
    """Return the margins of a measured loop, each with its standard deviation and worst case.

    Between lines L is interpolated by local rational fits of what was measured, times the exact
    controller. With s the relative complex standard deviation of L, a' and p' the slopes of
    ln|L| and arg L by ln ω,

        sd(ω_c)/ω_c = s/(√2|a'|),      sd(PM) = s/√2·√(1 + (p'/a')²),
        sd(GM) = 8.686 dB·s/√2·√(1 + (a'/p')²),      sd(|1 + L|) = s_L/√2.

    Parameters
    ----------
    measured : MeasuredResponse or control.FrequencyResponseData
        A plant or PS with a controller, or a loop, S or T.
    controller : Controller, PID, CascadedPI or python-control system, optional
    measured_with : the same, optional
        The controller that a plant was measured with. That loop ran, hence was stable: the count
        relative to it needs neither integrators nor unstable poles to be declared.

    Raises
    ------
    ValueError
        For a controller where the response has one already, none where it needs one, or one of
        another sample time.
    """
    measured = as_measured(measured, plant=controller is not None)
    parts = factored_loop(measured, controller)
    if measured_with is not None and measured.kind != "plant":
        raise ValueError(
            f"measured_with of a response of kind {measured.kind!r}: expected it with "
            "kind='plant', to compare another controller with; leave it out"
        )
    before = controller_values(measured_with, measured)
    grid = loop_grid(parts, *([before] if measured_with is not None else []))
    gains, phases = gain_crossings(grid), phase_crossings(grid)
    verdict = _verdict(grid, parts, before if measured_with is not None else None)
    values = {} if verdict.stable is False else _margins(grid, gains, phases)
    return MeasuredMargins(
        stable=verdict.stable,
        reasons=verdict.reasons,
        warnings=(*verdict.assumed, *warnings_of(grid, gains, phases, values)),
        crossovers_hz=tuple(gains.frequency_hz.tolist()),
        crossovers_hz_sigma=tuple(_crossover_sigmas(gains).tolist()),
        phase_crossovers_hz=tuple(phases.frequency_hz.tolist()),
        dt=measured.dt if measured.dt is not None else parts.controller.dt,
        **values,
    )


def _verdict(grid: LoopGrid, parts: Factored, before: ControllerValues | None) -> Stability:
    if before is None:
        return stability(grid, parts)
    return relative_stability(grid, parts, before)


def _margins(grid: LoopGrid, gains: Crossings, phases: Crossings) -> dict[str, float]:
    """Return every margin that was measured, by field name."""
    if not gains.frequency_hz.size:
        return {}
    return {
        **_of_phase(grid, gains),
        **_of_gain(grid, phases),
        **_of_distances(grid),
        **_bandwidth(grid),
    }


def _crossover_sigmas(gains: Crossings) -> Any:
    relative = gains.sigma / abs(gains.value) / sqrt(2.0)
    return gains.frequency_hz * relative / np.maximum(abs(gains.slope.real), 1e-12)


def _of_phase(grid: LoopGrid, gains: Crossings) -> dict[str, float]:
    """Phase and delay margin at their crossovers."""
    left = np.angle(-gains.value)
    at = int(np.argmin(abs(left)))
    relative = gains.sigma / abs(gains.value) / sqrt(2.0)
    a = np.where(abs(gains.slope.real) > 1e-12, gains.slope.real, 1e-12)
    p = gains.slope.imag
    lag = left % (2.0 * np.pi)
    omega = 2.0 * np.pi * gains.frequency_hz
    by_delay = int(np.argmin(lag / omega))
    spread = relative / omega * np.sqrt(1.0 + ((lag - p) / a) ** 2)
    worst, worst_delay = worst_phase(grid, gains)
    return {
        "crossover_hz": float(gains.frequency_hz[at]),
        "crossover_hz_sigma": float(_crossover_sigmas(gains)[at]),
        "phase_margin_deg": float(np.degrees(abs(left[at]))),
        "phase_margin_deg_sigma": float(
            np.degrees(relative[at] * sqrt(1.0 + (p[at] / a[at]) ** 2))
        ),
        "phase_margin_deg_worst": worst,
        "delay_margin_s": float((lag / omega)[by_delay]),
        "delay_margin_s_sigma": float(spread[by_delay]),
        "delay_margin_s_worst": worst_delay,
        "delay_margin_hz": float(gains.frequency_hz[by_delay]),
    }


def _of_gain(grid: LoopGrid, phases: Crossings) -> dict[str, float]:
    """Lower and upper gain margin, where a phase crossover limits them."""
    values: dict[str, float] = {}
    size = abs(phases.value)
    p = np.where(abs(phases.slope.imag) > 1e-12, phases.slope.imag, 1e-12)
    spread = _DB * phases.sigma / size / sqrt(2.0) * np.sqrt(1.0 + (phases.slope.real / p) ** 2)
    worst = worst_gains(grid, phases)
    for name, side, least in zip(("lower", "upper"), (1.0, -1.0), worst, strict=True):
        margin = side * _DB * np.log(size)
        some = np.flatnonzero(margin > 0.0)
        if some.size:
            at = int(some[np.argmin(margin[some])])
            values |= {
                f"{name}_gain_margin_db": float(margin[at]),
                f"{name}_gain_margin_db_sigma": float(spread[at]),
                f"{name}_gain_margin_db_worst": least,
                f"{name}_gain_margin_hz": float(phases.frequency_hz[at]),
            }
    return values


def _of_distances(grid: LoopGrid) -> dict[str, float]:
    """Modulus and disk margin and the peaks of S and T, but those at an end of the lines."""
    values: dict[str, float] = {}
    nearest = least_of(grid, distance)
    if nearest is not None:
        least = nearest.least
        bar = nearest.sigma / sqrt(2.0)
        worst = min(worst_distance(grid), max(0.0, least - bar * _REACH))
        values |= _named("modulus_margin", least, bar, worst, nearest)
        peak = np.inf if worst == 0.0 else 1.0 / worst
        values |= _named("sensitivity_peak", 1.0 / least, bar / least**2, peak, nearest)
    in_disk = least_of(grid, disk)
    if in_disk is not None:
        bar = in_disk.least * abs(2.0 / (1.0 - in_disk.value**2)) * in_disk.sigma / sqrt(2.0)
        worst = min(worst_disk(grid), max(0.0, in_disk.least - bar * _REACH))
        values |= _named("disk_margin", in_disk.least, bar, worst, in_disk)
    of_t = least_of(grid, complementary_inverse)
    if of_t is not None:
        bar = of_t.sigma / abs(1.0 + of_t.value) ** 2 / sqrt(2.0)
        worst = max(worst_complementary(grid), 1.0 / of_t.least + bar * _REACH)
        values |= _named("complementary_peak", 1.0 / of_t.least, bar, worst, of_t)
    return values


def _named(name: str, value: float, sigma: float, worst: float, at: Extreme) -> dict[str, float]:
    return {
        name: value,
        f"{name}_sigma": sigma,
        f"{name}_worst": worst,
        f"{name}_hz": at.frequency_hz,
    }


def _bandwidth(grid: LoopGrid) -> dict[str, float]:
    """Where |T| first falls to 1/√2, of a loop that has an integrator by its slope."""
    slope, _ = lowest_slope_and_phase(grid)
    size = abs(grid.value / (1.0 + grid.value))
    below = np.flatnonzero((size[1:] < sqrt(0.5)) & (size[:-1] >= sqrt(0.5)) & grid.joined)
    if slope > -0.5 or not below.size or size[0] < sqrt(0.5):
        return {}
    at = int(below[0])
    share = (size[at] - sqrt(0.5)) / (size[at] - size[at + 1])
    frequency = grid.frequency_hz[at : at + 2]
    place = float(frequency[0] + share * (frequency[1] - frequency[0]))
    fall = abs(size[at + 1] - size[at]) / (frequency[1] - frequency[0])
    bar = grid.sigma[at] / abs(1.0 + grid.value[at]) ** 2 / sqrt(2.0) / max(fall, 1e-300)
    return {"bandwidth_hz": place, "bandwidth_hz_sigma": float(bar)}
