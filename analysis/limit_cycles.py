"""Limit cycles of friction and resolution: what is foreseen, and what the simulation shows."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isnan, log, nan, pi, sqrt

from ..plant import LoopResponse, Ramp, ServoLoop
from ..plant.response_figures import load_extremes
from ..shaping.told import Told
from .disturbed import friction_spike
from .margins import LoopMargins
from .surveyed_loop import Poles, followed_until

FOR_GOOD = 3.6e9
"""Seconds, a million hours: what sticks for longer is told as at rest."""
_HOUR = 3600.0
_DECAY = log(1e6)
_ROUNDS = 4
_MOST_SAMPLES = 200_000
_FULL = 4.0 / pi  # of the quantiser's describing function, at q/√2
_BETWEEN = 0.3  # of an encoder's step: where the command stands between two counts


@dataclass(frozen=True)
class ForeseenCycle:
    """A limit cycle that the quantiser's describing function foresees.

    Where L = −1/N(A), with N(A) = (4q/πA)·Σ √(1 − ((2i − 1)·q/2A)²): the amplitude A of the
    measured position and the frequency.
    """

    amplitude: float
    frequency_hz: float


@dataclass(frozen=True)
class Standstill:
    """What the loop does, as it is, while its command stands still a little away.

    Attributes
    ----------
    offset : float
        Command at which it stands, the loop starting at rest at 0.
    duration_s : float
        For which it is followed; the other figures are of the second half of it.
    swing : float
        Largest less smallest position of the load.
    error : float
        Largest |r − load|.
    slips : int
        How often the motor breaks away.
    next_breakaway_s : float
        From the start; infinite where it never breaks away, nan without friction.
    """

    offset: float
    duration_s: float
    swing: float
    error: float
    slips: int
    next_breakaway_s: float


@dataclass(frozen=True, repr=False)
class LimitCycles(Told):
    """Limit cycles of a loop with friction or resolution.

    Attributes
    ----------
    foreseen : tuple of ForeseenCycle
        By the quantiser's describing function, each a cycle that attracts.
    friction : bool
        With stiction a describing function foresees no cycle, rightly or wrongly: only the
        simulation and the next breakaway tell.
    standstill : Standstill
    """

    foreseen: tuple[ForeseenCycle, ...]
    friction: bool
    standstill: Standstill


def limit_cycles(loop: ServoLoop, margins: LoopMargins, poles: Poles) -> LimitCycles | None:
    """Return the limit cycles of a stable loop; None without friction and resolution."""
    axis = loop.axis
    step = axis.encoder_step if loop.is_digital else 0.0
    if axis.friction is None and not step:
        return None
    offset = friction_spike(loop, poles) + _BETWEEN * step
    if axis.friction is not None and not offset:
        offset = 1.0 / max(abs(loop.controller_noun.integral_gain), 1.0)
    return LimitCycles(
        _foreseen(margins, step) if step else (),
        axis.friction is not None,
        _standstill(loop, offset, poles),
    )


def quantiser_gain(amplitude: float, step: float) -> float:
    """Return the describing function N(A) of rounding to multiples of a step.

    0 for A < q/2, at most 4/π at A = q/√2.
    """
    count = int(amplitude / step + 0.5)
    parts = (1.0 - ((2 * i - 1) * step / (2.0 * amplitude)) ** 2 for i in range(1, count + 1))
    return 4.0 * step / (pi * amplitude) * sum(sqrt(max(part, 0.0)) for part in parts)


def _foreseen(margins: LoopMargins, step: float) -> tuple[ForeseenCycle, ...]:
    """Return the cycles that attract: of the lower margin below q/√2, of the upper one above."""
    found = []
    middle = step / sqrt(2.0)
    lower = 10.0 ** (-margins.lower_gain_margin_db / 20.0)
    upper = 10.0 ** (margins.upper_gain_margin_db / 20.0)
    if 0.0 < lower < 1.0:
        amplitude = _amplitude(lower, step, 0.5 * step, middle)
        found.append(ForeseenCycle(amplitude, margins.lower_gain_margin_hz))
    if 1.0 < upper <= _FULL:
        amplitude = _amplitude(upper, step, 1.5 * step, middle)
        found.append(ForeseenCycle(amplitude, margins.upper_gain_margin_hz))
    return tuple(found)


def _amplitude(gain: float, step: float, low: float, high: float) -> float:
    """Return by bisection where N, smaller at `low` than at `high`, has a value."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if quantiser_gain(middle, step) < gain else (low, middle)
    return 0.5 * (low + high)


