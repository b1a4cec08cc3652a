"""Scenarios as text, with gains to fill in."""

import math

import control
import numpy as np

DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600
OMEGA_C = 2 * math.pi
NAMES = ("without feedforward", "with feedforward", "Ĵ +10 %", "Ĵ -10 %")


def design(margin: str) -> str:
    return (
        'gains = "design"\nspecification = {crossover = "1 Hz", phase_margin = "45 deg", '
        f'lower_gain_margin = "{margin}"}}'
    )


def designed(gain_margin: float) -> tuple[float, float, float]:
    """Return kp, ki, kr of a unit inertia for 1 Hz and 45°: Theory, Section 7."""
    kp = OMEGA_C**2 * math.cos(math.pi / 4)
    q = kp / gain_margin
    kr = OMEGA_C**3 * math.sin(math.pi / 4) / (OMEGA_C**2 - q)
    return kp, kr * q, kr


def step_of(kp: float, ki: float, kr: float, time: np.ndarray) -> np.ndarray:
    """Return the unit step response of a PID around a unit inertia."""
    closed = control.tf([kr, kp, ki], [1.0, kr, kp, ki])
    return np.asarray(control.step_response(closed, time).outputs)
