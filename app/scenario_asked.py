"""The tables of a scenario file of format 2 that say what is asked: commands and disturbances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from ..shaping.derivatives import DERIVATIVE_NAMES
from . import scenario_kinds as kinds
from .scenario_checks import (
    LIMIT_SET,
    MODE_NAMES,
    NAME,
    POSITION_DENSITY_UNIT,
    POSITION_UNIT,
    TORQUE_DENSITY_UNIT,
    TORQUE_UNIT,
    TRACKING_NAME,
    whole,
)
from .scenario_forces import take_forces
from .scenario_keys import choice

_CLOSED: ConfigDict = ConfigDict(extra="forbid")
_MISSING: Any = None
ShaperKind = Literal["ZV", "ZVD", "ZVDD", "EI"]
_TORQUES = ("torque_step", "torque_sine", "torque_file", "torque_spectrum")
_On = Annotated[Literal["motor", "load"], choice("motor", "load")]


@dataclass(frozen=True, kw_only=True)
class FeedforwardSection:
    """Feedforward by the command's derivatives, all but that of an estimated inertia."""

    __pydantic_config__: ClassVar = _CLOSED
    velocity: Annotated[float | None, kinds.gain(1, "viscous friction", "")] = None
    acceleration: Annotated[float | None, kinds.gain(2, "torque per acceleration", "")] = None
    jerk: Annotated[float | None, kinds.gain(3, "torque per jerk", "")] = None
    snap: Annotated[float | None, kinds.gain(4, "torque per snap", "")] = None
    friction: Annotated[float, kinds.torque("not below zero")] = 0.0
    inverse: Annotated[bool | Literal["low-frequency"], choice(True, False, "low-frequency")] = (
        False
    )
    lead: Annotated[float | Literal["auto"], kinds.LEAD] = 0.0

    @property
    def gains(self) -> dict[int, float]:
        """Torque by number of the command's derivative, as far as given."""
        given = {k: getattr(self, name) for k, name in enumerate(DERIVATIVE_NAMES[:5]) if k}
        return {k: gain for k, gain in given.items() if gain is not None}

    def __post_init__(self) -> None:
        if self.inverse and self.gains:
            names = ", ".join(DERIVATIVE_NAMES[k] for k in self.gains)
            raise ValueError(
                f"has an inverse beside {names}, which the inverse has; keep one of the two"
            )


