"""Input shapers ZV, ZVD, ZVDD and EI: a command as a sum of delayed parts of itself, exact.

Vibration that one part excites, a later one cancels. All parts are positive and add up to 1, so
that every bound which the command keeps is kept, and a move has the same length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb, exp, inf, pi, sqrt
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite, of_kind, one_of, positive, range_error
from .frozen import Frozen
from .pieces import FloatArray
from .real_numbers import real_array, shown
from .told import Told
from .trajectory import Motion, Trajectory, as_trajectory, sum_of

Kind = Literal["ZV", "ZVD", "ZVDD", "EI"]


@dataclass(frozen=True, eq=False, repr=False)
class InputShaper(Told, Frozen):
    """A command becomes Σ amplitudes[i]·command(t − times[i]).

    Parameters
    ----------
    times : (n,) array
        Increasing, the first one 0.
    amplitudes : (n,) array
        Positive; they are divided by their sum.

    Raises
    ------
    ValueError
        For times that do not increase from 0, or an amplitude that is not positive: a negative
        one would break the bounds of the command.
    """

    times: FloatArray
    amplitudes: FloatArray

    def __post_init__(self) -> None:
        times = np.atleast_1d(real_array("times", self.times)).copy()
        amplitudes = np.atleast_1d(real_array("amplitudes", self.amplitudes)).copy()
        if times.ndim != 1 or times.shape != amplitudes.shape or not times.size:
            raise ValueError(
                f"times of shape {times.shape} with amplitudes of shape {amplitudes.shape}: "
                "expected one amplitude for each time"
            )
        rising = times[0] == 0.0 and bool((np.diff(times) > 0.0).all())
        if not rising or not np.isfinite(times).all():
            raise ValueError(f"times = {shown(self.times)}: expected times that increase from 0")
        if not ((amplitudes > 0.0) & np.isfinite(amplitudes)).all():
            raise ValueError(
                f"amplitudes = {shown(self.amplitudes)}: expected positive numbers; with a "
                "negative one the command would leave its bounds"
            )
        amplitudes /= amplitudes.max()
        amplitudes /= amplitudes.sum()
        times.flags.writeable = amplitudes.flags.writeable = False
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "amplitudes", amplitudes)

    @property
    def duration(self) -> float:
        """By how much a shaped command is longer."""
        return float(self.times[-1])

    def shape(self, trajectory: Motion) -> Trajectory:
        """Return the shaped command, an exact trajectory that keeps all bounds of the given one."""
        parts = [as_trajectory(trajectory).delay(time) for time in self.times.tolist()]
        return sum_of(parts, self.amplitudes.tolist())

    def then(self, other: InputShaper) -> InputShaper:
        """Return both shapers in series, which null the modes of both."""
        of_kind("other", other, InputShaper, "an InputShaper, as input_shaper gives")
        times = (self.times[:, None] + other.times).ravel()
        amplitudes = np.outer(self.amplitudes, other.amplitudes).ravel()
        distinct, place = np.unique(times, return_inverse=True)
        return InputShaper(distinct, np.bincount(place.ravel(), amplitudes).astype(float))

    def residual(self, frequency_hz: ArrayLike, damping: float = 0.0) -> FloatArray:
        """Return the vibration that is left of a mode, over that without a shaper.

            e^(−ζω·t_n)·|Σ A_i·e^(ζω·t_i + jω_d·t_i)|

        Parameters
        ----------
        frequency_hz : float or array
            Natural frequency of the mode; over frequencies it is the sensitivity curve.
        damping : float, optional
            ζ, from 0 to below 1.
        """
        zeta = _damping(damping)
        omega = 2.0 * pi * np.asarray(real_array("frequency_hz", frequency_hz))
        decay, damped = zeta * omega, omega * sqrt(1.0 - zeta * zeta)
        left = np.exp(-np.multiply.outer(decay, self.times[-1] - self.times))
        turning = np.exp(1j * np.multiply.outer(damped, self.times))
        return np.asarray(np.abs((self.amplitudes * left * turning).sum(axis=-1)))


def input_shaper(
    kind: Kind,
    frequency_hz: float | Sequence[float],
    damping: float | Sequence[float] = 0.0,
    *,
    vibration: float = 0.05,
) -> InputShaper:
    """Return an input shaper that nulls one mode, or several.

    With K = e^(−πζ/√(1 − ζ²)) and half a damped period h, ZV has parts 1, K at 0, h; ZVD 1, 2K,
    K² at 0, h, 2h; ZVDD 1, 3K, 3K², K³; EI three that leave `vibration` at the mode itself and
    none at a frequency on either side of it.

    Parameters
    ----------
    kind : "ZV", "ZVD", "ZVDD" or "EI"
        In order of robustness against a wrong frequency, and of duration.
    frequency_hz : float or sequence of floats
        Natural frequencies. With a stiff loop on the motor the mode of the load is the one with
        the motor held (`antiresonance_hz`).
    damping : float or sequence of floats, optional
        Their damping ratios.
    vibration : float, optional
        What EI leaves at the mode, between 0 and 1. Default: 5 %.

    Returns
    -------
    InputShaper
        For several modes those of each in series.

    References
    ----------
    Singer and Seering 1990; Singhose, Seering and Singer 1994.

    Examples
    --------
    >>> shaper = input_shaper("ZV", 5.0)
    >>> shaper.times.tolist(), shaper.amplitudes.tolist()
    ([0.0, 0.1], [0.5, 0.5])
    """
    one_of("kind", kind, ("ZV", "ZVD", "ZVDD", "EI"))
    frequencies = np.atleast_1d(real_array("frequency_hz", frequency_hz))
    dampings = real_array("damping", damping)
    if frequencies.ndim != 1 or not frequencies.size:
        raise ValueError(
            f"frequency_hz = {shown(frequency_hz)}: expected a frequency, or a row of them"
        )
    if dampings.shape not in ((), frequencies.shape):
        raise ValueError(
            f"damping = {shown(damping)} with {frequencies.size} frequencies: expected one number, "
            "or one for each"
        )
    dampings = np.broadcast_to(dampings, frequencies.shape)
    shapers = [
        _one_mode(kind, positive("frequency_hz", f), _damping(z), vibration)
        for f, z in zip(frequencies.tolist(), dampings.tolist(), strict=True)
    ]
    whole, *others = shapers
    for other in others:
        whole = whole.then(other)
    return whole


def _damping(value: float) -> float:
    zeta = finite("damping", value)
    if not 0.0 <= zeta < 1.0:
        raise ValueError(
            f"damping = {value!r}: expected a damping ratio from 0 to below 1 (1 % is 0.01)"
        )
    return zeta


def _one_mode(kind: Kind, frequency_hz: float, zeta: float, vibration: float) -> InputShaper:
    half = 0.5 / (frequency_hz * sqrt(1.0 - zeta * zeta))
    if not 0.0 < half < inf:
        raise range_error()
    if kind == "EI":
        if not 0.0 < finite("vibration", vibration) < 1.0:
            raise ValueError(f"vibration = {vibration!r}: expected a part between 0 and 1")
        middle, first, last = _extra_insensitive(zeta, vibration)
        return InputShaper(
            np.array([0.0, 2.0 * half * middle, 2.0 * half]),
            np.array([first, 1.0 - first - last, last]),
        )
    count = {"ZV": 1, "ZVD": 2, "ZVDD": 3}[kind]
    k = exp(-pi * zeta / sqrt(1.0 - zeta * zeta))
    parts = [comb(count, i) * k**i for i in range(count + 1)]
    return InputShaper(half * np.arange(count + 1.0), np.array(parts))


def _extra_insensitive(zeta: float, vibration: float) -> tuple[float, float, float]:
    """Return the second time over the damped period, the first amplitude and the last.

    Of three parts, the last a damped period behind the first: `vibration` is left at the mode,
    none at two frequencies about it, each an equation for real and imaginary part. Newton's
    iteration starts from the undamped mode, which has a closed form, in steps of the damping.
    """
    v = vibration
    ratio = float(np.arccos(-(1.0 - v) / (1.0 + v)) / pi)
    x = np.array([0.5, 0.25 * (1.0 + v), 0.25 * (1.0 + v), ratio, 2.0 - ratio])
    for part in np.linspace(0.0, zeta, int(50.0 * zeta) + 2)[1:] if zeta else ():
        x = _solved(x, part, v)
        if not (0.0 < x[0] < 1.0 and min(x[1], x[2], 1.0 - x[1] - x[2]) > 0.0):
            raise ValueError(
                f"damping = {zeta!r}: no EI shaper of positive parts leaves {v!r}; use 'ZVD', or "
                "a smaller vibration"
            )
    return float(x[0]), float(x[1]), float(x[2])


def _solved(x: FloatArray, zeta: float, vibration: float) -> FloatArray:
    """Return the solution of the EI shaper's equations near another one, NaN without one."""
    for _ in range(20):
        try:
            with np.errstate(all="ignore"):
                step = np.linalg.solve(_slopes(x, zeta, vibration), _misses(x, zeta, vibration))
        except np.linalg.LinAlgError:
            return np.full_like(x, np.nan)
        x = x - step
        if np.abs(step).max() < 1e-15:
            break
    return x


def _misses(x: FloatArray, zeta: float, vibration: float) -> FloatArray:
    """Return by how much the equations of the EI shaper are missed."""
    middle, first, last, low, high = x
    amplitudes = np.array([first, 1.0 - first - last, last])
    times = 2.0 * pi * np.array([0.0, middle, 1.0])  # of the damped mode's phase
    loss = zeta / sqrt(1.0 - zeta * zeta)
    left = [
        (amplitudes * np.exp((loss + 1j) * r * times - loss * r * times[-1])).sum()
        for r in (1.0, low, high)
    ]
    at_mode = abs(left[0]) - vibration
    return np.array([at_mode, left[1].real, left[1].imag, left[2].real, left[2].imag])


def _slopes(x: FloatArray, zeta: float, vibration: float) -> FloatArray:
    """Return derivatives of what is missed, by central differences."""
    step = 1e-6
    columns = [
        (_misses(x + step * unit, zeta, vibration) - _misses(x - step * unit, zeta, vibration))
        / (2.0 * step)
        for unit in np.eye(5)
    ]
    return np.array(columns).T
