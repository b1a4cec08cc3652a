"""The PID that gives a rigid inertia three margins, in closed form."""

from __future__ import annotations

from math import atan2, cos, degrees, inf, pi, sin, sqrt

import numpy as np

from ..shaping.real_numbers import shown
from .pid import PID


def inertia_pid(
    moment: float, omega: float, phase: float, factor: float, asked: tuple[float, float]
) -> PID:
    """Return the PID of crossover ω_c, phase margin φ and lower gain margin g_m on 1/(J·s²).

    With k(s) = k_r·(s² + p·s + q)/s,

        k_r·p = J·ω_c²·cos φ,   q = k_r·p/(J·g_m),   k_r = J·ω_c³·sin φ/(ω_c² − q).

    `asked` is what errors name: phase margin in deg, lower gain margin in dB.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII, solved exactly.
    """
    phase_margin_deg, lower_gain_margin_db = asked
    if not 0.0 < phase < 0.5 * pi:
        raise ValueError(
            f"phase_margin_deg = {shown(phase_margin_deg)}: a PID on an inertia reaches margins "
            "between 0 and 90 deg (both excluded)"
        )
    if factor <= cos(phase):
        raise ValueError(
            f"lower_gain_margin_db = {shown(lower_gain_margin_db)} contradicts a phase margin of "
            f"{shown(phase_margin_deg)} deg: q = ω_c²·cos φ/g_m would reach ω_c²; ask for "
            "a positive "
            "lower gain margin"
        )
    check_lower_gain_margin(factor, lower_gain_margin_db)
    _check_other_crossovers(phase, factor, lower_gain_margin_db)
    try:
        kp = moment * omega**2 * cos(phase)
        kr = moment * omega * sin(phase) / (1.0 - cos(phase) / factor)
        ki = kr * (kp / (moment * factor))
    except OverflowError:
        kp = ki = kr = inf
    if not all(0.0 < gain < inf for gain in (kp, ki, kr)):
        raise ValueError(
            f"the gains for J = {shown(moment)} and crossover_hz = "
            f"{shown(omega / (2.0 * pi))} leave the "
            "range of a double: choose other units"
        )
    return PID(kp, ki, kr)


def check_lower_gain_margin(factor: float, asked_db: float) -> None:
    """Refuse a lower gain margin that would leave the loop unstable."""
    if factor <= 1.0:
        raise ValueError(
            f"lower_gain_margin_db = {shown(asked_db)}: expected a positive number of dB, "
            "or the loop "
            "would already be unstable"
        )


def _check_other_crossovers(phase: float, factor: float, asked_db: float) -> None:
    """Refuse specifications whose loop crosses |L| = 1 again with a smaller phase margin.

    With s in units of ω_c and J = 1 the crossovers are the positive roots x = ω² of
    x³ − k_r²·x² + (2·k_i·k_r − k_p²)·x − k_i² = 0.
    """
    kp = cos(phase)
    kr = sin(phase) / (1.0 - kp / factor)
    ki = kr * kp / factor
    roots = np.roots([1.0, -(kr**2), 2.0 * ki * kr - kp**2, -(ki**2)])
    for root in roots:
        if abs(root.imag) > 1e-9 * abs(root) or root.real <= 0.0:
            continue
        omega = sqrt(root.real)
        margin = atan2(kp * omega, ki - kr * omega**2) - 0.5 * pi
        if abs(margin) < phase * (1.0 - 1e-6):
            raise ValueError(
                f"lower_gain_margin_db = {shown(asked_db)} contradicts a phase margin of "
                f"{degrees(phase):.6g} deg: |L| = 1 again at {omega:.4g} times the crossover, "
                f"where the phase margin is {degrees(margin):.4g} deg; ask for a larger lower "
                "gain margin"
            )
