"""Frequency responses from noise or chirps (Welch) and from stepped sines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .periodic import Estimate, levelled
from .rational_fits import Complex, Real

_EFFECTIVE = 0.947  # of the segments: Hann's window, half overlapping
_FIRST = 3  # lines that leakage of drift falls into
_EXCITED = 1e-8  # of the largest power of the excitation
_SETTLING = 0.5  # of a dwell
_BLOCKS = 8


def welch(w: Real, u: Real, y: Real, dt: float, segment: int) -> tuple[Estimate, Real]:
    """Return responses by G = S_yw/S_uw, and the coherence of w and y.

    With v = y − G·u:  σ_G² = S_vv·S_ww/(n·|S_uw|²), n effective averages.
    """
    starts = range(0, len(w) - segment + 1, segment // 2)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(segment) / segment)
    w_, u_, y_ = (_segments(x, starts, window) for x in (w, u, y))
    count = len(w_)
    averages = _EFFECTIVE * count
    ww = (abs(w_) ** 2).mean(axis=0)
    uw, yw = ((x * w_.conj()).mean(axis=0) for x in (u_, y_))
    some = np.arange(len(ww)) >= _FIRST
    some &= (ww > _EXCITED * ww.max()) & (np.arange(len(ww)) < segment / 2)
    ww, uw, yw, w_, u_, y_ = ww[some], uw[some], yw[some], w_[:, some], u_[:, some], y_[:, some]
    plant = yw / uw

    def sigma(out: Complex, gain: Complex, by: Complex, cross: Any) -> Real:
        rest = (abs(out - gain * by) ** 2).sum(axis=0) / max(count - 1, 1)
        return np.asarray(np.sqrt(levelled(rest) * ww / averages) / abs(cross))

    coherence = abs(yw) ** 2 / (ww * (abs(y_) ** 2).mean(axis=0))
    frequency = np.flatnonzero(some) / (segment * dt)
    found = Estimate(
        frequency,
        plant,
        sigma(y_, plant, u_, uw),
        uw / ww,
        yw / ww,
        sigma(y_, yw / ww, w_, ww),
        sigma(u_, uw / ww, w_, ww),
        None,
        None,
    )
    return found, coherence


def _segments(x: Real, starts: range, window: Real) -> Complex:
    """Return the spectra of segments, their means taken off, (K, N)."""
    parts = np.stack([x[start : start + len(window)] for start in starts])
    return np.asarray(np.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * window, axis=1))


def stepped(
    w: Real, u: Real, y: Real, dt: float, dwells: Sequence[tuple[float, float, float]]
) -> Estimate:
    """Return responses of a sine that dwells on one frequency after the other.

    Of each dwell (frequency in Hz, start, end in seconds) the first part is left for settling,
    the rest cut into blocks of whole periods, whose scatter gives σ.
    """
    rows = np.array([_dwell((w, u, y), dt, *dwell) for dwell in dwells])  # (N, 3, blocks)
    count = rows.shape[2]

    def ratio(out: int, by: int) -> tuple[Complex, Real]:
        gain: Complex = rows[:, out].mean(axis=1) / rows[:, by].mean(axis=1)
        rest = (abs(rows[:, out] - gain[:, None] * rows[:, by]) ** 2).sum(axis=1) / (count - 1)
        return gain, np.asarray(np.sqrt(levelled(rest) / count) / abs(rows[:, by].mean(axis=1)))

    plant, plant_sigma = ratio(2, 1)
    process, process_sigma = ratio(2, 0)
    sensitivity, sensitivity_sigma = ratio(1, 0)
    frequency = np.array([dwell[0] for dwell in dwells], dtype=float)
    return Estimate(
        frequency,
        plant,
        plant_sigma,
        sensitivity,
        process,
        process_sigma,
        sensitivity_sigma,
        None,
        None,
    )


def _dwell(
    records: tuple[Real, Real, Real], dt: float, frequency: float, start: float, end: float
) -> list[Complex]:
    """Return the complex amplitudes of a dwell, one for each of its blocks."""
    length = len(records[0]) * dt
    if not 0.0 <= start < end <= length * (1.0 + 1e-9):
        raise ValueError(
            f"dwell at {frequency:g} Hz from {start:g} to {end:g} s: expected times within the "
            f"records, 0 to {length:g} s; give (frequency in Hz, start, end in seconds)"
        )
    first = start + _SETTLING * (end - start)
    whole = int((end - first) * frequency / _BLOCKS)
    if whole < 1:
        raise ValueError(
            f"dwell at {frequency:g} Hz from {start:g} to {end:g} s holds fewer than {_BLOCKS} "
            "periods after settling: expected more; dwell for "
            f"{_BLOCKS / frequency / (1.0 - _SETTLING):.3g} s"
        )
    amplitudes: list[Complex] = []
    for x in records:
        blocks = []
        for block in range(_BLOCKS):
            low = first + block * whole / frequency
            index = np.arange(int(np.ceil(low / dt)), int((low + whole / frequency) / dt))
            times = index * dt
            matrix = np.stack(
                [np.exp(2j * np.pi * frequency * times), np.exp(-2j * np.pi * frequency * times)], 1
            )
            basis = np.concatenate([matrix, np.ones((len(index), 1)), times[:, None] - low], axis=1)
            blocks.append(np.linalg.lstsq(basis, x[index].astype(complex), rcond=None)[0][0])
        amplitudes.append(np.array(blocks))
    return amplitudes
