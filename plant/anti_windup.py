"""What keeps an integral from winding up while the torque is at its limit."""

from __future__ import annotations

from dataclasses import dataclass

from ..shaping.checks import positive


@dataclass(frozen=True)
class BackCalculation:
    """The integral follows the limit, I ← I + (T/tracking_time)·(u − w)/ki after each sample.

    w is the torque asked for, u what the limit leaves of it.

    Parameters
    ----------
    tracking_time : float
        Positive; at least half a sample, or the limited loop's integral is unstable.
    """

    tracking_time: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "tracking_time", positive("tracking_time", self.tracking_time))


@dataclass(frozen=True)
class Clamp:
    """The integral's torque ki·I stays within ±integral_limit.

    Parameters
    ----------
    integral_limit : float
        Positive; it acts only well below the torque limit.
    """

    integral_limit: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "integral_limit", positive("integral_limit", self.integral_limit))
