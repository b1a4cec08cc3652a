"""A plant with one flexible mode: two inertias joined by a spring and a damper."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Literal

from ..shaping.checks import finite, one_of, positive
from ..shaping.real_numbers import shown

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class FlexibleInertia:
    """An axis with one flexible mode: a motor carries a load on a spring and a damper.

    With λ the load's share of J, w = y_load − y_motor the twist and ω = 2π·frequency_hz,

        (1 − λ)·J·ÿ_motor = u + c·ẇ + k·w,   λ·J·ÿ_load = −(c·ẇ + k·w),
        k = λ(1 − λ)·J·ω²,   c = 2ζω·λ(1 − λ)·J,

    and from the torque to the position that is measured

        g_motor(s) = (s²/(1 − λ) + 2ζω·s + ω²)/(J·s²·(s² + 2ζω·s + ω²)),
        g_load(s) = (2ζω·s + ω²)/(J·s²·(s² + 2ζω·s + ω²)),

    both 1/(J·s²) far below the resonance.

    Parameters
    ----------
    J : float
        Moment of inertia (or mass) of motor and load together, positive.
    frequency_hz : float
        Free-free resonance, in cycles per time unit, positive.
    damping : float
        Its damping ratio ζ, 0 ≤ ζ < 1.
    load_fraction : float, optional
        λ, the load's inertia over J, between 0 and 1, both excluded.
    sensor : "motor" or "load", optional
        Whose position is y. On the motor (collocated) the resonance follows an antiresonance;
        on the load (non-collocated) there is none, and the phase falls by another 180 deg.

    Raises
    ------
    ValueError
        For a parameter outside its range, or units in which a coefficient leaves a double's.

    Notes
    -----
    With Ĵ = J the feedforward moves the whole, yet the spring lets motor and load swing. After
    a move with velocity v(t), each pole p of the closed loop rings in proportion to

        |V(p)|,   V(s) = ∫ v(t)·e^(−st) dt,

    so a command whose spectrum is zero at the lightly damped pair leaves no vibration. Where a
    stiff loop holds the motor on its command, that pair is the load on a locked motor:
    `antiresonance_hz` and `antiresonance_damping`.

    Examples
    --------
    >>> axis = FlexibleInertia(2.0, frequency_hz=10.0, damping=0.01, load_fraction=0.75)
    >>> axis.antiresonance_hz, axis.antiresonance_damping
    (5.0, 0.005)
    """

    J: float
    frequency_hz: float
    damping: float
    _: KW_ONLY
    load_fraction: float = 0.5
    sensor: Literal["motor", "load"] = "motor"

    def __post_init__(self) -> None:
        for name, check in (
            ("J", positive),
            ("frequency_hz", positive),
            ("damping", finite),
            ("load_fraction", finite),
        ):
            object.__setattr__(self, name, check(name, getattr(self, name)))
        if not 0.0 <= self.damping < 1.0:
            raise ValueError(
                f"damping = {shown(self.damping)}: expected a damping ratio from 0 to below 1 "
                "(1 % is 0.01)"
            )
        if not 0.0 < self.load_fraction < 1.0:
            raise ValueError(
                f"load_fraction = {shown(self.load_fraction)}: expected the load's share "
                "of J, between "
                "0 and 1 (both excluded); without a load use Inertia"
            )
        one_of("sensor", self.sensor, ("motor", "load"))
        stiffness = self._omega * self._omega
        motor = (1.0 - self.load_fraction) * self.J
        if not (
            all(0.0 < x < inf for x in (stiffness, self.J * stiffness, motor)) and 1.0 / motor < inf
        ):
            raise ValueError(
                f"J = {shown(self.J)} and frequency_hz = {shown(self.frequency_hz)} make "
                "coefficients beyond "
                "the range of a double: choose other units"
            )

    @property
    def antiresonance_hz(self) -> float:
        """Natural frequency of the load on a locked motor, frequency_hz·√(1 − λ)."""
        return self.frequency_hz * sqrt(1.0 - self.load_fraction)

    @property
    def antiresonance_damping(self) -> float:
        """Damping ratio of the load on a locked motor, ζ·√(1 − λ)."""
        return self.damping * sqrt(1.0 - self.load_fraction)

    @property
    def _omega(self) -> float:
        return 2.0 * pi * self.frequency_hz

    def system(self) -> control.StateSpace:
        """Return the python-control system u → (y, y_rate, y_load, twist).

        States y, y_rate, twist and twist_rate: a constant offset of position shifts y alone. The
        motor's position is y_load − twist.
        """
        import control

        spring, damper = self._omega**2, 2.0 * self.damping * self._omega
        motor, load = 1.0 - self.load_fraction, self.load_fraction
        on_motor = self.sensor == "motor"
        share = load if on_motor else -motor
        drive = 1.0 / (motor * self.J)
        return control.ss(
            [
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, share * spring, share * damper],
                [0.0, 0.0, 0.0, 1.0],
                [0.0, 0.0, -spring, -damper],
            ],
            [[0.0], [drive if on_motor else 0.0], [0.0], [-drive]],
            [
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [1.0, 0.0, 1.0 if on_motor else 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
            ],
            [[0.0]] * 4,
            inputs=["u"],
            outputs=["y", "y_rate", "y_load", "twist"],
            states=["y", "y_rate", "twist", "twist_rate"],
            name="plant",
        )

    def transfer(self) -> control.TransferFunction:
        """Return g(s) from u to y, the position that is measured."""
        import control

        spring, damper = self._omega**2, 2.0 * self.damping * self._omega
        numerator = [damper, spring] if self.damping else [spring]
        if self.sensor == "motor":
            numerator = [1.0 / (1.0 - self.load_fraction), damper, spring]
        denominator = [self.J * x for x in (1.0, damper, spring)] + [0.0, 0.0]
        return control.tf(numerator, denominator, inputs=["u"], outputs=["y"], name="plant")
