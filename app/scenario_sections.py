"""The tables of a scenario file of format 2, their values in SI units, checked."""

from __future__ import annotations

from dataclasses import dataclass
from math import isqrt
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from . import scenario_kinds as kinds
from .scenario_checks import GAIN, NAME, listed, whole
from .scenario_forces import take_forces
from .scenario_frf import OR_PATH, FrfSection
from .scenario_keys import OrWord, choice, number, numbers, roots, square

_CLOSED: ConfigDict = ConfigDict(extra="forbid")
_NONE: Any = "none"  # a word in place of the table that pydantic is told of
_Factor = Annotated[float, number("gear_ratio", positive=True)]
_Share = Annotated[float | None, number("motor_shape")]


@dataclass(frozen=True, kw_only=True)
class FrictionSection:
    """Dry friction on the motor."""

    __pydantic_config__: ClassVar = _CLOSED
    coulomb: Annotated[float, kinds.torque("not below zero")]
    static: Annotated[float | None, kinds.torque("not below zero")] = None

    def __post_init__(self) -> None:
        if self.static is not None and self.static < self.coulomb:
            raise ValueError(
                f"has a static friction of {self.static:g} below coulomb = {self.coulomb:g}; write "
                "a larger one, or leave it out where the two are equal"
            )


@dataclass(frozen=True, kw_only=True)
class ModeSection:
    """A flexible mode of the plant."""

    __pydantic_config__: ClassVar = _CLOSED
    name: Annotated[str | None, NAME] = None
    frequency: Annotated[float, kinds.HERTZ]
    damping: Annotated[float, kinds.DAMPING] = 0.0
    held: Annotated[bool, choice(True, False)] = False
    load_fraction: Annotated[float | None, kinds.SHARE] = None
    motor_shape: _Share = None
    load_shape: _Share = None


@dataclass(frozen=True, kw_only=True)
class ChainSection:
    """Masses in a row."""

    __pydantic_config__: ClassVar = _CLOSED
    masses: Annotated[tuple[float, ...], kinds.INERTIAS]
    springs: Annotated[tuple[float, ...], kinds.SPRINGS]
    dampers: Annotated[tuple[float, ...] | None, kinds.DAMPERS] = None


@dataclass(frozen=True, kw_only=True)
class TransferSection:
    """A linear system, of quantities in rad or m, N m or N and s.

    Coefficients of s, highest power first; zeros, poles and gain; or matrices of its states.
    """

    __pydantic_config__: ClassVar = _CLOSED
    numerator: Annotated[tuple[float, ...] | None, numbers("numerator")] = None
    denominator: Annotated[tuple[float, ...] | None, numbers("denominator")] = None
    zeros: Annotated[tuple[complex, ...] | None, roots("zeros")] = None
    poles: Annotated[tuple[complex, ...] | None, roots("poles")] = None
    gain: Annotated[float | None, number("gain")] = None
    a: Annotated[tuple[float, ...] | None, square("a")] = None
    b: Annotated[tuple[float, ...] | None, numbers("b")] = None
    c: Annotated[tuple[float, ...] | None, numbers("c")] = None
    d: Annotated[float | None, number("d")] = None

    def __post_init__(self) -> None:
        keys = ("numerator", "denominator", "zeros", "poles", "gain", *"abcd")
        given = tuple(key for key in keys if getattr(self, key) is not None)
        known = [("numerator", "denominator"), ("zeros", "poles", "gain"), ("poles", "gain")]
        if given not in (*known, ("a", "b", "c"), ("a", "b", "c", "d")):
            raise ValueError(
                f"has {', '.join(given) or 'no coefficients'}; write numerator and denominator, or "
                "zeros, poles and gain, or the matrices a, b, c (and d)"
            )
        sizes = {len(part) for part in (self.b, self.c) if part is not None}
        if self.a is not None and sizes != {isqrt(len(self.a))}:
            raise ValueError(
                f"has b and c of {len(self.b or ())} and {len(self.c or ())} numbers; write as "
                f"many as a has rows, {isqrt(len(self.a))}"
            )

    def system(self) -> Any:
        """Return it as a python-control system."""
        import control

        if self.numerator is not None:
            return control.tf(self.numerator, self.denominator)
        if self.poles is not None:
            return control.zpk(self.zeros or (), self.poles, self.gain)
        n = len(self.b or ())
        rows = [self.a[i * n : (i + 1) * n] for i in range(n)] if self.a else []
        return control.ss(rows, [[each] for each in self.b or ()], [self.c], [[self.d or 0.0]])


