"""Servo loops that several tests have in common."""

from jounce.plant import (
    FlexibleInertia,
    Inertia,
    InertiaFeedforward,
    ServoLoop,
    design_pid,
)
from jounce.shaping import Limits, min_time_move

MOMENT = 2.5
GAINS = design_pid(MOMENT, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
MOVE = min_time_move(1.0, Limits(velocity=0.5, acceleration=1.0, jerk=4.0))


def loop_with(estimate=None, gains=GAINS, moment=MOMENT):
    feedforward = None if estimate is None else InertiaFeedforward(estimate)
    return ServoLoop(Inertia(moment), gains, feedforward)


def flexible(sensor="motor", frequency=10.0, damping=0.01, fraction=0.4):
    return FlexibleInertia(MOMENT, frequency, damping, load_fraction=fraction, sensor=sensor)
