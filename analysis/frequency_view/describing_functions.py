"""Describing functions: gain and phase of rate limiters and followers, and a period of motion."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import CommandFollower, Limits
from ...shaping.checks import finite
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from .periodic import (
    follower_cycle,
    follower_harmonic,
    follower_states,
    rate_limited,
    rate_limited_harmonic,
)
from .sine_sweep import SAMPLES_PER_PERIOD, checked_sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...shaping.pieces import FloatArray
    from .periodic import ComplexArray, Counts

_NEARLY = 0.01  # how far from repeating a few sampled followers may remain


@dataclass(frozen=True, eq=False)
class DescribingFunction(Frozen):
    """N(A, ω): first harmonic of the output over the sine A·sin ωt that is put in.

    Attributes
    ----------
    amplitude, omega : arrays
        Of one shape. Frequencies in radians per time unit.
    response : complex array
        N, of the same shape.
    """

    amplitude: FloatArray
    omega: FloatArray
    response: ComplexArray

    @property
    def gain_db(self) -> FloatArray:
        """20·log10 |N|."""
        return np.asarray(20.0 * np.log10(np.abs(self.response)))

    @property
    def phase_deg(self) -> FloatArray:
        """Phase of N in degrees, within (−270, 90]: shapers lag."""
        phase = np.degrees(np.angle(self.response))
        return np.asarray(np.where(phase > 90.0, phase - 360.0, phase))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the gain over frequency; without an Axes in pyplot's figure, the phase below."""
        drawn: Axes = draw(self, ax)
        return drawn

    def __repr__(self) -> str:
        return f"DescribingFunction(shape={self.response.shape})"


def describing_function(
    shaper: Limits | CommandFollower,
    amplitude: ArrayLike,
    omega: ArrayLike,
    *,
    command_velocity: bool = False,
    samples_per_period: int | None = None,
) -> DescribingFunction:
    """Return the describing function of a rate limiter or a follower of commands.

        N(A, ω) = (2j/(A·T))·∫ y(t)·e^(−jωt) dt   over a period T = 2π/ω,

    with y what comes out, once it repeats, when A·sin ωt goes in. The **rate limiter** is
    `Limits(velocity=V)`: it follows where it can and else moves towards the command at V. With
    λ = A·ω/V, N = 1 to λ = 1; N = (4/(πλ))·e^(−j·arccos(π/(2λ))), of a triangle wave, from
    λ = √(1 + π²/4) = 1.862 on; between them it lags on a part of each half period, and N is the
    integral over that ramp in closed form, its end found to the last digits.

    A **follower** is a `CommandFollower`, or limits of order 2 or 3. It holds the command
    A·sin(ωk·dt) for the sample that begins at k·dt.

    Parameters
    ----------
    shaper : Limits or CommandFollower
        With the same bounds in both directions. A jerk filter behind the follower multiplies N.
    amplitude, omega : arrays
        A and ω (radians per time unit), positive; broadcast together: for a sweep of M
        amplitudes and N frequencies give `amplitude[:, None]` and `omega`.
    command_velocity : bool, optional
        Whether the follower is told the velocity A·ω·cos(ωk·dt), too: then it lags on no sine
        that is within its bounds. The rate limiter takes no notice of it.
    samples_per_period : int, optional
        Of a follower given by its limits: dt = T/samples_per_period; even, 8 to 20000. Default:
        1024.

    Returns
    -------
    DescribingFunction
        For a `CommandFollower`, whose dt is given, with the nearest frequencies of which a period
        is an even number of samples.

    Raises
    ------
    TypeError
        For another shaper. Those that are linear have a `frequency_response`.
    ValueError
        For amplitudes or frequencies that are not positive, bounds that differ between
        directions, a follower with a period of position, and fewer than 8 or more than 20000
        samples per period.
    RuntimeError
        Where no motion is found that repeats within 1 % of its size.

    Notes
    -----
    N depends on λ alone for a rate limiter, and on the acceleration over A·ω² and the jerk over
    A·ω³, too, for a follower. A follower of order 2 whose commands have no velocity is bang-bang
    where α = acceleration/(A·ω²) is below 8/π² and V/(A·ω) above πα/2: then |N| = 4α/π, and the
    phase tends to −180° + arcsin(π²·α/8) with many samples per period.

    For the rate limiter N is exact to 1e-15. For a follower the pieces of its motion are
    integrated exactly, within each sample, too, over a half period that mirrors itself: its
    ends agree to 1e-11 of the output's size. One point in 1000, near α = 8/π² one in 100, has
    none that was found, and there they differ by up to 1 % of that size. A sampled follower
    can have other steady motions beside, about a sample's worth away. Sampling itself delays:
    with n samples per period N differs by up to 7/n from what it tends to with many (more near
    α = 8/π²), and by some 30/n² where the velocity is commanded and the sine is within the
    bounds. In a large sweep a point of order 2 takes about 0.5 ms; one of order 3 about a second.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Sections II and VI.

    Examples
    --------
    >>> limiter = Limits(velocity=1.0)
    >>> found = describing_function(limiter, [0.5, 2.0, 20.0], 1.0)
    >>> np.round(found.gain_db, 3).tolist(), np.round(found.phase_deg, 2).tolist()
    ([0.0, -3.922, -23.922], [0.0, -38.24, -85.5])
    """
    sweep = checked_sweep(shaper, amplitude, omega, samples_per_period)
    if sweep.counts is None:
        response = rate_limited_harmonic(sweep.bounds[0])
    else:
        bounds, counts = sweep.bounds.reshape(len(sweep.bounds), -1), sweep.counts.ravel()
        largest_first = np.argsort(-counts, kind="stable")
        problem = bounds[:, largest_first], counts[largest_first], command_velocity
        response = np.empty(len(counts), dtype=complex)
        response[largest_first] = follower_harmonic(_repeating(*problem), *problem)
        response = response.reshape(sweep.omega.shape)
    if isinstance(shaper, CommandFollower) and shaper.jerk_filter is not None:
        lags = shaper.jerk_filter
        response = np.asarray(response * (1.0 + 1j * sweep.omega / lags.omega) ** -lags.order)
    response.flags.writeable = False
    return DescribingFunction(sweep.amplitude, sweep.omega, response)