@dataclass(frozen=True, kw_only=True)
class RippleSection:
    """Torque over the motor's position that repeats (cogging): a sine, or a table of points."""

    __pydantic_config__: ClassVar = _CLOSED
    period: Annotated[float, kinds.moved(sign="positive")]
    amplitude: Annotated[float | None, kinds.torque("positive")] = None
    positions: Annotated[tuple[float, ...] | None, kinds.POSITIONS] = None
    torques: Annotated[tuple[float, ...] | None, kinds.TORQUES] = None
    forces: Annotated[tuple[float, ...] | None, kinds.TORQUES] = None

    def __post_init__(self) -> None:
        take_forces(self, "torques")
        table = (self.positions is not None) + (self.torques is not None)
        if table + 2 * (self.amplitude is not None) != 2:
            raise ValueError(
                'needs a shape: write either amplitude = "0.1 N m", a sine, or positions and '
                "torques, points of a period"
            )


@dataclass(frozen=True, kw_only=True)
class PlantSection:
    """What a drive moves, all but its inertia."""

    __pydantic_config__: ClassVar = _CLOSED
    viscous: Annotated[float, kinds.gain(1, "viscous friction")] = 0.0
    load_viscous: Annotated[float, kinds.gain(1, "viscous friction")] = 0.0
    spring: Annotated[float, kinds.gain(0, "stiffness")] = 0.0
    modes: Annotated[
        tuple[ModeSection, ...],
        listed("modes", write="[[plant.modes]] with frequency, damping, load_fraction"),
    ] = ()
    chain: ChainSection | None = None
    transfer: TransferSection | None = None
    frf: Annotated[FrfSection | None, OR_PATH] = None
    friction: FrictionSection | None = None
    ripple: RippleSection | None = None
    torque_limit: Annotated[float | None, kinds.torque("positive")] = None
    force_limit: Annotated[float | None, kinds.torque("positive")] = None
    current_limit: Annotated[float | None, kinds.CURRENT] = None
    torque_constant: Annotated[float | None, kinds.TORQUE_CONSTANT] = None
    force_constant: Annotated[float | None, kinds.TORQUE_CONSTANT] = None
    gear_ratio: _Factor = 1.0
    current_lag: Annotated[float, kinds.TIME] = 0.0
    encoder_step: Annotated[float, kinds.moved(sign="not below zero")] = 0.0
    encoder_counts: Annotated[int | None, whole(2**62, "encoder_counts = 1048576")] = None
    sensor: Annotated[Literal["motor", "load", "both"], choice("motor", "load", "both")] = "motor"
    constant_load: Annotated[float, kinds.torque()] = 0.0

    def __post_init__(self) -> None:
        take_forces(self, "torque_constant")
        limits = ("torque_limit", "force_limit", "current_limit")
        given = [name for name in limits if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"has {' and '.join(given)}, which limit the same; keep one")
        if self.encoder_counts is not None and self.encoder_step:
            raise ValueError("has encoder_step and encoder_counts, which say the same; keep one")
        if self.current_limit is not None and self.torque_constant is None:
            raise ValueError(
                "has a current_limit, and current makes no torque without a constant; write "
                "torque_constant as well, or torque_limit"
            )


