"""What is asked of a loop: margins, moves, tracking, requirements, and how results are told."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from math import inf, isnan
from types import MappingProxyType
from typing import Any, Literal

from ..plant import ServoLoop
from ..plant.commands import Command, as_command
from ..plant.disturbances import checked_disturbances
from ..shaping import InputShaper
from ..shaping.checks import finite, of_kind, positive
from ..shaping.frozen import Frozen
from ..shaping.real_numbers import real_number, shown
from .disturbances import Disturbances

Bound = float | tuple[float, float]
"""A positive number (bound on the magnitude) or a pair lower ≤ 0 ≤ upper."""


FigureUnit = Literal[
    "time", "position", "torque", "frequency", "angle", "decibel", "percent", "ratio", "compliance"
]
"""What a figure is measured in: s, rad or m, N m or N, Hz, deg, dB, %, 1, rad/(N m) or m/N."""

FIGURES: MappingProxyType[str, FigureUnit] = MappingProxyType(
    {
        "crossover": "frequency",
        "bandwidth": "frequency",
        "phase_margin": "angle",
        "lower_gain_margin": "decibel",
        "upper_gain_margin": "decibel",
        "delay_margin": "time",
        "modulus_margin": "ratio",
        "disk_margin": "ratio",
        "sensitivity_peak": "ratio",
        "complementary_peak": "ratio",
        "compliance_peak": "compliance",
        "step_overshoot": "percent",
        "duration": "time",
        "settling": "time",
        "load_settling": "time",
        "peak_error": "position",
        "peak_load_error": "position",
        "overshoot": "position",
        "left_over": "position",
        "residual_vibration": "position",
        "peak_torque": "torque",
        "saturated_time": "time",
        "disturbance_peak": "position",
        "disturbance_recovery": "time",
        "rms_load": "position",
        "rms_torque": "torque",
        "friction_spike": "position",
        "tracking_rms": "position",
        "tracking_peak": "position",
    }
)
"""The figures of a survey that can be required, each with what it is measured in."""

HIGHER_IS_BETTER = frozenset(
    {
        *("phase_margin", "lower_gain_margin", "upper_gain_margin", "delay_margin"),
        *("modulus_margin", "disk_margin"),
    }
)
"""Figures of which the least is the worst; of the others it is the greatest."""

OF_MOVES = (
    "duration",
    "settling",
    "load_settling",
    "peak_error",
    "peak_load_error",
    "overshoot",
    "left_over",
    "residual_vibration",
    "peak_torque",
    "saturated_time",
)
"""Figures that each move has; required by their name alone, the worst of all moves counts."""


@dataclass(frozen=True, kw_only=True)
class Move(Frozen):
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
    shapers : tuple of InputShaper
        Put on the planned move, one behind the other.
    duration : float, optional
        In s, for the planned move instead of the shortest.
    round_to : float, optional
        In s: the planned move lasts a whole multiple of it, such as a sample.
    minimum_jerk : bool
        The quintic of least squared jerk in place of the fastest move, as fast as the bounds
        allow.
    disturbances : Disturbances, optional
        What acts on the axis meanwhile.
    """

    name: str
    distance: float
    bounds: tuple[Bound, ...]
    limits_name: str
    settle_to: float
    shapers: tuple[InputShaper, ...] = ()
    duration: float | None = None
    round_to: float | None = None
    minimum_jerk: bool = False
    disturbances: Disturbances | None = None

    def __post_init__(self) -> None:
        if not finite("distance", self.distance):
            raise ValueError(f"distance = {shown(self.distance)}: expected a distance other than 0")
        if not 0.0 < real_number("settle_to", self.settle_to) < abs(self.distance):
            raise ValueError(
                f"settle_to = {shown(self.settle_to)}: expected a positive tolerance, smaller than "
                f"the distance {shown(self.distance)}"
            )
        given = (self.shapers,) if isinstance(self.shapers, InputShaper) else tuple(self.shapers)
        for shaper in given:
            of_kind("shapers", shaper, InputShaper, "input_shaper(kind, frequency_hz, damping)")
        object.__setattr__(self, "shapers", given)


