"""Inertia feedforward: the torque that the commanded acceleration needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..shaping.checks import finite
from .linear_system import static_gain

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class InertiaFeedforward:
    """Feedforward u = Ĵ·r̈, f(s) = Ĵ·s², fed by the shaper's own acceleration.

    Parameters
    ----------
    J_hat : float
        Estimate Ĵ of the inertia; 0 for none.
    """

    J_hat: float

    def __post_init__(self) -> None:
        estimate = finite("J_hat", self.J_hat)
        if estimate < 0.0:
            raise ValueError(f"J_hat = {self.J_hat!r}: expected a number ≥ 0")
        object.__setattr__(self, "J_hat", estimate)

    def system(self) -> control.StateSpace:
        """Return the python-control system r_acceleration → u_feedforward (a gain)."""
        return static_gain(
            [[self.J_hat]],
            inputs=["r_acceleration"],
            outputs=["u_feedforward"],
            name="feedforward",
        )

    def transfer(self) -> control.TransferFunction:
        """Return f(s) = Ĵ·s² from r to u (improper)."""
        import control

        f = [self.J_hat, 0.0, 0.0]
        return control.tf(f, [1.0], inputs=["r"], outputs=["u_feedforward"], name="feedforward")