@dataclass(frozen=True, kw_only=True)
class PidSection:
    """Gains of a PID controller."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["pid"] = "pid"
    kp: Annotated[float, GAIN]
    ki: Annotated[float, GAIN]
    kr: Annotated[float, GAIN]


@dataclass(frozen=True, kw_only=True)
class CascadeSection:
    """Gains of a P-PI cascade, as drives have it."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["p-pi"] = "p-pi"
    position_gain: Annotated[float, kinds.POSITION_GAIN]
    velocity_gain: Annotated[float, kinds.gain(1, "velocity gain", "positive")]
    reset_time: Annotated[float | None, kinds.SECONDS] = None
    velocity_filter: Annotated[float, kinds.TIME] = 0.0
    velocity_feedforward: Annotated[float, number("velocity_feedforward")] = 1.0


@dataclass(frozen=True, kw_only=True)
class NotchSection:
    """A notch filter."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["notch"]
    frequency: Annotated[float, kinds.HERTZ]
    pole_frequency: Annotated[float | None, kinds.HERTZ] = None
    zero_damping: Annotated[float, kinds.ZERO_DAMPING]
    pole_damping: Annotated[float, kinds.POLE_DAMPING]


@dataclass(frozen=True, kw_only=True)
class LeadLagSection:
    """A lead or lag element."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["lead-lag"]
    zero: Annotated[float, kinds.HERTZ]
    pole: Annotated[float, kinds.HERTZ]


@dataclass(frozen=True, kw_only=True)
class LowPassSection:
    """A low-pass filter."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["low-pass"]
    corner: Annotated[float, kinds.HERTZ]
    order: Annotated[int, choice(1, 2)] = 2
    damping: Annotated[float, kinds.POLE_DAMPING] = 0.7


@dataclass(frozen=True, kw_only=True)
class FilterTransfer(TransferSection):
    """Any linear filter."""

    kind: Literal["transfer"]


FilterKind = Annotated[
    NotchSection | LeadLagSection | LowPassSection | FilterTransfer, Field(discriminator="kind")
]


@dataclass(frozen=True, kw_only=True)
class BackCalculationSection:
    """The integral follows the torque limit."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["back-calculation"]
    tracking_time: Annotated[float, kinds.SECONDS]


@dataclass(frozen=True, kw_only=True)
class ClampSection:
    """The integral's torque is bounded."""

    __pydantic_config__: ClassVar = _CLOSED
    kind: Literal["clamp"]
    integral_limit: Annotated[float, kinds.torque("positive")]


AntiWindupKind = Annotated[
    BackCalculationSection | ClampSection,
    Field(discriminator="kind"),
    OrWord(("none", "conditional"), '{kind = "back-calculation", tracking_time = "0.1 s"}'),
]


@dataclass(frozen=True, kw_only=True)
class TuneSection:
    """Bounds on the peaks of |S| and |T| for gains = "tune"."""

    __pydantic_config__: ClassVar = _CLOSED
    max_sensitivity: Annotated[float, number("max_sensitivity", positive=True)] = 1.6
    max_complementary: Annotated[float, number("max_complementary", positive=True)] = 1.6


@dataclass(frozen=True, kw_only=True)
class ControllerSection:
    """How a controller runs, all but its gains and their specification."""

    __pydantic_config__: ClassVar = _CLOSED
    derivative_filter: Annotated[float, kinds.TIME] = 0.0
    filters: Annotated[
        tuple[FilterKind, ...],
        listed("filters", write='[[controller.filters]] with kind = "notch"'),
    ] = ()
    sample_time: Annotated[float | None, kinds.PERIOD] = None
    delay: Annotated[float, kinds.TIME] = 0.0
    anti_windup: AntiWindupKind = _NONE
    discretisation: Annotated[
        Literal["tustin", "matched", "hold"], choice("tustin", "matched", "hold")
    ] = "tustin"
    tune: TuneSection | None = None

    def __post_init__(self) -> None:
        if self.delay > 0.0 and self.sample_time is None:
            raise ValueError(
                f"has a delay of {self.delay:g} s without a sample time, and a continuous "
                'controller computes at once; write sample_time = "1 ms" as well'
            )
