"""The PID that gives any axis a crossover, a phase margin and a lower gain margin."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians
from typing import Any

import numpy as np

from ..shaping.checks import finite, positive
from ..shaping.real_numbers import shown
from .axis import Axis
from .controller import Controller
from .discretise import Discretisation
from .flexible_inertia import FlexibleInertia
from .frequency_points import frequency_points
from .inertia import Inertia
from .inertia_pid import check_lower_gain_margin, inertia_pid
from .open_gains import OpenGains, pure_delay
from .pid import PID
from .pid_equations import Real, check_phase, gains_for, reachable_margins
from .stability import is_stable

_MOST_DB = 300.0  # beyond, the integral gain is nothing but rounding
_TRIED = 12  # lower gain margins that are tried for advice
_LOWER = 8  # gains at which a loop is looked at between its lower margin and 1


def design_pid(
    plant: Any,
    *,
    crossover_hz: float,
    phase_margin_deg: float,
    lower_gain_margin_db: float,
    derivative_filter: float = 0.0,
    filters: Sequence[Any] = (),
    sample_time: float | None = None,
    delay: float = 0.0,
    discretisation: Discretisation = "tustin",
) -> PID:
    """Return the PID that gives a loop exactly these three margins.

    With ω_c the crossover, φ the phase margin and g_m > 1 the lower gain margin as a factor,

        L(jω_c) = −e^(jφ),   L(jω_p) = −g_m at an ω_p < ω_c,

    four real equations for kp, ki, kr and ω_p. On a rigid inertia they are solved by

        kp = J·ω_c²·cos φ,   kr = J·ω_c·sin φ/(1 − cos φ/g_m),   ki = kr·kp/(J·g_m).

    Parameters
    ----------
    plant : float, Inertia, FlexibleInertia, Axis or python-control system
        A number is an inertia J > 0. Friction, torque limit and resolution are left out.
    crossover_hz : float
        Gain crossover |L| = 1, in Hz.
    phase_margin_deg : float
        Between 0 and 90 on a rigid inertia, and 180 on others, both excluded.
    lower_gain_margin_db : float
        By how many dB the gain may fall before the loop is unstable; positive. (Ideal PID on a
        pure inertia is conditionally stable and has no upper gain margin.)
    derivative_filter : float, optional
        Time constant of the filter of the error's rate.
    filters : sequence, optional
        Notch, LeadLag, LowPass or any python-control system behind the PID.
    sample_time : float, optional
        Of a digital controller, as in `Controller`. Default: continuous.
    delay : float, optional
        Computing delay of a digital controller, pure delay of a continuous one, ≥ 0.
    discretisation : "tustin", "matched" or "hold", optional
        Of a digital controller's filters, as in `Controller`.

    Returns
    -------
    PID
        With the derivative filter that was given.

    Raises
    ------
    ValueError
        For a value that is not finite or not positive, or for specifications that contradict each
        other or are out of reach, with the reason: a phase margin for which the controller would
        have to turn the phase by 90 deg or more, a lower gain margin that no integral gain gives,
        or another crossover of |L| = 1 with less phase margin.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII, solved exactly: the gains printed there
    (k_r = 11.09J, …) do not meet its own specifications.

    Examples
    --------
    >>> gains = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
    >>> round(gains.kr, 6), round(gains.kp / gains.kr, 6), round(gains.ki / gains.kr, 6)
    (5.402451, 5.167184, 7.012046)
    """
    omega = 2.0 * pi * positive("crossover_hz", crossover_hz)
    phase_margin_deg = finite("phase_margin_deg", phase_margin_deg)
    factor = _factor(lower_gain_margin_db)
    rigid = _inertia(plant)
    bare = not (derivative_filter or delay or len(filters)) and sample_time is None
    if rigid is not None and bare:
        asked = (phase_margin_deg, float(lower_gain_margin_db))
        return inertia_pid(rigid.J, omega, radians(phase_margin_deg), factor, asked)
    if not 0.0 < phase_margin_deg < 180.0:
        raise ValueError(
            f"phase_margin_deg = {shown(phase_margin_deg)}: expected an angle between 0 "
            "and 180 deg "
            "(both excluded)"
        )
    check_lower_gain_margin(factor, float(lower_gain_margin_db))
    law = PID(1.0, 1.0, 1.0, derivative_filter=derivative_filter)
    digital = sample_time is not None
    controller = Controller(
        law,
        filters=filters,
        sample_time=sample_time,
        delay=delay if digital else 0.0,
        discretisation=discretisation,
    )
    loop = OpenGains(rigid or plant, controller, 0.0 if digital else pure_delay(delay))
    return _designed(loop, omega, phase_margin_deg, factor)


def _inertia(plant: Any) -> Inertia | None:
    """Return the inertia that a number stands for, None for another plant."""
    if isinstance(plant, Axis | FlexibleInertia) or hasattr(plant, "ninputs"):
        return None
    if isinstance(plant, Inertia):
        return plant
    try:
        return Inertia(plant)
    except TypeError as error:
        raise TypeError(
            f"plant = {shown(plant)}: expected a number, an inertia; or Inertia, FlexibleInertia, "
            "Axis or a python-control system"
        ) from error


def _factor(lower_gain_margin_db: float) -> float:
    asked = finite("lower_gain_margin_db", lower_gain_margin_db)
    if abs(asked) > _MOST_DB:
        raise ValueError(f"lower_gain_margin_db = {shown(asked)}: expected at most {_MOST_DB:g} dB")
    return float(10.0 ** (asked / 20.0))


def _designed(loop: OpenGains, omega: float, phase_margin_deg: float, factor: float) -> PID:
    if loop.controller.sample_time is not None and omega * loop.controller.sample_time >= pi:
        raise ValueError(
            f"crossover_hz = {omega / (2.0 * pi):.6g} lies beyond half the sampling frequency, "
            f"{0.5 / loop.controller.sample_time:.6g} Hz: sample more often or lower the crossover"
        )
    phase = radians(phase_margin_deg)
    check_phase(loop.terms, omega, phase, phase_margin_deg)
    found = list(gains_for(loop.terms, omega, phase, factor))
    for gains in found:
        if _keeps(loop, gains, phase, factor):
            return loop.law(gains)
    why = (
        "the gains that meet all three give an unstable loop, or one that crosses |L| = 1 again "
        "with less phase margin"
        if found
        else "no integral gain gives this lower gain margin together with the other two"
    )
    raise ValueError(
        f"crossover_hz = {omega / (2.0 * pi):.6g}, phase_margin_deg = "
        f"{shown(phase_margin_deg)} and the "
        f"lower gain margin of {20.0 * np.log10(factor):.6g} dB are out of reach: {why}; lower the "
        f"crossover, {_other_margin(loop, omega, phase, factor)}or let analysis.tune_pid find the "
        "gains"
    )


def _other_margin(loop: OpenGains, omega: float, phase: float, factor: float) -> str:
    """Return the advice to ask for a lower gain margin with which a design succeeds, if any."""
    found = np.round(20.0 * np.log10(reachable_margins(loop.terms, omega, phase)), 1)
    found = found[(found > 0.0) & (found < _MOST_DB)]
    nearest = found[np.argsort(abs(found - 20.0 * np.log10(factor)), kind="stable")]
    for decibels in nearest[:: 1 + len(nearest) // _TRIED].tolist():
        other = _factor(decibels)
        if any(_keeps(loop, g, phase, other) for g in gains_for(loop.terms, omega, phase, other)):
            return f"ask for a lower gain margin of {decibels:.4g} dB, "
    return ""


def _keeps(loop: OpenGains, gains: Real, phase: float, factor: float) -> bool:
    """Return whether a loop has the margins that its equations say, and none that is smaller."""
    system = loop.system(gains)
    for gain in np.geomspace(1.0 / factor * (1.0 + 1e-6), 1.0, _LOWER).tolist():
        if not is_stable(gain * system, loop.delay):
            return False
    omega = frequency_points(system, loop.delay)
    values = loop.terms(omega) @ gains
    crossing = np.flatnonzero(np.diff(np.sign(np.log(abs(values)))))
    before, after = values[crossing], values[crossing + 1]
    share = np.log(abs(before)) / np.log(abs(before) / abs(after))
    angles = np.angle(-before) + share * np.angle(after / before)
    return bool((abs(angles) > phase * (1.0 - 1e-3)).all())
