"""What disturbs a loop: a step of torque, wind, noise and resolution, friction at a reversal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import log, nan, sqrt
from typing import Any, Literal, TypeVar

import numpy as np

from ..plant import LoopResponse, Ramp, ServoLoop, Spectrum, TorqueSteps, Wind
from ..plant.response_figures import load_extremes, rms_error
from ..shaping.checks import finite, of_kind
from ..shaping.pieces import FloatArray
from ..shaping.told import Told
from .specification import Tracking
from .surveyed_loop import Poles, followed_until, linear_part, shown_times

Winds = Wind | Spectrum | Sequence[Wind | Spectrum] | None
Noises = float | Spectrum | Sequence[float | Spectrum]
_Source = TypeVar("_Source")
_RECOVERED = 0.1  # of the peak
_DECAY = log(1e6)


@dataclass(frozen=True, eq=False, repr=False)
class DisturbanceStep(Told):
    """The loop's response to steps of torque, its command still.

    Attributes
    ----------
    torque : float
        Sum of the steps.
    on : {"motor", "load"}
    response : LoopResponse
    peak : float
        Largest deviation of the load from where it stood, which a constant load may hold away
        from the command.
    recovery_time_s : float
        After which the load stays within a tenth of that; infinite where it does not, such as
        behind a spring that the motor's sensor does not see.
    """

    torque: float
    on: Literal["motor", "load"]
    response: LoopResponse
    peak: float
    recovery_time_s: float

    @property
    def deviation(self) -> FloatArray:
        """The load's deviation from where it stood, over the response's time."""
        error = self.response.load_error
        return np.asarray(error[0] - error)

    @property
    def final(self) -> float:
        """The load's deviation at the end of the response."""
        return float(self.deviation[-1])


@dataclass(frozen=True)
class ErrorSource:
    """One line of the error budget.

    Attributes
    ----------
    name : str
    kind : {"random", "deterministic"}
        A standard deviation, or a peak, which is no part of the sum of squares.
    load : float
        Of the load's position.
    torque : float
        Of the torque command; nan where it is not told.
    remark : str
        What is supposed.
    """

    name: str
    kind: Literal["random", "deterministic"]
    load: float
    torque: float
    remark: str


@dataclass(frozen=True, eq=False, repr=False)
class TrackingSurvey(Told):
    """How a loop, as it is, follows a command that goes on; errors are those of the load."""

    name: str
    tracking: Tracking
    response: LoopResponse
    rms_error: float
    peak_error: float
    slips: int


def disturbance_step(loop: ServoLoop, torque: float | TorqueSteps, poles: Poles) -> DisturbanceStep:
    """Return the response of a loop as it is, at rest, to a torque on its load, or to steps."""
    steps = torque if isinstance(torque, TorqueSteps) else _step(torque, "load")
    lead = float(steps.times[-1])
    duration = followed_until(loop, poles, _DECAY, lead)
    response = loop.respond(Ramp(0.0), times=shown_times(0.0, lead, duration), disturbance=steps)
    stood = -float(response.load_error[0])
    low, high = load_extremes(response, stood)
    peak = max(high, -low)
    recovery = response.settling_time(stood, _RECOVERED * peak, of="load") if peak else 0.0
    return DisturbanceStep(float(steps.torques.sum()), steps.on, response, peak, recovery)


def error_budget(
    loop: ServoLoop, wind: Winds, encoder_noise: Noises, poles: Poles
) -> tuple[ErrorSource, ...]:
    """Return what each source of error does to the loop."""
    found = [*_torques(loop, _each(wind)), *_noises(loop, _each(encoder_noise))]
    step = loop.axis.encoder_step
    if step and loop.is_digital:
        coarse = loop.deviations(encoder_noise=step / sqrt(12.0))
        remark = "as white noise of q/√12: fair where it moves by more than q in a sample"
        found.append(ErrorSource("quantisation", "random", coarse.load, coarse.torque, remark))
    if loop.axis.friction is not None:
        remark = "peak: it turns by twice Coulomb's, no friction fed forward, linear loop"
        spike = friction_spike(loop, poles)
        found.append(ErrorSource("friction at a reversal", "deterministic", spike, nan, remark))
    return tuple(found)


