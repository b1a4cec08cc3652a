"""The PID controller."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import isfinite
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..shaping.checks import finite, one_of, positive
from ..shaping.real_numbers import shown
from .inertia import Inertia
from .linear_system import linear_system
from .models import Rational

if TYPE_CHECKING:
    import control


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
            raise ValueError(
                f"derivative_filter = {shown(self.derivative_filter)}: expected a time ≥ 0"
            )

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

        k = self.model()
        names = {"inputs": ["e"], "outputs": ["u_feedback"], "name": "controller"}
        return control.tf(k.numerator, k.denominator, **names)

    def model(self) -> Rational:
        """Return the numbers of `transfer`."""
        lag = self.derivative_filter
        numerator, denominator = [self.kr, self.kp, self.ki], [1.0, 0.0]
        if lag:
            numerator = [self.kr + self.kp * lag, self.kp + self.ki * lag, self.ki]
            denominator = [lag, 1.0, 0.0]
        if self.ki == 0.0:
            numerator, denominator = numerator[:-1], denominator[:-1]
        return Rational(np.array(numerator), np.array(denominator))

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
                f"dt = {shown(dt)}: ki·dt or kr/dt leaves the range of a double; choose other units"
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
