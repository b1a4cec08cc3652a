"""The PID controller and its exact design for an inertia."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import atan2, cos, degrees, inf, isfinite, pi, radians, sin, sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..shaping.checks import finite, one_of, positive
from .inertia import Inertia
from .linear_system import linear_system

if TYPE_CHECKING:
    import control


_MOST_DB = 300.0  # beyond, the integral gain is nothing but rounding

Rate = Literal["measured", "differenced"]
"""How a sampled PID comes by the error's rate."""


@dataclass(frozen=True)
class PID:
    """PID controller, u = kp·e + ki·∫e dt + kr·ė; ideal, or with a filter of the rate.

    Parameters
    ----------
    kp : float
        Proportional gain, torque per position.
    ki : float
        Integral gain, torque per position and time.
    kr : float
        Rate (derivative) gain, torque per velocity.
    derivative_filter : float, optional
        Time constant T_f ≥ 0: in place of ė it is ė_f that acts, T_f·ė_f′ = ė − ė_f.

    Notes
    -----
    The derivative needs no filter: the loop hands the controller the error's rate ė, which is
    known exactly because a shaper supplies the command's velocity and the plant its own.
    """

    kp: float
    ki: float
    kr: float
    _: KW_ONLY
    derivative_filter: float = 0.0

    def __post_init__(self) -> None:
        for name in ("kp", "ki", "kr", "derivative_filter"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        if self.derivative_filter < 0.0:
            raise ValueError(f"derivative_filter = {self.derivative_filter!r}: expected a time ≥ 0")

    def system(self) -> control.StateSpace:
        """Return the python-control system (e, e_rate) → u_feedback, state ∫e (and ė_f)."""
        import control

        names, pole = ["e_integral"], 0.0
        a, b, c, d = [[0.0]], [[1.0, 0.0]], [[self.ki]], [[self.kp, self.kr]]
        if self.derivative_filter:
            names, pole = ["e_integral", "e_rate_filtered"], 1.0 / self.derivative_filter
            a, b = [[0.0, 0.0], [0.0, -pole]], [[1.0, 0.0], [0.0, pole]]
            c, d = [[self.ki, self.kr]], [[self.kp, 0.0]]
        return control.ss(
            *(a, b, c, d),
            inputs=["e", "e_rate"],
            outputs=["u_feedback"],
            states=names,
            name="controller",
        )

    def transfer(self) -> control.TransferFunction:
        """Return k(s) = kp + ki/s + kr·s/(T_f·s + 1) from e to u (improper without filter)."""
        import control

        lag = self.derivative_filter
        numerator, denominator = [self.kr, self.kp, self.ki], [1.0, 0.0]
        if lag:
            numerator = [self.kr + self.kp * lag, self.kp + self.ki * lag, self.ki]
            denominator = [lag, 1.0, 0.0]
        if self.ki == 0.0:
            numerator, denominator = numerator[:-1], denominator[:-1]
        return control.tf(
            numerator, denominator, inputs=["e"], outputs=["u_feedback"], name="controller"
        )

    def sampled(self, dt: float, *, rate: Rate = "measured") -> control.StateSpace:
        """Return the digital controller, run once every dt.

            u_k = kp·e_k + ki·I_k + kr·ė_k,   I_k = I_{k−1} + dt·e_k

        The integral is a running sum that counts the present error (backward rectangles). With
        rate="measured" ė_k is an input; with "differenced" it is (e_k − e_{k−1})/dt. So

            k(z) = kp + ki·dt·z/(z − 1) from e, and kr from e_rate,   or
            k(z) = kp + ki·dt·z/(z − 1) + kr·(z − 1)/(dt·z) from e alone.

        With a filter of the rate, (T_f·D_{k−1} + dt·ė_k)/(T_f + dt) takes the place of ė_k.

        Parameters
        ----------
        dt : float
            Sampling time, positive.
        rate : "measured" or "differenced", optional

        Returns
        -------
        control.StateSpace
            (e, e_rate) → u_feedback with state e_integral = I_{k−1}, or e → u_feedback with the
            further state e_past = e_{k−1}; with a filter of the rate D_{k−1}, too, as
            e_rate_filtered. A state whose gain is 0 is left out.

        Raises
        ------
        ValueError
            For a dt that is not positive or so far from the gains' unit of time that ki·dt or
            kr/dt leaves the range of a double, or another rate.

        Examples
        --------
        >>> digital = PID(kp=2.0, ki=4.0, kr=0.5).sampled(0.25, rate="differenced")
        >>> complex(digital(-1.0)).real
        6.5
        """
        dt = positive("dt", dt)
        one_of("rate", rate, ("measured", "differenced"))
        measured = rate == "measured"
        lag = self.derivative_filter
        slope = (dt if measured else 1.0) / (lag + dt)  # of what the rate comes from
        direct = self.kp + self.ki * dt + (0.0 if measured else self.kr * slope)
        if not (isfinite(direct) and isfinite(self.kr * slope)):
            raise ValueError(
                f"dt = {dt!r}: ki·dt or kr/dt leaves the range of a double; choose other units"
            )
        kept = lag / (lag + dt)
        past = 0.0 if measured else -slope
        a = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, past, kept]])
        b = np.array([[dt, 0.0], [1.0, 0.0], [0.0, slope] if measured else [slope, 0.0]])
        c = np.array([[self.ki, self.kr * past, self.kr * kept]])
        names = np.array(["e_integral", "e_past", "e_rate_filtered"])
        used = c[0] != 0.0
        inputs = 2 if measured else 1
        matrices = (
            a[np.ix_(used, used)],
            b[used, :inputs],
            c[:, used],
            np.array([[direct, self.kr * slope]])[:, :inputs],
        )
        return linear_system(
            matrices,
            dt,
            inputs=["e", "e_rate"][:inputs],
            outputs=["u_feedback"],
            states=names[used].tolist(),
            name="controller",
        )


