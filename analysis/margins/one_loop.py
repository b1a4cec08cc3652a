"""Stability margins of a single-input, single-output negative-feedback loop."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ...shaping.checks import finite
from . import sectors
from .crossings import (
    TOUCH_TOLERANCE,
    gain_crossings,
    level_crossings,
    phase_crossings,
    stationary_points,
)
from .delay import is_stable_behind_delay, rightmost_poles
from .factored_loop import HIGHEST, LOWEST, Complex, FactoredLoop, Real, is_stable
from .factoring import factored
from .result import LoopMargins

if TYPE_CHECKING:
    import control

_WIDE = 1e4


def loop_margins(
    system: "control.StateSpace | control.TransferFunction", *, delay: float = 0.0
) -> LoopMargins:
    """Return the margins of the unity negative-feedback loop around `system`.

        L(s) = G(s)·e^(−s·delay),   or L(z) of a loop that is discrete in time

    Lower and upper gain margins are found apart, over every frequency where L is real and
    negative, DC and ω → ∞ included, so conditionally stable loops come out whole.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        Open-loop transfer, one input, one output: G(s) in rad/s, where an ideal (improper)
        transfer function is accepted without a delay, or L(z) with its sampling time in seconds,
        such as `ServoLoop.sampled_loop_transfer` gives.
    delay : float, optional
        Pure delay in seconds behind a system in continuous time, taken as it is, without a Padé
        approximation. A discrete loop has its delay in L(z).

    Returns
    -------
    LoopMargins
        Frequencies in Hz, gains in dB, angles in degrees, delay in seconds.

    Raises
    ------
    TypeError
        If `system` is neither of the two types.
    ValueError
        If `system` has several inputs or outputs, coefficients that are not finite, no sampling
        time although it is discrete, or, discrete or behind a delay, more zeros than poles; if
        1 + L vanishes as ω → ∞ (an ill-posed loop); for a delay that is negative, not finite, or
        given with a discrete system.

    Notes
    -----
    Well-conditioned loops come out to about 1e-12 relative, whatever the unit of time, but for
    the places of the peaks: a smooth maximum leaves its frequency eight digits, at worst. An
    expanded polynomial of high order limits what can be known of its roots, one in z of slow
    modes, crowded around z = 1, most of all; a state space of the same loop in physical
    coordinates keeps more, but one whose states are mixtures of very different size may keep four
    digits. A pole and a zero that cancel still count in stability, not in crossings. A loop with
    |L| = 1 or real L at every frequency has no isolated crossings; what is listed then means
    nothing, and unless it is static the loop is unstable.

    With a delay, stability is decided by counting what crosses the axis as the delay grows from
    nothing, and peaks are found by bounds over intervals of frequency: neither needs a grid.

    Examples
    --------
    >>> import control
    >>> margins = loop_margins(control.tf([1], [1, 1, 0]))
    >>> round(margins.phase_margin_deg, 3), margins.upper_gain_margin_db
    (51.827, inf)
    >>> delayed = loop_margins(control.tf([1], [1, 1, 0]), delay=0.5)
    >>> round(delayed.phase_margin_deg, 3), round(delayed.upper_gain_margin_db, 3)
    (29.306, 6.647)
    """
    _validate(system)
    loop = factored(system, _checked_delay(system, delay))
    crossovers, phase_crossovers = gain_crossings(loop), phase_crossings(loop)
    if loop.delay:
        poles, stable = rightmost_poles(loop), is_stable_behind_delay(loop, np.array(crossovers))
    else:
        poles = loop.closed_loop_poles()
        stable = is_stable(np.concatenate([loop.closed, loop.hidden]))
    margins = _margins(loop, crossovers, phase_crossovers) if stable else {}
    return LoopMargins(
        stable=stable,
        closed_loop_poles=poles,
        crossovers_hz=tuple(loop.hertz(omega) for omega in crossovers),
        phase_crossovers_hz=tuple(loop.hertz(omega) for omega in phase_crossovers),
        dt=loop.dt,
        **margins,
    )


def _validate(system: Any) -> None:
    import control

    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise TypeError(
            f"system is a {type(system).__name__}; loop_margins takes a control.StateSpace or "
            "control.TransferFunction: convert it with control.ss or control.tf"
        )
    if (system.noutputs, system.ninputs) != (1, 1):
        raise ValueError(
            f"system has {system.ninputs} inputs and {system.noutputs} outputs; loop_margins "
            "takes one of each: pick a channel with system[i, j], the other loops closed"
        )
    if system.isdtime(strict=True) and system.dt is True:
        raise ValueError(
            "system is discrete in time, but its dt = True names no sampling time; loop_margins "
            "takes one in seconds: give it when the system is made, control.tf(…, dt=0.001)"
        )


def _checked_delay(system: Any, delay: float) -> float:
    delay = finite("delay", delay)
    if delay < 0.0:
        raise ValueError(f"delay = {delay!r}: expected a number of seconds, 0 or more")
    if delay and system.isdtime(strict=True):
        raise ValueError(
            f"delay = {delay!r} with a system that is discrete in time (dt = {system.dt}); "
            "loop_margins takes a delay in continuous time alone: put it into L(z), as "
            "plant.zero_order_hold(plant, dt, delay=…) does"
        )
    return delay


def _margins(
    loop: FactoredLoop, crossovers: list[float], phase_crossovers: list[float]
) -> dict[str, float]:
    """Every margin of a stable loop, by field name."""
    (peak_s, at_s), (peak_t, at_t), (peak_d, at_d) = _peaks(loop)
    return {
        **_phase_and_delay(loop, np.array(crossovers)),
        **_gain_margins(loop, np.array(phase_crossovers)),
        "modulus_margin": 1 / peak_s,
        "modulus_margin_hz": at_s,
        "disk_margin": 2 / peak_d if peak_d else math.inf,
        "disk_margin_hz": at_d,
        "sensitivity_peak": peak_s,
        "sensitivity_peak_hz": at_s,
        "complementary_peak": peak_t,
        "complementary_peak_hz": at_t,
        "bandwidth_hz": _bandwidth(loop),
    }


def _phase_and_delay(loop: FactoredLoop, crossovers: Real) -> dict[str, float]:
    angles = np.angle(-loop.values(crossovers))
    inner = crossovers > LOWEST
    radians = np.where(inner, loop.radians(crossovers), 1.0)
    delays = np.where(inner, angles % (2 * np.pi) / radians, math.inf)
    delay, at_delay = _least(delays, crossovers)
    if loop.dt is None and loop.log_gain(np.array([HIGHEST]))[0] >= -TOUCH_TOLERANCE:
        delay, at_delay = 0.0, HIGHEST
    angle, crossover = _least(abs(angles), crossovers)
    return {
        "delay_margin_s": delay,
        "delay_margin_hz": loop.hertz(at_delay),
        "phase_margin_deg": math.degrees(angle),
        "crossover_hz": loop.hertz(crossover),
    }


def _gain_margins(loop: FactoredLoop, crossovers: Real) -> dict[str, float]:
    sizes = loop.log_gain(crossovers) * (20 / math.log(10))
    lower, at_lower = _least(sizes[sizes > 0], crossovers[sizes > 0])
    upper, at_upper = _least(-sizes[sizes < 0], crossovers[sizes < 0])
    return {
        "lower_gain_margin_db": lower,
        "lower_gain_margin_hz": loop.hertz(at_lower),
        "upper_gain_margin_db": upper,
        "upper_gain_margin_hz": loop.hertz(at_upper),
    }


def _least(margins: Real, places: Real) -> tuple[float, float]:
    """Return the smallest finite margin and where it is taken."""
    if not np.isfinite(margins).any():
        return math.inf, math.nan
    return float(margins.min()), float(places[margins.argmin()])


def _peaks(loop: FactoredLoop) -> list[tuple[float, float]]:
    """Return max |S|, max |T| and max |(1 − L)/(1 + L)| over all ω and where, in Hz."""
    if not loop.gain:
        return [(1.0, 0.0), (0.0, 0.0), (1.0, 0.0)]
    bounds = (sectors.sensitivity, sectors.complementary, sectors.disk)
    zeros = (loop.poles, loop.zeros, loop.opposite)
    if loop.delay:
        found = [sectors.peak(loop, bound) for bound in bounds]
    else:
        found = [_peak(loop, *each) for each in zip(bounds, zeros, strict=True)]
        if _is_wide(loop):
            searched = [sectors.peak(loop, bound) for bound in bounds]
            found = [max(each) for each in zip(found, searched, strict=True)]
    return [(value, loop.hertz(omega)) for value, omega in found]


def _is_wide(loop: FactoredLoop) -> bool:
    """Whether roots lie so far apart that rounding hides where a peak is."""
    sizes = abs(np.concatenate([loop.zeros, loop.poles, loop.closed]))
    sizes = sizes[sizes > 0]
    return bool(sizes.size and sizes.max() > _WIDE * sizes.min())


def _peak(loop: FactoredLoop, bound: sectors.Bound, zeros: Complex) -> tuple[float, float]:
    """Return max |F(L(jω))| over all ω and where; `zeros` are those of F(L(s))."""
    inner = stationary_points(zeros, loop.closed)
    places = np.concatenate([[LOWEST], inner, [HIGHEST]])
    sizes = sectors.sizes(loop, bound, places)
    # Of equal peaks the lowest in frequency, so that rounding does not choose.
    best = int(np.argmax(sizes >= sizes.max() * (1 - 1e-14)))
    return float(sizes[best]), float(places[best])


def _bandwidth(loop: FactoredLoop) -> float:
    if not loop.gain:
        return math.nan
    at_dc = float(sectors.sizes(loop, sectors.complementary, np.array([LOWEST]))[0])
    if at_dc < math.sqrt(LOWEST):
        return math.nan
    level = math.log(at_dc) - math.log(2) / 2
    if loop.delay:
        omega = sectors.first_below(loop, math.exp(level))
        return loop.hertz(omega) if math.isfinite(omega) else math.nan

    def excess(omega: Real) -> Real:
        return np.asarray(loop.log_gain(omega) - np.log(abs(1 + loop.values(omega))) - level)

    falls = level_crossings(excess, stationary_points(loop.zeros, loop.closed))
    return loop.hertz(falls[0]) if falls else math.nan