@dataclass(frozen=True, eq=False)
class PeriodicResponse(Frozen):
    """One period of a sine and of what a shaper makes of it, once it repeats.

    Attributes
    ----------
    time : (N,) array
        From 0 to T; for a follower, when each of its samples begins.
    command, output : (N,) arrays
        A·sin ωt and y.
    """

    time: FloatArray
    command: FloatArray
    output: FloatArray

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw command and output over time; without an Axes in pyplot's current ones."""
        drawn: Axes = draw(self, ax)
        return drawn

    def __repr__(self) -> str:
        return f"PeriodicResponse(points={len(self.time)}, period={self.time[-1]:.6g})"


def periodic_response(
    shaper: Limits | CommandFollower,
    amplitude: float,
    omega: float,
    *,
    command_velocity: bool = False,
    samples_per_period: int | None = None,
) -> PeriodicResponse:
    """Return the motion of which `describing_function` takes the first harmonic.

    Parameters
    ----------
    shaper, command_velocity, samples_per_period
        As in `describing_function`, but without a jerk filter.
    amplitude, omega : float
        A and ω (radians per time unit), positive.

    Returns
    -------
    PeriodicResponse
        Of a rate limiter at 1025 times.

    Raises
    ------
    TypeError, ValueError, RuntimeError
        As `describing_function`, and for a follower with a jerk filter.

    Examples
    --------
    >>> triangle = periodic_response(Limits(velocity=1.0), 10.0, 1.0).output
    >>> round(float(triangle.max()), 2)
    1.57
    """
    if isinstance(shaper, CommandFollower) and shaper.jerk_filter is not None:
        raise ValueError(
            "the motion behind a jerk filter is not known here: give the follower without it"
        )
    size, frequency = finite("amplitude", amplitude), finite("omega", omega)
    sweep = checked_sweep(shaper, size, frequency, samples_per_period)
    if sweep.counts is None:
        theta = _angles(SAMPLES_PER_PERIOD)
        output = rate_limited(theta, float(sweep.bounds[0]))
    else:
        bounds, counts = sweep.bounds.reshape(-1, 1), sweep.counts.reshape(1)
        state, count = _repeating(bounds, counts, command_velocity)[:, 0], int(counts[0])
        theta = _angles(count)
        half = follower_states(state, bounds[:, 0], count, command_velocity)[0]
        output = np.concatenate([half[:-1], -half[:-1], half[:1]])
    return PeriodicResponse(theta / sweep.omega, size * np.sin(theta), size * output)


def _angles(count: int) -> FloatArray:
    return np.asarray(np.arange(count + 1) * (2.0 * pi / count), dtype=np.float64)


def _repeating(bounds: FloatArray, counts: Counts, command_velocity: bool) -> FloatArray:
    """Return the states (order, M) in which each period begins; RuntimeError if there is none."""
    states, apart = follower_cycle(bounds, counts, command_velocity)
    wrong = ~(apart <= _NEARLY)
    if wrong.any():
        first = ", ".join(f"{value:.3g}" for value in bounds[:, wrong][:, 0])
        raise RuntimeError(
            f"the output does not come to repeat at {np.count_nonzero(wrong)} of {wrong.size} "
            f"points, the first with bounds on velocity, acceleration, … of {first} times the "
            "sine's own: leave out amplitudes and frequencies so far beyond the bounds, or sample "
            "faster"
        )
    return states
