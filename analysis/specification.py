"""What is asked of a loop: crossover and margins, moves, modes, and how results are told."""

from dataclasses import dataclass
from typing import Literal

Bound = float | tuple[float, float]
"""A positive number (bound on the magnitude) or a pair lower < 0 < upper."""


@dataclass(frozen=True, kw_only=True)
class Move:
    """One move: a signed distance under limits, and the tolerance to which it must settle.

    Attributes
    ----------
    name : str
        Unique in its scenario.
    distance : float
        In rad or m, not zero.
    bounds : tuple of float or (float, float)
        Bounds on velocity, acceleration, … in rad/s^k or m/s^k, as `Limits.from_bounds` takes
        them; infinite where there is none.
    limits_name : str
        The name of the set of limits.
    settle_to : float
        In rad or m, positive and smaller than the distance.
    """

    name: str
    distance: float
    bounds: tuple[Bound, ...]
    limits_name: str
    settle_to: float


@dataclass(frozen=True)
class Mode:
    """A lightly damped mode of what the plant carries; `damping` is its damping ratio."""

    name: str
    frequency_hz: float
    damping: float = 0.0


@dataclass(frozen=True)
class Specification:
    """What a loop must achieve: its crossover frequency and margins."""

    crossover_hz: float
    phase_margin_deg: float
    lower_gain_margin_db: float


@dataclass(frozen=True)
class Labels:
    """How a survey is told: its title, the kind of motion, and the unit of positions.

    Attributes
    ----------
    title : str
    motion : {"angle", "length"}
        Whether positions are in rad, and torques in N m, or in m and N.
    position_unit : str
        The unit in which positions are shown.
    position_scale : float
        Its value in rad or m.
    """

    title: str = ""
    motion: Literal["angle", "length"] = "angle"
    position_unit: str = "rad"
    position_scale: float = 1.0
