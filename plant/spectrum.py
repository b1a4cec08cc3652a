"""Power spectral densities given as a table: of a disturbing torque, or of noise."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import ceil, log, sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..shaping.checks import one_of, positive
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import real_array, shown
from ..shaping.told import Told
from .disturbances import On

_MOST_FOLDS = 10_000


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(Told, Frozen):
    """A stationary random signal, by its one-sided power spectral density at some frequencies.

    Between them log(density) is a straight line over log(frequency); outside there is nothing.

    Parameters
    ----------
    frequencies_hz : (n,) array
        Increasing, positive, n ≥ 2.
    densities : (n,) array
        Unit² per Hz of a torque, or of a measured position; positive.
    on : "motor" or "load", optional
        Where a torque acts; of noise it is not looked at. Default: the load.

    Examples
    --------
    >>> Spectrum([1.0, 10.0], [2.0, 2.0]).variance
    18.0
    """

    frequencies_hz: FloatArray
    densities: FloatArray
    _: KW_ONLY
    on: On = "load"

    def __post_init__(self) -> None:
        one_of("on", self.on, ("motor", "load"))
        for name in ("frequencies_hz", "densities"):
            values = np.atleast_1d(real_array(name, getattr(self, name))).copy()
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        f, density = self.frequencies_hz, self.densities
        if f.ndim != 1 or f.shape != density.shape or f.size < 2:
            raise ValueError(
                f"frequencies_hz of shape {f.shape} with densities of shape {density.shape}: "
                "expected two or more frequencies, each with its density"
            )
        if not (np.isfinite(f).all() and (np.diff(f) > 0.0).all()):
            raise ValueError(
                f"frequencies_hz = {shown(f.tolist())}: expected finite, increasing ones"
            )
        for name, values in (("frequencies_hz", f), ("densities", density)):
            if not (np.isfinite(values).all() and values.min() > 0.0):
                raise ValueError(
                    f"{name}: {shown(float(values.min()))} has no logarithm, in which the table is "
                    "interpolated: expected positive numbers; leave out points at 0 Hz, and those "
                    "of density 0 at either end"
                )

    def spectrum(self, frequency_hz: ArrayLike) -> FloatArray:
        """Return the density at frequencies ≥ 0, unit² per Hz."""
        f = real_array("frequency_hz", frequency_hz)
        low, high = self.reach_hz
        inside = (f >= low) & (f <= high)
        at = np.log(np.where(inside, f, low))
        lines = np.interp(at, np.log(self.frequencies_hz), np.log(self.densities))
        return np.where(inside, np.exp(lines), 0.0)

    @property
    def variance(self) -> float:
        """The integral over frequency."""
        f, density = self.frequencies_hz, self.densities
        total = 0.0
        for i in range(f.size - 1):
            width = log(f[i + 1] / f[i])
            rise = log(f[i + 1] * density[i + 1]) - log(f[i] * density[i])
            mean = np.expm1(rise) / rise if rise else 1.0
            total += float(f[i] * density[i] * width * mean)
        return total

    @property
    def sigma(self) -> float:
        """Standard deviation."""
        return sqrt(self.variance)

    @property
    def bends_hz(self) -> FloatArray:
        """Frequencies between which it is smooth."""
        return self.frequencies_hz

    @property
    def reach_hz(self) -> tuple[float, float]:
        """Frequencies outside of which there is nothing."""
        return float(self.frequencies_hz[0]), float(self.frequencies_hz[-1])


@dataclass(frozen=True, eq=False)
class Folded:
    """A spectrum as samples show it: what is above half the sample rate is seen below it."""

    of: Spectrum
    dt: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "dt", positive("dt", self.dt))
        if self._folds > _MOST_FOLDS:
            raise ValueError(
                f"frequencies_hz up to {self.of.reach_hz[1]:.6g} with dt = "
                f"{shown(self.dt)}: expected "
                f"at most {_MOST_FOLDS} times the sample rate; end the table there"
            )

    @property
    def _folds(self) -> float:
        return self.of.reach_hz[1] * self.dt

    def spectrum(self, frequency_hz: ArrayLike) -> FloatArray:
        """Return the density at frequencies from 0 to half the sample rate, unit² per Hz."""
        f = real_array("frequency_hz", frequency_hz)
        total = self.of.spectrum(f)
        for j in range(1, ceil(self._folds + 0.5) + 1):
            total = total + self.of.spectrum(j / self.dt - f) + self.of.spectrum(j / self.dt + f)
        return np.asarray(total)

    @property
    def bends_hz(self) -> FloatArray:
        """Frequencies between which it is smooth."""
        turns = self.of.frequencies_hz * self.dt
        bends = np.abs(turns - np.round(turns)) / self.dt
        return np.unique(np.append(bends[bends > 0.0], 0.5 / self.dt))

    @property
    def reach_hz(self) -> tuple[float, float]:
        """Frequencies outside of which there is nothing."""
        lowest = self.of.reach_hz[0] if self._folds <= 0.5 else 0.0
        return lowest, 0.5 / self.dt
