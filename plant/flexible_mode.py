"""One flexible mode of an axis, as a measurement or a calculation gives it."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import pi, sqrt

from ..shaping.checks import finite, positive
from ..shaping.real_numbers import shown


@dataclass(frozen=True)
class FlexibleMode:
    """A flexible mode, free-free or with the motor held.

    Free-free, with the rigid body's shape 1 and all mode shapes normalised by the inertia J,

        J·(q̈ + 2ζω·q̇ + ω²·q) = a·(u + d_motor) + b·d_load,
        y_motor = q_0 + Σ a_i·q_i,   y_load = q_0 + Σ b_i·q_i.

    With the motor held, an appendage of the share λ of J swings on the motor:

        ẍ + 2ζω·ẋ + ω²·x = −ÿ_motor,   a torque λ·J·(ω²·x + 2ζω·ẋ) on the motor.

    Parameters
    ----------
    frequency_hz : float
        Natural frequency in cycles per time unit, positive.
    damping : float, optional
        Damping ratio ζ, 0 ≤ ζ < 1. Default: 0.
    load_fraction : float, optional
        Share λ of J that swings, between 0 and 1, both excluded. For a free-free mode it stands
        for the only mode of an axis, a² = λ/(1 − λ) and a·b = −1.
    motor_shape, load_shape : float, optional
        a and b, both or none; instead of `load_fraction`.
    held : bool, optional
        Whether frequency and damping are those with the motor held. Default: free-free.

    Raises
    ------
    ValueError
        For a value out of range, or shapes and fraction both or none.

    Examples
    --------
    >>> FlexibleMode(6.0, 0.01, load_fraction=0.5, held=True).frequency_hz
    6.0
    """

    frequency_hz: float
    damping: float = 0.0
    _: KW_ONLY
    load_fraction: float | None = None
    motor_shape: float | None = None
    load_shape: float | None = None
    held: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequency_hz", positive("frequency_hz", self.frequency_hz))
        object.__setattr__(self, "damping", finite("damping", self.damping))
        if not 0.0 <= self.damping < 1.0:
            raise ValueError(
                f"damping = {shown(self.damping)}: expected a damping ratio from 0 to below 1 "
                "(1 % is 0.01)"
            )
        for name in ("load_fraction", "motor_shape", "load_shape"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, finite(name, getattr(self, name)))
        self._check_share()

    def _check_share(self) -> None:
        shapes = (self.motor_shape is not None) + (self.load_shape is not None)
        if self.load_fraction is None and (self.held or shapes < 2):
            wanted = (
                "load_fraction" if self.held else "load_fraction, or motor_shape and load_shape"
            )
            raise ValueError(
                f"a mode of {shown(self.frequency_hz)} Hz without its share: give {wanted}"
            )
        if self.load_fraction is None:
            return
        if shapes:
            raise ValueError(
                f"load_fraction = {shown(self.load_fraction)} beside a mode shape: give "
                "one or the other"
            )
        if not 0.0 < self.load_fraction < 1.0:
            raise ValueError(
                f"load_fraction = {shown(self.load_fraction)}: expected the share of J "
                "that swings, "
                "between 0 and 1 (both excluded)"
            )

    @property
    def omega(self) -> float:
        """Natural frequency in radians per time unit."""
        return 2.0 * pi * self.frequency_hz

    @property
    def shapes(self) -> tuple[float, float]:
        """Shapes a, b of a free-free mode at motor and load."""
        if self.load_fraction is None:
            return float(self.motor_shape or 0.0), float(self.load_shape or 0.0)
        a = sqrt(self.load_fraction / (1.0 - self.load_fraction))
        return a, -1.0 / a