@dataclass(frozen=True)
class Tracking:
    """A command that goes on, sidereal motion, a scan, a dither, or a torque that does.

    Attributes
    ----------
    name : str
        Unique among its kind.
    command : Ramp, Sine, Trajectory or a sum of them
    duration : float
        In s, from the command's start.
    after : float
        In s: errors count from then on. The loop starts at rest, and a command that starts with
        a velocity throws it off at first.
    disturbance : TorqueSteps, TorqueSine, SampledTorque, a list of them, or Disturbances, optional
        What acts on the axis meanwhile; against it alone the command is `Ramp(0.0)`.
    """

    name: str
    command: Command
    duration: float
    after: float = 0.0
    disturbance: Any = None

    def acting(self, loop: ServoLoop) -> dict[str, Any]:
        """Return the disturbances as `loop.respond` takes them."""
        if isinstance(self.disturbance, Disturbances):
            return self.disturbance.acting(loop, self.duration)
        return {"disturbance": self.disturbance}

    def __post_init__(self) -> None:
        if not isinstance(self.disturbance, Disturbances):
            object.__setattr__(self, "disturbance", checked_disturbances(self.disturbance) or None)
        object.__setattr__(self, "command", as_command(self.command))
        object.__setattr__(self, "duration", positive("duration", self.duration))
        if not 0.0 <= real_number("after", self.after) < self.duration:
            raise ValueError(
                f"after = {shown(self.after)}: expected a time from 0 to below the duration "
                f"{shown(self.duration)}"
            )


@dataclass(frozen=True)
class Requirement:
    """A bound on a figure of a survey.

    Attributes
    ----------
    name : str
        One of FIGURES; "slew.load_settling" is that of the move, or of the tracking, of this name.
    least, most : float, optional
        What it must not be below, and above: in s, rad or m, N m or N, Hz, deg, dB or %.

    Raises
    ------
    ValueError
        For a name of no figure, no bound at all, or bounds that nothing meets.
    """

    name: str
    least: float | None = None
    most: float | None = None

    def __post_init__(self) -> None:
        if self.figure not in FIGURES:
            raise ValueError(f"requirement {unknown_figure(self.name)}")
        if self.least is None and self.most is None:
            raise ValueError(f"requirement {self.name!r} bounds nothing: give least=… or most=…")
        for side in ("least", "most"):
            bound = getattr(self, side)
            if bound is not None:
                object.__setattr__(self, side, real_number(side, bound))
                if isnan(getattr(self, side)):
                    raise ValueError(f"requirement {self.name!r}: {side} = nan: expected a number")
        low, high = self.bounds
        if not low <= high:
            raise ValueError(
                f"requirement {self.name!r}: nothing is at least {shown(low)} and at most "
                f"{shown(high)}; exchange the two"
            )

    @property
    def figure(self) -> str:
        """The figure without the name of a move."""
        return self.name.rpartition(".")[2]

    @property
    def owner(self) -> str:
        """The move or tracking whose figure it is; empty where it is the worst of all."""
        return self.name.rpartition(".")[0]

    @property
    def unit(self) -> FigureUnit:
        """What the figure is measured in."""
        return FIGURES[self.figure]

    @property
    def bounds(self) -> tuple[float, float]:
        """Both bounds, infinite where there is none."""
        return (
            -inf if self.least is None else self.least,
            inf if self.most is None else self.most,
        )


def unknown_figure(name: Any) -> str:
    """Return what to say of the name of no figure."""
    near = get_close_matches(str(name).rpartition(".")[2], FIGURES, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{name!r} is of no figure: {hint}There are {', '.join(FIGURES)}"


@dataclass(frozen=True)
class Mode:
    """A lightly damped mode of what the plant carries; its damping ratio is from 0 to below 1."""

    name: str
    frequency_hz: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequency_hz", positive("frequency_hz", self.frequency_hz))
        if not 0.0 <= real_number("damping", self.damping) < 1.0:
            raise ValueError(
                f"damping = {shown(self.damping)}: expected a ratio from 0 to below 1, such as 0.02"
            )


@dataclass(frozen=True)
class Specification:
    """What a loop must achieve: its crossover and margins, positive, the phase's below 90°."""

    crossover_hz: float
    phase_margin_deg: float
    lower_gain_margin_db: float

    def __post_init__(self) -> None:
        for name in ("crossover_hz", "phase_margin_deg", "lower_gain_margin_db"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        if self.phase_margin_deg >= 90.0:
            raise ValueError(
                f"phase_margin_deg = {shown(self.phase_margin_deg)}: expected an angle between 0 "
                "and 90, such as 45"
            )


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

    @property
    def torque_unit(self) -> str:
        """N m of an angle, N of a length."""
        return "N m" if self.motion == "angle" else "N"

    @property
    def torque_name(self) -> str:
        """Torque of an angle, force of a length."""
        return "torque" if self.motion == "angle" else "force"

    def unit_of(self, kind: FigureUnit) -> tuple[str, float]:
        """Return the unit in which a figure is shown, and its value in SI units."""
        if kind == "position":
            return self.position_unit, self.position_scale
        if kind == "compliance":
            torque = f"({self.torque_unit})" if " " in self.torque_unit else self.torque_unit
            return f"{self.position_unit}/{torque}", self.position_scale
        return (self.torque_unit if kind == "torque" else _UNITS[kind]), 1.0


_UNITS = {
    "time": "s",
    "frequency": "Hz",
    "angle": "deg",
    "decibel": "dB",
    "percent": "%",
    "ratio": "",
}
