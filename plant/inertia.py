"""The plant: a pure inertia."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..shaping.checks import positive

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class Inertia:
    """A rigid axis without friction, J·ÿ = u, g(s) = 1/(J·s²).

    Parameters
    ----------
    J : float
        Moment of inertia (or mass), positive.
    """

    J: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "J", positive("J", self.J))

    def system(self) -> control.StateSpace:
        """Return the python-control system u → (y, y_rate), states y and y_rate."""
        import control

        return control.ss(
            [[0.0, 1.0], [0.0, 0.0]],
            [[0.0], [1.0 / self.J]],
            [[1.0, 0.0], [0.0, 1.0]],
            [[0.0], [0.0]],
            inputs=["u"],
            outputs=["y", "y_rate"],
            states=["y", "y_rate"],
            name="plant",
        )

    def transfer(self) -> control.TransferFunction:
        """Return g(s) from u to y."""
        import control

        return control.tf([1.0], [self.J, 0.0, 0.0], inputs=["u"], outputs=["y"], name="plant")
