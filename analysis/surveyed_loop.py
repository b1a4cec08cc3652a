"""How a loop is taken for a survey: as the ideal one or as it is, how long it is followed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf, log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..plant import PID, Clamp, Feedforward, Inertia, InertiaFeedforward, ServoLoop
from ..shaping.pieces import FloatArray
from .margins.shared_margins import AnyMargins

Poles = NDArray[np.complex128]

_GONE = 1e-3  # of z: what is left of such a mode after a sample is nothing
_MOST_STEPS = 200_000
_FADED = log(1e3)  # of a mode: at less, what is left at the end is told
_TIMES, _TAIL_TIMES = 6_000, 2_000


def is_ideal(loop: ServoLoop) -> bool:
    """Whether a loop is a rigid inertia under a continuous PID without filters and limits."""
    law = loop.controller
    bare = isinstance(law, PID) and not law.derivative_filter
    fed = isinstance(loop.feedforward, InertiaFeedforward | None)
    return isinstance(loop.plant, Inertia) and bare and fed


def decaying_poles(margins: AnyMargins) -> Poles:
    """Return the closed-loop poles in rad/s; of a discrete loop log(z)/dt of those that last."""
    poles = margins.closed_loop_poles
    if margins.dt is None:
        return poles
    lasting = poles[np.abs(poles) > _GONE]
    if not lasting.size:
        lasting = np.array([_GONE + 0j])
    return np.asarray(np.log(lasting.astype(complex)) / margins.dt)


def followed_until(loop: ServoLoop, poles: Poles, decay: float, lead: float = 0.0) -> float:
    """Return how long to follow a response: until every mode has decayed to exp(−decay).

    A mode so slow that this takes 200,000 samples, or spans of the fastest pole, is not waited
    for.
    """
    slowest = float(-poles.real.max())
    wait = decay / slowest if slowest > 0.0 else inf
    return lead + min(wait, _longest(loop, poles))


def _longest(loop: ServoLoop, poles: Poles) -> float:
    step = loop.controller_noun.sample_time or 1.0 / float(np.abs(poles).max())
    return _MOST_STEPS * step


def not_waited_for(loop: ServoLoop, poles: Poles) -> str:
    """Return a sentence on a mode that lasts longer than responses are followed; empty for none."""
    slowest, longest = float(-poles.real.max()), _longest(loop, poles)
    if slowest * longest > _FADED:
        return ""
    lasts = f"{1.0 / slowest:.3g} s" if slowest > 0.0 else "for ever"
    return (
        f"The slowest mode of the closed loop takes {lasts} to fall to 37 %, and responses are "
        f"followed for {longest:.4g} s at most, {_MOST_STEPS:,} samples: 'never' and 'not by' are "
        "of that time. Raise the gain that makes it so slow."
    )


def shown_times(begin: float, lead: float, duration: float) -> FloatArray:
    """Return times at which a response is kept: most of them until a little after the command."""
    busy = min(1.5 * lead, duration) if lead else duration
    early = np.linspace(0.0, busy, _TIMES)
    if busy >= duration:
        return np.asarray(begin + early)
    late = np.linspace(busy, duration, _TAIL_TIMES + 1)[1:]
    return np.asarray(begin + np.concatenate([early, late]))


def linear_part(loop: ServoLoop) -> ServoLoop:
    """Return the loop without what `left_out` names, constant load and feedforward."""
    bare: dict[str, Any] = {"friction": None, "ripple": None, "torque_limit": inf}
    axis = replace(loop.axis, **bare, encoder_step=0.0, constant_load=0.0)
    return ServoLoop(axis, replace(loop.controller_noun, anti_windup=None))


def left_out(loop: ServoLoop, torque_name: str) -> str:
    """Return what a loop has and its linear part does not, in words; empty for nothing."""
    axis = loop.axis
    has = {
        "friction": axis.friction is not None,
        "ripple over position": axis.ripple is not None,
        f"{torque_name} limit": axis.torque_limit < inf,
        "clamp of the integral": isinstance(loop.controller_noun.anti_windup, Clamp),
        "resolution": axis.encoder_step > 0.0 and loop.is_digital,
    }
    *others, last = [name for name, there in has.items() if there] or [""]
    return f"{', '.join(others)} and {last}" if others else last


def compared_loops(loop: ServoLoop, error: float) -> Mapping[str, ServoLoop]:
    """Return the loop with each of the feedforwards that are compared, by name."""
    given = loop.feedforward_noun
    j_hat = given.torque.get(2, 0.0)
    varied = {
        f"Ĵ {100 * error:+.4g} %": j_hat * (1.0 + error),
        f"Ĵ {-100 * error:+.4g} %": j_hat * (1.0 - error),
    }
    if isinstance(loop.feedforward, InertiaFeedforward | None):
        fed: dict[str, Any] = {"without feedforward": 0.0, "with feedforward": j_hat} | varied
        fed = {name: InertiaFeedforward(inertia) for name, inertia in fed.items()}
    else:
        fed = {"without feedforward": None, "with feedforward": given}
        fed |= {name: _with_inertia(given, inertia) for name, inertia in varied.items()}
    return {name: ServoLoop(loop.plant, loop.controller, each) for name, each in fed.items()}


def _with_inertia(given: Feedforward, inertia: float) -> Feedforward:
    torque = {**given.torque, 2: inertia} if inertia else given.torque
    return replace(given, torque=torque)
