"""Estimating frequency responses from records of an excitation, plant input and output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np

from ...shaping.checks import positive, whole
from ...shaping.frozen import Frozen
from ...shaping.real_numbers import real_array
from ...shaping.told import Told
from .averaged import stepped, welch
from .measured_response import MeasuredResponse
from .periodic import Estimate, estimate, left_out_levels, spectra
from .rational_fits import Real

_SEGMENTS = 12
_LEAST = 16  # samples
_LOW = 0.3  # coherence of w below which a line is not to be trusted


@dataclass(frozen=True, eq=False, repr=False)
class EstimatedFRF(Told, Frozen):
    """Responses estimated from records, all on the same lines.

    Attributes
    ----------
    plant, sensitivity, process_sensitivity : MeasuredResponse
        G = y/u, S = u/w and PS = y/w with their standard deviations.
    noise : (N,) array or None
        Standard deviation of G by noise alone, of periodic records.
    distortion : (N,) array or None
        Standard deviation of G in one realisation by nonlinear distortion, of several.
    even_distortion, odd_distortion : float
        Rms of the output at the even and odd lines that the excitation leaves out, less noise;
        nan where it leaves none.
    coherence : (N,) array or None
        Of w and y, of noise and chirps.
    warnings : tuple of str
    """

    plant: MeasuredResponse
    sensitivity: MeasuredResponse
    process_sensitivity: MeasuredResponse
    noise: Real | None = None
    distortion: Real | None = None
    even_distortion: float = nan
    odd_distortion: float = nan
    coherence: Real | None = None
    warnings: tuple[str, ...] = ()


def estimate_frf(
    excitation: Any,
    u: Any,
    y: Any,
    dt: float,
    *,
    period: int | None = None,
    settling: int = 1,
    segment: int | None = None,
    dwells: Sequence[tuple[float, float, float]] | None = None,
    integrators: int | None = None,
    unstable_poles: int | None = None,
) -> EstimatedFRF:
    """Return the plant's response, S and PS from records, right in closed loop, too.

        G = S_yw/S_uw,   S = S_uw/S_ww,   PS = S_yw/S_ww

    by the joint input-output method: in closed loop S_yu/S_uu tends to −1/C where disturbances
    rule, with a splendid coherence.

    Parameters
    ----------
    excitation : (n,) or (M, n) array
        w, added to the plant's input; M realisations. One period of it will do, where `period`
        says how long it is. In open loop: u itself.
    u, y : (n,) or (M, n) array
        Input of the plant as it is sent, w included, and its output as it is read.
    dt : float
        Sample time in seconds.
    period : int, optional
        Samples in a period of a periodic excitation. Default: none, Welch's method (noise, chirp).
    settling : int, optional
        Periods at the start that are left out.
    segment : int, optional
        Samples in a segment of Welch's method; 4/(ζ·f·dt) of the lightest mode, at least.
        Default: a twelfth of the records.
    dwells : sequence of (frequency in Hz, start, end in seconds), optional
        Of a stepped sine.
    integrators, unstable_poles : int, optional
        Of the plant, as in `MeasuredResponse`.

    Returns
    -------
    EstimatedFRF

    Raises
    ------
    ValueError
        Without excitation, for records of unequal length, that are not finite, shorter than a
        period after settling, or constant.
    """
    dt = positive("dt", dt)
    w, u, y = _records(excitation, u, y, period)
    if dwells is not None:
        found, coherence = stepped(w[0], u[0], y[0], dt, dwells), None
    elif period is not None:
        settling = whole("settling", settling, 0, 10**6)
        cut = settling * period
        periods = (w.shape[1] - cut) // period
        if periods < 1:
            raise ValueError(
                f"records of {w.shape[1]} samples are {w.shape[1] / period:.3g} periods of "
                f"{period}, of which {settling} are for settling: expected one more at the least; "
                "measure longer, or give settling=0"
            )
        w, u, y = (x[:, cut : cut + periods * period] for x in (w, u, y))
        found, coherence = estimate(spectra(w, u, y, dt, period)), None
    else:
        if w.shape[1] < _LEAST:
            raise ValueError(
                f"records of {w.shape[1]} samples: expected {_LEAST} or more; measure longer"
            )
        size = max(_LEAST, w.shape[1] // _SEGMENTS) if segment is None else segment
        size = whole("segment", size, _LEAST, w.shape[1]) // 2 * 2
        found, coherence = welch(w.ravel(), u.ravel(), y.ravel(), dt, size)
    levels = {"even": nan, "odd": nan}
    if period is not None and dwells is None:
        levels = left_out_levels(u, y, dt, period, found)
    return _result(found, dt, coherence, levels, (integrators, unstable_poles))


def _records(excitation: Any, u: Any, y: Any, period: int | None) -> tuple[Real, Real, Real]:
    """Return the three records as (M, n) arrays."""
    if excitation is None:
        raise ValueError(
            "excitation is None: the coherence of u and y says nothing in closed loop; give the "
            "excitation, which in open loop is u itself"
        )
    named = (("excitation", excitation), ("u", u), ("y", y))
    w, u, y = (np.atleast_2d(real_array(name, value)) for name, value in named)
    for name, record in (("excitation", w), ("u", u), ("y", y)):
        if record.ndim != 2 or record.size == 0:
            raise ValueError(
                f"{name} of shape {record.shape}: expected a record, or one in each row; give (n,) "
                "or (M, n) samples"
            )
    if period is not None:
        period = whole("period", period, 4, max(u.shape[-1], 4))
        if w.shape[1] == period and u.shape[1] > period:
            w = np.tile(w, (1, -(-u.shape[1] // period)))[:, : u.shape[1]]
    lengths = {"excitation": w.shape, "u": u.shape, "y": y.shape}
    if len(set(lengths.values())) > 1:
        told = ", ".join(
            f"{name} {shape[1]}" + (f" (of {shape[0]})" if shape[0] > 1 else "")
            for name, shape in lengths.items()
        )
        raise ValueError(
            f"records of unequal length, in samples: {told}; expected as many of each; cut the "
            "longer ones at their end"
        )
    for name, record in (("excitation", w), ("u", u), ("y", y)):
        if not np.isfinite(record).all():
            at = int(np.argmin(np.isfinite(record).all(axis=0)))
            raise ValueError(f"{name} is not finite at sample {at}: expected numbers; cut it out")
        if np.ptp(record) == 0.0:
            raise ValueError(f"{name} is constant: expected a record that moves; check the channel")
    return w, u, y


def _result(
    found: Estimate,
    dt: float,
    coherence: Real | None,
    levels: dict[str, float],
    declared: tuple[int | None, int | None],
) -> EstimatedFRF:
    integrators, unstable = declared
    warnings = []
    if coherence is not None and (coherence < _LOW).any():
        low = found.frequency_hz[coherence < _LOW]
        warnings.append(
            f"coherence of excitation and output is below {_LOW:g} on {low.size} lines from "
            f"{low[0]:.4g} to {low[-1]:.4g} Hz: excite more there, or measure longer"
        )

    def response(kind: Any, values: Any, sigma: Any) -> MeasuredResponse:
        return MeasuredResponse(
            found.frequency_hz,
            values,
            sigma,
            kind=kind,
            dt=dt,
            integrators=integrators if kind == "plant" else None,
            unstable_poles=unstable,
        )

    return EstimatedFRF(
        response("plant", found.plant, found.plant_sigma),
        response("sensitivity", found.sensitivity, found.sensitivity_sigma),
        response("process-sensitivity", found.process, found.process_sigma),
        found.noise,
        found.distortion,
        levels["even"],
        levels["odd"],
        coherence,
        tuple(warnings),
    )
