"""Stability margins of a single-input, single-output negative-feedback loop."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ...plant import ServoLoop, as_controller
from ...plant.models import Rational, StateModel
from ...shaping.checks import finite
from ...shaping.real_numbers import shown
from ..measured import MeasuredMargins, MeasuredResponse, is_frd, measured_margins
from .bandwidth import bandwidth
from .delayed_poles import rightmost_poles
from .factored_loop import Complex, FactoredLoop, Real, is_stable
from .factoring import factored
from .many_crossings import OnePieces, Pieces, pieces_of
from .many_crossings import stable as is_stable_by_count
from .many_gain_and_phase import at_edges, at_limits, gain_margins_at, phase_and_delay
from .many_modulus import DISTANCE, QUOTIENT, Measure, modulus
from .passages import Passages, passages
from .result import LoopMargins
from .rooted_loops import rooted
from .stabilizing import stabilizing_delays, stabilizing_gains

if TYPE_CHECKING:
    import control

_LEAST_DELAY = 1e-290  # its inverse, in whatever unit of time, is still a double
_UNLIMITED = (
    "phase_margin_deg",
    "lower_gain_margin_db",
    "upper_gain_margin_db",
    "delay_margin_s",
)
_SILENT = {
    "modulus_margin": 1.0,
    "modulus_margin_hz": 0.0,
    "disk_margin": 2.0,
    "disk_margin_hz": 0.0,
    "sensitivity_peak": 1.0,
    "sensitivity_peak_hz": 0.0,
    "complementary_peak": 0.0,
    "complementary_peak_hz": 0.0,
}


@overload
def loop_margins(
    system: MeasuredResponse,
    *,
    delay: float = ...,
    controller: Any = ...,
    measured_with: Any = ...,
) -> MeasuredMargins: ...
@overload
def loop_margins(
    system: "control.StateSpace | control.TransferFunction | ServoLoop",
    *,
    delay: float = ...,
    controller: Any = ...,
    measured_with: None = ...,
) -> LoopMargins: ...
def loop_margins(
    system: Any, *, delay: float = 0.0, controller: Any = None, measured_with: Any = None
) -> LoopMargins | MeasuredMargins:
    """Return the margins of the unity negative-feedback loop around `system`.

        L(s) = G(s)·e^(−s·delay),   or L(z) of a loop that is discrete in time

    Lower and upper gain margins are found apart, over every frequency where L is real and
    negative, DC and ω → ∞ included, so conditionally stable loops come out whole. All gains and
    all added delays that make the loop stable are listed, of an unstable loop, too.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        Open-loop transfer, one input, one output: G(s) in rad/s, where an ideal (improper)
        transfer function is accepted without a delay, or L(z) with its sampling time in seconds,
        such as `ServoLoop.sampled_loop_transfer` gives. Of a ServoLoop it is its open loop, with
        delay and sampling as they are. A measured response, or python-control's frequency response
        data (of L, or with a controller of the plant), has its margins read off the data as far
        as they go, with error bars and worst cases: see `MeasuredMargins`.
    delay : float, optional
        Pure delay in seconds behind a system in continuous time, taken as it is, without a Padé
        approximation. A discrete loop has its delay in L(z).
    controller : Controller, PID, CascadedPI or python-control system, optional
        C of L = C·G, `system` being the plant G, a model or measured.
    measured_with : the same, optional
        The controller that a measured plant ran with: stability is counted relative to it.

    Returns
    -------
    LoopMargins
        Frequencies in Hz, gains in dB, angles in degrees, delay in seconds; MeasuredMargins of
        what was measured.

    Raises
    ------
    TypeError
        If `system` is none of these.
    ValueError
        If `system` has several inputs or outputs, coefficients that are not finite, no sampling
        time although it is discrete, or, discrete or behind a delay, more zeros than poles; if
        1 + L vanishes as ω → ∞ (an ill-posed loop); for a delay that is negative, not finite, or
        given with a discrete system.

    Notes
    -----
    Well-conditioned loops come out to about 1e-12 relative, whatever the unit of time; so do the
    places of the peaks, which are solved for where the slope of the peak vanishes, but those of
    peaks so flat that the slope itself is rounding. An expanded polynomial of high order limits
    what can be known of its roots, one in z of slow modes, crowded around z = 1, most of all; a
    state space of the same loop in physical coordinates keeps more, but one whose states are
    mixtures of very different size may keep four digits. A pole and a zero that cancel still
    count in stability, not in crossings; on the axis no gain and no delay makes such a loop
    stable. A loop with |L| = 1 or real L at every frequency has no isolated crossings; what is
    listed then means nothing, and unless it is static the loop is unstable.

    Zeros and poles on the axis, undamped notches and modes, are passed close by on both sides,
    and are points at which gain and phase may turn. Those with a damping ratio below 1e-13 are
    set on the axis, as are double and triple ones that rounding has parted.

    With a delay, stability is decided by Nyquist's criterion, counted from the phases at the
    gain crossovers, and peaks are found by bounds over intervals of frequency: neither needs a
    grid. Both are those of `many_loop_margins`, on roots in place of coefficients.

    Examples
    --------
    >>> import control
    >>> margins = loop_margins(control.tf([1], [1, 1, 0]))
    >>> round(margins.phase_margin_deg, 3), margins.upper_gain_margin_db
    (51.827, inf)
    >>> delayed = loop_margins(control.tf([1], [1, 1, 0]), delay=0.5)
    >>> round(delayed.phase_margin_deg, 3), round(delayed.upper_gain_margin_db, 3)
    (29.306, 6.647)
    >>> unstable = loop_margins(control.tf([1, 28, 38], [1, 0, 0, 0]))
    >>> [(round(low, 4), high) for low, high in unstable.stabilizing_gains]
    [(1.3571, inf)]
    """
    if isinstance(system, MeasuredResponse) or is_frd(system):
        return _of_data(system, delay, controller, measured_with)
    if measured_with is not None:
        raise ValueError(
            f"measured_with of a {type(system).__name__}: expected it with a MeasuredResponse of "
            "kind 'plant'; leave it out"
        )
    if controller is not None and not isinstance(system, ServoLoop):
        system = ServoLoop(system, as_controller(controller))
    if isinstance(system, ServoLoop):
        if controller is not None and system.controller is not controller:
            system = replace(system, controller=as_controller(controller))
        system = system.open_model()
    _validate(system)
    loop = factored(system, _checked_delay(system, delay))
    if not loop.gain:
        return _of_silent(loop)
    with np.errstate(all="ignore"):
        return _of_pieces(loop, pieces_of(rooted(loop)))


def _of_data(system: Any, delay: float, controller: Any, measured_with: Any) -> MeasuredMargins:
    """Return the margins of data; bare data with a controller are those of a plant."""
    if finite("delay", delay):
        raise ValueError(
            f"delay = {shown(delay)} of measured data, which have their delay in them; "
            "leave it out, "
            "or multiply the response by e^(−jω·delay)"
        )
    return measured_margins(system, controller, measured_with=measured_with)


def _validate(system: Any) -> None:
    if isinstance(system, StateModel | Rational):
        return
    import control

    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise TypeError(
            f"system is a {type(system).__name__}; loop_margins takes a control.StateSpace, "
            "control.TransferFunction, frequency response data or a ServoLoop: convert it with "
            "control.ss, control.tf or control.frd"
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
        raise ValueError(f"delay = {shown(delay)}: expected a number of seconds, 0 or more")
    if delay and system.isdtime(strict=True):
        raise ValueError(
            f"delay = {shown(delay)} with a system that is discrete in time (dt = {system.dt}); "
            "loop_margins takes a delay in continuous time alone: put it into L(z), as "
            "plant.zero_order_hold(plant, dt, delay=…) does"
        )
    return delay if delay > _LEAST_DELAY else 0.0


def _of_silent(loop: FactoredLoop) -> LoopMargins:
    """Return the margins of a loop without gain."""
    poles = loop.closed_loop_poles()
    stable = is_stable(np.concatenate([loop.closed, loop.hidden]))
    values = dict.fromkeys(_UNLIMITED, math.inf) | _SILENT if stable else {}
    always = ((0.0, math.inf),) if stable else ()
    return LoopMargins(stable, poles, (), (), always, always, dt=loop.dt, **values)


def _of_pieces(loop: FactoredLoop, pieces: OnePieces) -> LoopMargins:
    found = passages(pieces)
    poles, stable = _poles(loop, pieces, found)
    crossings = _phase_crossings(pieces, found)
    return LoopMargins(
        stable=stable,
        closed_loop_poles=poles,
        crossovers_hz=_hertz(loop, pieces.crossovers[0][0]),
        phase_crossovers_hz=_hertz(loop, np.unique(crossings[1])),
        stabilizing_gains=stabilizing_gains(pieces, found, stable=stable),
        stabilizing_delays_s=stabilizing_delays(pieces, stable=stable),
        dt=loop.dt,
        **(_margins(loop, pieces, crossings) if stable else {}),
    )


def _poles(loop: FactoredLoop, pieces: OnePieces, found: Passages) -> tuple[Complex, bool]:
    """Return closed-loop poles, and whether all are stable: those that are listed, at the least."""
    if not loop.delay:
        listed = is_stable(np.concatenate([loop.closed, pieces.loops.loop.hidden]))
        counted = not loop.samples or bool(is_stable_by_count(pieces)[0])
        return loop.closed_loop_poles(), listed and counted
    crossovers = pieces.omega[pieces.crossing]
    poles = rightmost_poles(loop, 1j * np.concatenate([crossovers, found.omega[found.inside]]))
    return poles, bool(is_stable_by_count(pieces)[0]) and is_stable(poles)


def _hertz(loop: FactoredLoop, omega: Real) -> tuple[float, ...]:
    """Return frequencies in Hz, ascending, without nan."""
    return tuple(sorted(loop.hertz(place) for place in omega[~np.isnan(omega)].tolist()))


def _phase_crossings(pieces: OnePieces, found: Passages) -> tuple[Real, Real]:
    """Return ln |L| and ω where L is finite, real and negative, limits and touches included."""
    touches = (at_edges(pieces), at_limits(pieces))
    gain = np.concatenate([found.gain[found.inside], *(part[0][0] for part in touches)])
    omega = np.concatenate([found.omega[found.inside], *(part[1][0] for part in touches)])
    some = np.isfinite(gain)
    return gain[None, some], omega[None, some]


def _margins(
    loop: FactoredLoop, pieces: OnePieces, crossings: tuple[Real, Real]
) -> dict[str, float]:
    """Every margin of a stable loop, by field name."""
    margins = gain_margins_at(*crossings) | phase_and_delay(pieces)
    values = {name: float(value[0]) for name, value in margins.items()}
    inverse = inverse_pieces(pieces)
    least_s, at_s = _least(pieces, crossings)
    least_t, at_t = _least(inverse, (-crossings[0], crossings[1]))
    least_d, at_d = _least(pieces, crossings, QUOTIENT)
    values |= {
        "modulus_margin": least_s,
        "modulus_margin_hz": at_s,
        "disk_margin": 2.0 * least_d,
        "disk_margin_hz": at_d,
        "sensitivity_peak": 1.0 / least_s,
        "sensitivity_peak_hz": at_s,
        "complementary_peak": 1.0 / least_t,
        "complementary_peak_hz": at_t,
        "bandwidth_hz": bandwidth(inverse),
    }
    return {
        name: loop.hertz(value) if name.endswith("_hz") else value for name, value in values.items()
    }


def inverse_pieces(pieces: OnePieces) -> OnePieces:
    """Return the pieces of 1/L."""
    loops = pieces.loops.inverse()
    turns = (loops.roots.offset + pieces.loops.roots.offset)[:, None] - pieces.turns
    return Pieces(loops, pieces.omega, -pieces.gain, turns, pieces.crossing)


def _least(pieces: OnePieces, crossings: Any, measure: Measure = DISTANCE) -> tuple[float, float]:
    value, place = modulus(pieces, crossings, measure)
    return float(value[0]), float(place[0])
