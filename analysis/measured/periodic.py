"""Frequency responses from periodic records: means over periods, noise and distortion apart.

With U and Y the means over P periods of one realisation, G = Y/U; v = y − G·u is what noise adds
to the output, and per line

    σ_n² = var(v)/(P·|U|²),   of M realisations σ² = Σ|G_m − G|²/(M(M − 1)),
    distortion of one realisation² = M(σ² − σ_n²).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .rational_fits import Complex, Real

_LOUD = 1e-4  # of the largest line of the excitation
_REACH = 7  # lines to either side over which noise is levelled


class Spectra(NamedTuple):
    """Lines of a periodic record, (M realisations, P periods, N lines)."""

    frequency_hz: Real
    w: Complex
    u: Complex
    y: Complex


class Estimate(NamedTuple):
    """G, S and PS on lines with standard deviations; None where they cannot be told."""

    frequency_hz: Real
    plant: Complex
    plant_sigma: Real | None
    sensitivity: Complex
    process: Complex
    process_sigma: Real | None
    sensitivity_sigma: Real | None
    noise: Real | None
    distortion: Real | None


def spectra(w: Real, u: Real, y: Real, dt: float, period: int) -> Spectra:
    """Return the lines that the excitation holds, records being (M, P·period)."""
    parts = [np.fft.rfft(np.reshape(x, (len(x), -1, period)), axis=2) for x in (w, u, y)]
    loud = abs(parts[0]).mean(axis=(0, 1))
    loud[0] = 0.0
    if period % 2 == 0:
        loud[-1] = 0.0
    lines = np.flatnonzero(loud > _LOUD * loud.max(initial=0.0))
    frequency = lines / (period * dt)
    w_, u_, y_ = (part[:, :, lines] for part in parts)
    return Spectra(frequency, w_, u_, y_)


def estimate(found: Spectra) -> Estimate:
    """Return responses and their standard deviations."""
    w, u, y = (part.mean(axis=1) for part in (found.w, found.u, found.y))
    plant, plant_sigma, noise, distortion = _ratio(found.u, found.y, u, y)
    process, process_sigma, _, _ = _ratio(found.w, found.y, w, y)
    sensitivity, sensitivity_sigma, _, _ = _ratio(found.w, found.u, w, u)
    return Estimate(
        found.frequency_hz,
        plant,
        plant_sigma,
        sensitivity,
        process,
        process_sigma,
        sensitivity_sigma,
        noise,
        distortion,
    )


def _ratio(
    each_u: Complex, each_y: Complex, u: Complex, y: Complex
) -> tuple[Complex, Real | None, Real | None, Real | None]:
    """Return y/u, its σ, that of noise alone, and the distortion of one realisation."""
    count, periods = each_u.shape[:2]
    of_each = y / u
    mean: Complex = of_each.mean(axis=0)
    noise = distortion = total = None
    if periods > 1:
        off = each_y - of_each[:, None] * each_u
        square = (abs(off) ** 2).sum(axis=1) / (periods - 1)
        levels = levelled(square.mean(axis=0))
        noise = np.sqrt(levels * (1.0 / abs(u) ** 2).mean(axis=0) / (periods * count))
    if count > 1:
        size = (abs(u) ** 2).mean(axis=0)
        square = (abs((of_each - mean) * u) ** 2).sum(axis=0) / (count * (count - 1))
        total = np.sqrt(levelled(square) / size)
    if noise is not None and total is not None:
        distortion = np.sqrt(np.maximum(count * (total**2 - noise**2), 0.0))
        total = np.maximum(total, noise)
    return mean, total if total is not None else noise, noise, distortion


def levelled(square: Real) -> Real:
    """Return a spectrum averaged over the lines beside each, fewer at either end."""
    count = len(square)
    places = np.arange(count)
    reach = np.minimum(_REACH, np.minimum(places // 2, (count - 1 - places)))
    total = np.concatenate([[0.0], np.cumsum(square)])
    return np.asarray((total[places + reach + 1] - total[places - reach]) / (2 * reach + 1))


def left_out_levels(
    u: Real, y: Real, dt: float, period: int, estimated: Estimate
) -> dict[str, float]:
    """Return the rms of y at the even and odd lines that the excitation leaves out, less noise.

    What is there is the distortion of even and of odd order.
    """
    parts = [np.fft.rfft(np.reshape(x, (len(x), -1, period)), axis=2) for x in (u, y)]
    lines = np.round(estimated.frequency_hz * period * dt).astype(int)
    every = np.arange(1, lines.max(initial=0))
    silent = np.setdiff1d(every, lines)
    levels = {"even": np.nan, "odd": np.nan}
    plant = np.interp(silent, lines, estimated.plant)
    off = parts[1][:, :, silent] - plant * parts[0][:, :, silent]
    mean = off.mean(axis=1)
    periods = off.shape[1]
    if periods < 2:
        return levels
    noise = (abs(off - mean[:, None]) ** 2).sum(axis=1) / (periods - 1) / periods
    power = (abs(mean) ** 2 - noise).mean(axis=0)
    for name, remainder in (("even", 0), ("odd", 1)):
        some = power[silent % 2 == remainder]
        if some.size:
            levels[name] = float(np.sqrt(max(2.0 * some.sum(), 0.0)) / period)
    return levels