def _standstill(loop: ServoLoop, offset: float, poles: Poles) -> Standstill:
    """Return what the loop does at standstill, followed past breakaways that are foreseen."""
    duration = 2.0 * followed_until(loop, poles, _DECAY)
    for _ in range(_ROUNDS):
        response = _held(loop, offset, duration)
        step = loop.controller_noun.sample_time or duration / len(response.run.times)
        breakaway = nan if loop.axis.friction is None else response.next_breakaway
        if not duration < breakaway < inf or 3.0 * breakaway > _MOST_SAMPLES * step:
            break
        duration = 3.0 * breakaway
    half = 0.5 * duration
    low, high = load_extremes(response, offset, after=half)
    slips = sum(to != 0 for at, _, to in response.friction_events if at >= half)
    return Standstill(offset, duration, high - low, max(high, -low), slips, breakaway)


def _held(loop: ServoLoop, offset: float, duration: float) -> LoopResponse:
    try:
        return loop.respond(Ramp(0.0, offset), times=[0.0, duration], start=0.0)
    except ValueError as error:
        raise ValueError(f"standstill, the command {offset:.6g} away: {error}") from None


def shown_wait(seconds: float, unit: str = "") -> str:
    """Return when something happens: in seconds, from an hour on in hours, or never."""
    if seconds > FOR_GOOD:
        return "never"
    if seconds >= _HOUR:
        return f"{seconds / _HOUR:.4g} h"
    return f"{seconds:.4f} {unit}".rstrip()


def shown_cycles(found: LimitCycles, unit: str, scale: float) -> tuple[str, ...]:
    """Return the limit cycles in sentences, positions in a unit."""
    alone = ", for the loop without friction," if found.friction else ""
    lines = [
        f"The quantiser's describing function, of a sine about a count, foresees{alone} a cycle of "
        f"±{c.amplitude / scale:.3g} {unit} at {c.frequency_hz:.4g} Hz"
        + ("." if found.standstill.swing > c.amplitude else "; the simulation shows none so large.")
        for c in found.foreseen
    ]
    if found.friction:
        lines.append(
            "Of stiction a describing function foresees no cycle, rightly or wrongly: the "
            "simulation and the next breakaway tell."
        )
    return (*lines, _shown_standstill(found.standstill, unit, scale))


def _shown_standstill(s: Standstill, unit: str, scale: float) -> str:
    begin = (
        f"Simulated, the command {s.offset / scale:.3g} {unit} away, from {0.5 * s.duration_s:.4g} "
        f"to {s.duration_s:.4g} s: "
    )
    if s.slips:
        return f"{begin}it hunts, {s.slips} slips, the load swings by {s.swing / scale:.3g} {unit}."
    away = f"{s.error / scale:.3g} {unit} away"
    if s.next_breakaway_s <= s.duration_s:
        return f"{begin}it still slides, at most {away}."
    if isnan(s.next_breakaway_s):
        return f"{begin}the load swings by {s.swing / scale:.3g} {unit}, at most {away}."
    if s.next_breakaway_s > FOR_GOOD:
        return f"{begin}it rests {away}, for good."
    next_one = shown_wait(s.next_breakaway_s, "s")
    return f"{begin}it sticks {away}, and breaks away next at {next_one}: stuck is not at rest."
