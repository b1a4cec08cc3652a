"""Disturbing torques on motor or load: steps, sines, sampled ones, and wind."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import inf, pi
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..shaping.checks import finite, one_of, positive
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import real_array, shown
from ..shaping.told import Told

On = Literal["motor", "load"]


def _levels(times: ArrayLike, torques: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return increasing times and torques of the same number, read-only."""
    at = np.atleast_1d(real_array("times", times)).copy()
    values = np.atleast_1d(real_array("torques", torques)).copy()
    if at.ndim != 1 or at.shape != values.shape or not at.size:
        raise ValueError(
            f"times of shape {at.shape} with torques of shape {values.shape}: expected one torque "
            "for each time"
        )
    if not (np.isfinite(at).all() and (np.diff(at) > 0.0).all()):
        raise ValueError(f"times = {shown(times)}: expected finite, increasing times")
    if not np.isfinite(values).all():
        raise ValueError(f"torques = {shown(torques)}: expected finite torques")
    at.flags.writeable = values.flags.writeable = False
    return at, values


@dataclass(frozen=True, eq=False, repr=False)
class TorqueSteps(Told, Frozen):
    """Steps that add up: from times[i] on the torque is larger by torques[i].

    Parameters
    ----------
    times, torques : (m,) arrays
        Times increase, from the start of the response.
    on : "motor" or "load", optional
    """

    times: FloatArray
    torques: FloatArray
    _: KW_ONLY
    on: On = "motor"

    def __post_init__(self) -> None:
        one_of("on", self.on, ("motor", "load"))
        at, values = _levels(self.times, self.torques)
        object.__setattr__(self, "times", at)
        object.__setattr__(self, "torques", values)

    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return the times at which the torque changes, and to what."""
        return self.times, np.cumsum(self.torques)


@dataclass(frozen=True, eq=False, repr=False)
class SampledTorque(Told, Frozen):
    """A torque held from each time to the next, as a recording gives it; 0 before the first.

    Parameters
    ----------
    times, torques : (m,) arrays
        Times increase, from the start of the response; the last torque is held on.
    on : "motor" or "load", optional
    """

    times: FloatArray
    torques: FloatArray
    _: KW_ONLY
    on: On = "motor"

    def __post_init__(self) -> None:
        one_of("on", self.on, ("motor", "load"))
        at, values = _levels(self.times, self.torques)
        object.__setattr__(self, "times", at)
        object.__setattr__(self, "torques", values)

    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return the times at which the torque changes, and to what."""
        return self.times, self.torques


@dataclass(frozen=True)
class TorqueSine:
    """A sinusoidal torque, amplitude·sin(2π·frequency_hz·t) from the start of the response on.

    Parameters
    ----------
    amplitude : float
    frequency_hz : float
        Positive.
    on : "motor" or "load", optional
    """

    amplitude: float
    frequency_hz: float
    _: KW_ONLY
    on: On = "motor"

    def __post_init__(self) -> None:
        one_of("on", self.on, ("motor", "load"))
        object.__setattr__(self, "amplitude", finite("amplitude", self.amplitude))
        object.__setattr__(self, "frequency_hz", positive("frequency_hz", self.frequency_hz))

    @property
    def omega(self) -> float:
        """Angular frequency."""
        return 2.0 * pi * self.frequency_hz


@dataclass(frozen=True)
class Wind:
    """A stationary random torque of standard deviation `sigma`, for variances and realisations.

    Parameters
    ----------
    kind : "first_order", "double_pole" or "von_karman"
        White noise behind ω/(s + ω), behind 1/(s + ω)², or the spectrum
        4σ²τ/(1 + 70.8·(f·τ)²)^(5/6) over frequency f > 0.
    sigma : float
        Standard deviation of the torque, positive.
    corner_hz : float, optional
        ω/2π of the first two.
    length_over_speed : float, optional
        τ of von Kármán's, the length scale over the wind's speed.
    on : "motor" or "load", optional
        Default: the load.
    """

    kind: Literal["first_order", "double_pole", "von_karman"]
    sigma: float
    _: KW_ONLY
    corner_hz: float | None = None
    length_over_speed: float | None = None
    on: On = "load"

    def __post_init__(self) -> None:
        one_of("kind", self.kind, ("first_order", "double_pole", "von_karman"))
        one_of("on", self.on, ("motor", "load"))
        object.__setattr__(self, "sigma", positive("sigma", self.sigma))
        wanted, other = "corner_hz", "length_over_speed"
        if self.kind == "von_karman":
            wanted, other = other, wanted
        if getattr(self, wanted) is None or getattr(self, other) is not None:
            raise ValueError(f"kind = {self.kind!r}: give {wanted}, and not {other}")
        object.__setattr__(self, wanted, positive(wanted, getattr(self, wanted)))

    def spectrum(self, frequency_hz: ArrayLike) -> FloatArray:
        """Return the one-sided power spectral density at frequencies ≥ 0, torque² per Hz."""
        f = real_array("frequency_hz", frequency_hz)
        variance = self.sigma**2
        if self.kind == "von_karman":
            tau = float(self.length_over_speed or 0.0)
            return np.asarray(4.0 * variance * tau / (1.0 + 70.8 * (f * tau) ** 2) ** (5.0 / 6.0))
        corner = float(self.corner_hz or 0.0)
        ratio = 1.0 + (f / corner) ** 2
        if self.kind == "first_order":
            return np.asarray(2.0 * variance / (pi * corner) / ratio)
        return np.asarray(4.0 * variance / (pi * corner) / ratio**2)

    @property
    def bends_hz(self) -> FloatArray:
        """Frequency about which it falls off."""
        return np.array([self.corner_hz or 1.0 / float(self.length_over_speed or 1.0)])

    @property
    def reach_hz(self) -> tuple[float, float]:
        """Frequencies outside of which there is nothing."""
        return 0.0, inf


Disturbance = TorqueSteps | SampledTorque | TorqueSine


def checked_disturbances(given: Any) -> tuple[Disturbance, ...]:
    """Return none, one or several disturbances as a tuple."""
    if given is None:
        return ()
    parts = tuple(given) if isinstance(given, list | tuple) else (given,)
    for part in parts:
        if not isinstance(part, TorqueSteps | SampledTorque | TorqueSine):
            random = hasattr(part, "spectrum")
            remedy = "; of a spectrum ask loop.deviations, or wind_realisation" if random else ""
            raise TypeError(
                f"disturbance = {shown(part)}: expected TorqueSteps, SampledTorque or "
                f"TorqueSine{remedy}"
            )
    return parts
