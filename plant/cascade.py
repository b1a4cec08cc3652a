"""The cascade of drives: position controller P over velocity controller PI."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import inf
from typing import TYPE_CHECKING

from ..shaping.checks import finite, positive
from ..shaping.real_numbers import real_number, shown

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class CascadedPI:
    """P-PI controller, as servo drives have it.

        u = velocity_gain·(ε + ∫ε dt/reset_time),   ε = position_gain·e + fv·ṙ − v,

    v the measured velocity, fv the velocity feedforward.

    Parameters
    ----------
    position_gain : float
        Velocity per position error (often kv), ≥ 0.
    velocity_gain : float
        Torque per velocity error.
    reset_time : float, optional
        Of the velocity controller, positive. Default: infinite, no integral.
    velocity_filter : float, optional
        Time constant ≥ 0 of a first-order filter of the measured velocity.
    velocity_feedforward : float, optional
        fv. Default: 1.

    Notes
    -----
    For fv = 1 and without filter it is the PID with kp = velocity_gain·(position_gain + 1/T_n),
    ki = velocity_gain·position_gain/T_n, kr = velocity_gain.
    """

    position_gain: float
    velocity_gain: float
    reset_time: float = inf
    _: KW_ONLY
    velocity_filter: float = 0.0
    velocity_feedforward: float = 1.0

    def __post_init__(self) -> None:
        for name in ("position_gain", "velocity_gain", "velocity_filter", "velocity_feedforward"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        if self.velocity_filter < 0.0:
            raise ValueError(
                f"velocity_filter = {shown(self.velocity_filter)}: expected a time ≥ 0"
            )
        if real_number("reset_time", self.reset_time) != inf:
            object.__setattr__(self, "reset_time", positive("reset_time", self.reset_time))

    @property
    def integral_gain(self) -> float:
        """Torque per integrated velocity error, velocity_gain/reset_time."""
        return self.velocity_gain / self.reset_time

    def transfer(self) -> control.TransferFunction:
        """Return k(s) from e to u, for a command that stands still (improper without filter)."""
        import control

        kv, lag = self.position_gain, self.velocity_filter
        inner = control.tf([kv * lag + 1.0, kv], [lag, 1.0] if lag else [1.0])
        outer = control.tf([self.velocity_gain, self.integral_gain], [1.0, 0.0])
        if self.reset_time == inf:
            outer = control.tf([self.velocity_gain], [1.0])
        return control.tf(inner * outer, inputs=["e"], outputs=["u_feedback"], name="controller")