def design_pid(
    inertia: Inertia | float,
    *,
    crossover_hz: float,
    phase_margin_deg: float,
    lower_gain_margin_db: float,
) -> PID:
    """Return the PID that gives an inertia exactly these three margins.

    With ω_c the crossover, φ the phase margin, g_m > 1 the lower gain margin as a factor and
    k(s) = k_r·(s² + p·s + q)/s,

        k_r·p = J·ω_c²·cos φ,   q = k_r·p/(J·g_m),   k_r = J·ω_c³·sin φ/(ω_c² − q).

    Parameters
    ----------
    inertia : Inertia or float
        J > 0.
    crossover_hz : float
        Gain crossover |L| = 1, in Hz.
    phase_margin_deg : float
        Between 0 and 90, both excluded.
    lower_gain_margin_db : float
        By how many dB the gain may fall before the loop is unstable; positive. (Ideal PID on a
        pure inertia is conditionally stable and has no upper gain margin.)

    Returns
    -------
    PID

    Raises
    ------
    ValueError
        For a value that is not finite or not positive, or for specifications that contradict
        each other: a phase margin outside (0, 90) deg, or q ≥ ω_c² (g_m ≤ cos φ, a lower gain
        margin so small that the zeros lie beyond the crossover), or a lower gain margin so small
        that |L| = 1 again at a frequency with less phase margin.

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
    moment = (inertia if isinstance(inertia, Inertia) else Inertia(inertia)).J
    omega = 2.0 * pi * positive("crossover_hz", crossover_hz)
    phase_margin_deg = finite("phase_margin_deg", phase_margin_deg)
    phase = radians(phase_margin_deg)
    if not 0.0 < phase < 0.5 * pi:
        raise ValueError(
            f"phase_margin_deg = {phase_margin_deg!r}: a PID on an inertia reaches margins "
            "between 0 and 90 deg (both excluded)"
        )
    lower_gain_margin_db = finite("lower_gain_margin_db", lower_gain_margin_db)
    if abs(lower_gain_margin_db) > _MOST_DB:
        raise ValueError(
            f"lower_gain_margin_db = {lower_gain_margin_db!r}: expected at most {_MOST_DB:g} dB"
        )
    factor = 10.0 ** (lower_gain_margin_db / 20.0)
    if factor <= cos(phase):
        raise ValueError(
            f"lower_gain_margin_db = {lower_gain_margin_db!r} contradicts a phase margin of "
            f"{phase_margin_deg!r} deg: q = ω_c²·cos φ/g_m would reach ω_c²; ask for a positive "
            "lower gain margin"
        )
    if factor <= 1.0:
        raise ValueError(
            f"lower_gain_margin_db = {lower_gain_margin_db!r}: expected a positive number of dB, "
            "or the loop would already be unstable"
        )
    _check_other_crossovers(phase, factor, lower_gain_margin_db)
    try:
        kp = moment * omega**2 * cos(phase)
        kr = moment * omega * sin(phase) / (1.0 - cos(phase) / factor)
        ki = kr * (kp / (moment * factor))
    except OverflowError:
        kp = ki = kr = inf
    if not all(0.0 < gain < inf for gain in (kp, ki, kr)):
        raise ValueError(
            f"the gains for J = {moment!r} and crossover_hz = {crossover_hz!r} leave the range of "
            "a double: choose other units"
        )
    return PID(kp, ki, kr)


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
                f"lower_gain_margin_db = {asked_db!r} contradicts a phase margin of "
                f"{degrees(phase):.6g} deg: |L| = 1 again at {omega:.4g} times the crossover, "
                f"where the phase margin is {degrees(margin):.4g} deg; ask for a larger lower "
                "gain margin"
            )


def printed_pid(inertia: Inertia | float) -> PID:
    """Return the gains as printed in Thompson's Section VII: a known erratum, kept to compare.

        k_r = 11.09 J,   k_i = 6.286 k_r,   k_p = 3.187 k_r

    They do not meet that section's own specifications (1 Hz, 45 deg, 12 dB, 40 % overshoot):
    the loop has 1.750 Hz, 73.0 deg, 15.0 dB and 21.5 %. Use `design_pid` for a loop that does.

    Parameters
    ----------
    inertia : Inertia or float
        J > 0. (The paper prints a further factor J in k_i and k_p, dimensionally wrong.)
    """
    kr = 11.09 * (inertia if isinstance(inertia, Inertia) else Inertia(inertia)).J
    return PID(kp=3.187 * kr, ki=6.286 * kr, kr=kr)