@dataclass(frozen=True, kw_only=True)
class ShaperSection:
    """An input shaper behind each planned move."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Annotated[ShaperKind, choice("ZV", "ZVD", "ZVDD", "EI")]
    modes: Annotated[tuple[str, ...] | None, MODE_NAMES] = None
    frequency: Annotated[float | None, kinds.HERTZ] = None
    damping: Annotated[float, kinds.DAMPING] = 0.0
    vibration: Annotated[float, kinds.SHARE] = 0.05

    def __post_init__(self) -> None:
        if (self.modes is None) == (self.frequency is None):
            raise ValueError(
                'needs a mode to null: write either modes = ["tower"], names of modes of this '
                'file, or frequency = "6 Hz"'
            )


@dataclass(frozen=True, kw_only=True)
class SineSection:
    """A sinusoidal command."""

    __pydantic_config__: ClassVar = _CLOSED
    amplitude: Annotated[float, kinds.moved(sign="positive")]
    frequency: Annotated[float, kinds.HERTZ]


@dataclass(frozen=True, kw_only=True)
class ScanSection:
    """Lines at constant velocity, back and forth."""

    __pydantic_config__: ClassVar = _CLOSED
    length: Annotated[float, kinds.moved()]
    rate: Annotated[float, kinds.moved(1, sign="positive")]
    lines: Annotated[int, whole(1000, "lines = 2")] = 1
    limits: Annotated[str, LIMIT_SET, Field(validate_default=True)] = _MISSING


@dataclass(frozen=True, kw_only=True)
class FileSection:
    """Positions over time in a CSV file, followed within limits."""

    __pydantic_config__: ClassVar = _CLOSED
    path: Annotated[str, NAME]
    unit: Annotated[str | None, POSITION_UNIT] = None
    time: Annotated[str, NAME] = "0"
    position: Annotated[str, NAME] = "1"
    sample_time: Annotated[float, kinds.SECONDS] = 1e-3
    limits: Annotated[str, LIMIT_SET, Field(validate_default=True)] = _MISSING


@dataclass(frozen=True, kw_only=True)
class OntoSection:
    """From rest onto a target that is this far away at the start, and on with it."""

    __pydantic_config__: ClassVar = _CLOSED
    distance: Annotated[float, kinds.moved()]
    limits: Annotated[str, LIMIT_SET, Field(validate_default=True)] = _MISSING


def _check_duration(duration: float | None, after: float, *, endless: bool) -> None:
    """Refuse what never ends, or ends before its errors count."""
    if endless and duration is None:
        raise ValueError('goes on for ever; write duration = "10 s"')
    if duration is not None and after >= duration:
        raise ValueError(
            f"counts errors after {after:g} s of {duration:g} s; write a longer "
            "duration or a smaller after"
        )


@dataclass(frozen=True, kw_only=True)
class TorqueStepSection:
    """A disturbing torque that comes and stays."""

    __pydantic_config__: ClassVar = _CLOSED
    torque: Annotated[float | None, kinds.torque()] = None
    force: Annotated[float | None, kinds.torque()] = None
    time: Annotated[float, kinds.TIME] = 0.0
    on: _On = "motor"

    def __post_init__(self) -> None:
        take_forces(self, "torque")
        if self.torque is None:
            raise ValueError('has no torque; write torque = "1 N m", or force = "1 N"')


@dataclass(frozen=True, kw_only=True)
class ActingSineSection:
    """A sinusoidal torque."""

    __pydantic_config__: ClassVar = _CLOSED
    amplitude: Annotated[float, kinds.torque("positive")]
    frequency: Annotated[float, kinds.HERTZ]
    on: _On = "motor"


@dataclass(frozen=True, kw_only=True)
class TorqueSineSection(ActingSineSection):
    """A sinusoidal torque, against which the loop holds its position."""

    name: Annotated[str, TRACKING_NAME, Field(validate_default=True)] = "torque sine"
    duration: Annotated[float | None, kinds.SECONDS] = None
    after: Annotated[float, kinds.TIME] = 0.0

    def __post_init__(self) -> None:
        _check_duration(self.duration, self.after, endless=True)


@dataclass(frozen=True, kw_only=True)
class ActingFileSection:
    """Torques over time in a CSV file, each held until the next."""

    __pydantic_config__: ClassVar = _CLOSED
    path: Annotated[str, NAME]
    unit: Annotated[str | None, TORQUE_UNIT] = None
    time: Annotated[str, NAME] = "0"
    torque: Annotated[str, NAME] = "1"
    force: Annotated[str | None, NAME] = None
    on: _On = "motor"

    def __post_init__(self) -> None:
        take_forces(self, "torque")


@dataclass(frozen=True, kw_only=True)
class TorqueFileSection(ActingFileSection):
    """Torques over time in a CSV file, against which the loop holds its position."""

    name: Annotated[str, TRACKING_NAME, Field(validate_default=True)] = "torque file"
    duration: Annotated[float | None, kinds.SECONDS] = None
    after: Annotated[float, kinds.TIME] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_duration(self.duration, self.after, endless=False)


@dataclass(frozen=True, kw_only=True)
class WindSection:
    """A random torque."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Annotated[
        Literal["first_order", "double_pole", "von_karman"],
        choice("first_order", "double_pole", "von_karman"),
    ]
    sigma: Annotated[float, kinds.torque("positive")]
    corner: Annotated[float | None, kinds.HERTZ] = None
    length: Annotated[float | None, kinds.LENGTH] = None
    speed: Annotated[float | None, kinds.SPEED] = None
    on: _On = "load"

    def __post_init__(self) -> None:
        given = [name for name in ("corner", "length", "speed") if getattr(self, name) is not None]
        wanted = ["length", "speed"] if self.kind == "von_karman" else ["corner"]
        if given != wanted:
            raise ValueError(
                f"of kind {self.kind!r} has {', '.join(given) or 'no frequency'}; write "
                + " and ".join({"corner": 'corner = "0.5 Hz"', "length": 'length = "80 m"',
                                "speed": 'speed = "8 m/s"'}[name] for name in wanted)
                + " alone"
            )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class SpectrumSection:
    """A one-sided power spectral density: a table here, or two columns of a CSV file."""

    __pydantic_config__: ClassVar = _CLOSED
    frequencies: Annotated[tuple[float, ...] | None, kinds.FREQUENCIES] = None
    path: Annotated[str | None, NAME] = None
    frequency: Annotated[str, NAME] = "0"
    density: Annotated[str, NAME] = "1"

    def __post_init__(self) -> None:
        table = (self.frequencies is not None) + (self._densities is not None)
        if table + 2 * (self.path is not None) != 2:
            raise ValueError(
                "needs a table: write either frequencies and densities, or the path of a CSV file"
            )

    @property
    def _densities(self) -> tuple[float, ...] | None:
        return getattr(self, "densities", None)


