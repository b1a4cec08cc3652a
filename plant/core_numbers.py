"""A digital controller, and the steps of a run, as numbers for core and export."""

from __future__ import annotations

from math import ceil, inf

import numpy as np

from ..shaping.pieces import FloatArray
from .anti_windup import BackCalculation, Clamp
from .balance import balanced_norm
from .cascade import CascadedPI
from .controller import Controller
from .feedforward import Feedforward
from .hybrid import Hybrid
from .layout import Layout


def memory_at_rest(controller: Controller, holding: float) -> FloatArray:
    """Return the state of a digital controller whose integral holds a torque, its filters settled.

    Four numbers of the law, the integral the second, and two of each section of the filters.
    """
    memory = np.zeros(4 + 2 * len(controller.sections))
    if holding and controller.integral_gain:
        memory[1] = holding / controller.integral_gain
    x = holding
    for i, (b0, b1, b2, a1, a2) in enumerate(controller.sections):
        y = x * (b0 + b1 + b2) / (1.0 + a1 + a2) if holding else 0.0
        memory[4 + 2 * i], memory[5 + 2 * i] = y - b0 * x, b2 * x - a2 * y
        x = y
    return memory


def tuning(
    controller: Controller, feedforward: Feedforward, torque_limit: float, encoder_step: float
) -> list[float]:
    """Return the numbers of a controller, in the order of the core's `jounce_controller`."""
    law, way = controller.law, controller.anti_windup
    kinds = {"conditional": 1, BackCalculation: 2, Clamp: 3}
    winding = kinds.get(way if isinstance(way, str) else type(way), 0)
    cascade = isinstance(law, CascadedPI)
    sections = 0 if controller.sample_time is None else len(controller.sections)
    tuned = [float(cascade), winding, sections, max(feedforward.order, 1)]
    tuned += [controller.sample_time or 1.0]
    if isinstance(law, CascadedPI):
        tuned += [law.velocity_gain, law.integral_gain, 0.0, controller.rate_filter]
        tuned += [law.position_gain, law.velocity_feedforward]
    else:
        tuned += [law.kp, law.ki, law.kr, controller.rate_filter, 0.0, 0.0]
    tuned += [feedforward.friction, torque_limit]
    tuned += [way.tracking_time if isinstance(way, BackCalculation) else 1.0]
    tuned += [way.integral_limit if isinstance(way, Clamp) else inf, encoder_step]
    return [float(x) for x in tuned]


def fastest(layout: Layout, hybrid: Hybrid) -> float:
    """Return a bound of the rates of a loop's own states: the series is exact for 2/bound."""
    own = layout.chain
    return max(balanced_norm(rates[:own, :own]) for rates in hybrid.rates)


def sampled_steps(norm: float, dt: float, delay: float) -> tuple[float, float]:
    """Return two lengths of steps that fill the times from sample to torque and to the next."""
    rest = delay % dt
    if rest < 1e-9 * dt or dt - rest < 1e-9 * dt:
        rest = 0.0
    lengths = [part / max(ceil(0.5 * norm * part), 1) for part in (rest, dt - rest) if part]
    return max(lengths), min(lengths)