def _each(given: Any) -> tuple[Any, ...]:
    """Return none, one or several sources as a tuple."""
    several = tuple(given) if isinstance(given, list | tuple) else (given,)
    return tuple(each for each in several if isinstance(each, Spectrum) or each)


def _torques(loop: ServoLoop, winds: Sequence[Wind | Spectrum]) -> Iterator[ErrorSource]:
    """Yield what random torques do."""
    for wind in winds:
        of_kind("wind", wind, Wind | Spectrum, "Wind(…), Spectrum(…) or a list of them")  # type: ignore[arg-type]
    for name, wind in _named(winds, "wind", "torque spectrum"):
        does = loop.deviations(wind)
        kind = _table(wind) if isinstance(wind, Spectrum) else wind.kind
        remark = f"{kind}, {wind.sigma:.4g} rms on the {wind.on}"
        yield ErrorSource(name, "random", does.load, does.torque, remark)


def _noises(loop: ServoLoop, noises: Sequence[float | Spectrum]) -> Iterator[ErrorSource]:
    """Yield what random errors of the encoder do."""
    for name, noise in _named(noises, "encoder noise", "encoder spectrum"):
        does = loop.deviations(encoder_noise=noise)
        remark = _table(noise) if isinstance(noise, Spectrum) else "white, fresh at each sample"
        yield ErrorSource(name, "random", does.load, does.torque, remark)


def _named(sources: Sequence[_Source], usual: str, table: str) -> Iterator[tuple[str, _Source]]:
    """Yield sources with their names, those of the same kind numbered from the second on."""
    seen: Counter[str] = Counter()
    for source in sources:
        name = table if isinstance(source, Spectrum) else usual
        seen[name] += 1
        yield (name if seen[name] == 1 else f"{name} {seen[name]}"), source


def _table(spectrum: Spectrum) -> str:
    low, high = spectrum.reach_hz
    return f"table from {low:.4g} to {high:.4g} Hz"


def total_of(sources: Sequence[ErrorSource]) -> tuple[float, float]:
    """Return the standard deviations of load and torque of all random sources together."""
    random = [source for source in sources if source.kind == "random"]
    load = sqrt(sum(source.load**2 for source in random))
    return load, sqrt(sum(source.torque**2 for source in random))


def friction_spike(loop: ServoLoop, poles: Poles) -> float:
    """Return the peak of the load's error when Coulomb friction turns, of the linear loop."""
    friction = loop.axis.friction
    if friction is None or not friction.coulomb:
        return 0.0
    turn = _step(2.0 * friction.coulomb, "motor")
    return disturbance_step(linear_part(loop), turn, poles).peak


def _step(torque: float, on: Literal["motor", "load"]) -> TorqueSteps:
    return TorqueSteps(np.zeros(1), np.array([finite("torque_step", torque)]), on=on)


def tracking_survey(loop: ServoLoop, tracking: Tracking) -> TrackingSurvey:
    """Return how a loop follows a command, or stands; ValueError, with its name, if it cannot."""
    command = tracking.command
    begin = getattr(command, "start_time", 0.0)
    try:
        times = shown_times(begin, 0.0, tracking.duration)
        length = tracking.duration
        response = loop.respond(command, duration=length, times=times, **tracking.acting(loop))
    except ValueError as error:
        raise ValueError(f"tracking {tracking.name!r}: {error}") from None
    low, high = load_extremes(response, after=tracking.after)
    counted = begin + tracking.after
    slips = sum(to != 0 for at, _, to in response.friction_events if at >= counted)
    rms = rms_error(response, after=tracking.after)
    return TrackingSurvey(
        tracking.name, tracking, response, rms, float(np.maximum(high, -low)), slips
    )