@dataclass(frozen=True, kw_only=True)
class TorqueSpectrumSection(SpectrumSection):
    """A random torque."""

    densities: Annotated[tuple[float, ...] | None, kinds.TORQUE_DENSITIES] = None
    unit: Annotated[str | None, TORQUE_DENSITY_UNIT] = None
    on: _On = "load"


@dataclass(frozen=True, kw_only=True)
class EncoderSpectrumSection(SpectrumSection):
    """Random errors of the measured position."""

    densities: Annotated[tuple[float, ...] | None, kinds.POSITION_DENSITIES] = None
    unit: Annotated[str | None, POSITION_DENSITY_UNIT] = None


@dataclass(frozen=True, kw_only=True)
class ActingSection:
    """What acts on the axis during a move or a tracking."""

    __pydantic_config__: ClassVar = _CLOSED
    torque_step: TorqueStepSection | None = None
    force_step: TorqueStepSection | None = None
    torque_sine: ActingSineSection | None = None
    force_sine: ActingSineSection | None = None
    torque_file: ActingFileSection | None = None
    force_file: ActingFileSection | None = None
    wind: WindSection | None = None
    torque_spectrum: TorqueSpectrumSection | None = None
    force_spectrum: TorqueSpectrumSection | None = None
    encoder_spectrum: EncoderSpectrumSection | None = None
    encoder_noise: Annotated[float, kinds.moved(sign="not below zero")] = 0.0
    seed: Annotated[int, whole(2**32 - 1, "seed = 1")] = 1

    def __post_init__(self) -> None:
        take_forces(self, *_TORQUES)


@dataclass(frozen=True, kw_only=True)
class TrackingSection:
    """A command that goes on: a rate, a sine, both together, a scan or a file."""

    __pydantic_config__: ClassVar = _CLOSED
    name: Annotated[str, TRACKING_NAME]
    rate: Annotated[float | Literal["sidereal"] | None, kinds.RATE] = None
    sine: SineSection | None = None
    onto: OntoSection | None = None
    scan: ScanSection | None = None
    file: FileSection | None = None
    duration: Annotated[float | None, kinds.SECONDS] = None
    after: Annotated[float, kinds.TIME] = 0.0
    disturbances: ActingSection | None = None

    def __post_init__(self) -> None:
        endless = self.rate is not None or self.sine is not None
        if endless + (self.scan is not None) + (self.file is not None) != 1:
            raise ValueError(
                'needs one command: write rate = "15 arcsec/s" or "sidereal", a sine, both '
                "together, or a scan or a file alone"
            )
        if self.onto is not None and (self.rate is None or self.sine is not None):
            raise ValueError(
                'goes onto a target without its rate; write rate = "15 arcsec/s" or "sidereal", '
                "and no sine"
            )
        _check_duration(self.duration, self.after, endless=endless)


@dataclass(frozen=True, kw_only=True)
class DisturbanceSection:
    """What disturbs the loop."""

    __pydantic_config__: ClassVar = _CLOSED
    torque_step: TorqueStepSection | None = None
    force_step: TorqueStepSection | None = None
    torque_sine: TorqueSineSection | None = None
    force_sine: TorqueSineSection | None = None
    torque_file: TorqueFileSection | None = None
    force_file: TorqueFileSection | None = None
    wind: WindSection | None = None
    torque_spectrum: TorqueSpectrumSection | None = None
    force_spectrum: TorqueSpectrumSection | None = None
    encoder_spectrum: EncoderSpectrumSection | None = None
    encoder_noise: Annotated[float, kinds.moved(sign="not below zero")] = 0.0

    def __post_init__(self) -> None:
        take_forces(self, *_TORQUES)
