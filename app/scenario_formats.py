"""The files themselves: what stands in a scenario of format 1, and in one of format 2."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WrapValidator

from ..analysis.specification import Bound, Requirement
from . import scenario_checks as checks
from .scenario_asked import (
    ActingSection,
    DisturbanceSection,
    FeedforwardSection,
    ShaperSection,
    TrackingSection,
)
from .scenario_keys import OrWord, choice
from .scenario_kinds import MASS, SECONDS
from .scenario_messages import what_to_write
from .scenario_requirements import REQUIREMENTS
from .scenario_sections import CascadeSection, ControllerSection, PidSection, PlantSection
from .units import FREQUENCY

GainRule = Literal["design", "published", "tune", "measured"]
_NOT_EMPTY = Field(json_schema_extra={"minItems": 1})  # which checks.listed holds
_DESIGN: Any = "design"  # a word in place of the table that pydantic is told of


@dataclass(frozen=True)
class Gains:
    """Gains of a PID controller kp e + ki ∫e dt + kr de/dt, in N m and rad or in N and m."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    kp: Annotated[float, checks.GAIN]
    ki: Annotated[float, checks.GAIN]
    kr: Annotated[float, checks.GAIN]


@dataclass(frozen=True)
class SpecificationSection:
    """What a loop must achieve: its crossover frequency and margins."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    crossover_hz: Annotated[
        float, Field(validation_alias="crossover"), checks.quantity_of(FREQUENCY)
    ]
    phase_margin_deg: Annotated[
        float, Field(validation_alias="phase_margin"), checks.quantity_of(checks.PHASE_MARGIN)
    ]
    lower_gain_margin_db: Annotated[
        float, Field(validation_alias="lower_gain_margin"), checks.quantity_of(checks.GAIN_MARGIN)
    ]


@dataclass(frozen=True)
class FilterSection:
    """The jerk filter behind the shaper: corner frequency and number of poles."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    corner_hz: Annotated[float, Field(validation_alias="corner"), checks.quantity_of(FREQUENCY)]
    order: Annotated[int, checks.FILTER_ORDER]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Plant(_Section):
    inertia: Annotated[float, checks.INERTIA]


_Specified = Annotated[SpecificationSection | None, WrapValidator(checks.read_specification)]


class _Controller(_Section):
    # Typed by its table alone: in a union, pydantic would put the branch into the key's path.
    gains: Annotated[
        Gains, OrWord(("design", "published"), what_to_write("controller", "gains"))
    ] = _DESIGN
    specification: _Specified = Field(default=None, validate_default=True)


class _Feedforward(_Section):
    inertia: Annotated[float | None, checks.INERTIA] = None
    error: Annotated[float, checks.quantity_of(checks.PERCENTAGE)] = 10.0


class MoveSection(_Section):
    """A move as a file of format 1 has it."""

    name: Annotated[str, checks.MOVE_NAME]
    distance: Annotated[float, checks.DISTANCE]
    limits: Annotated[str, checks.LIMIT_SET] = Field(default=cast(Any, None), validate_default=True)
    settle_to: Annotated[float, checks.SETTLE_TO]


class _Mode(_Section):
    name: Annotated[str, checks.MODE_NAME]
    frequency: Annotated[float, checks.quantity_of(FREQUENCY)]
    damping: Annotated[float, checks.quantity_of(checks.DAMPING)] = 0.0


LimitSet = Annotated[
    dict[str, Annotated[Bound, checks.BOUND]],
    BeforeValidator(checks.named_bounds),
    checks.LIMITS,
]


class File(_Section):
    """A scenario file of format 1."""

    title: Annotated[str | None, checks.NAME] = None
    position_unit: Annotated[str | None, checks.POSITION_UNIT] = None
    plant: _Plant
    controller: _Controller
    feedforward: _Feedforward = _Feedforward()
    filter: FilterSection | None = None
    limits: dict[str, LimitSet] = Field(min_length=1)
    modes: Annotated[tuple[_Mode, ...], checks.listed("modes")] = ()
    moves: Annotated[tuple[MoveSection, ...], _NOT_EMPTY, checks.listed("moves", least=1)]


@dataclass(frozen=True, kw_only=True)
class PlantOf2(PlantSection):
    """[plant] of format 2."""

    inertia: Annotated[float | None, checks.INERTIA] = None
    mass: Annotated[float | None, MASS] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        given = self._bodies
        if len(given) != 1:
            raise ValueError(
                f"has {' and '.join(given) or 'nothing to move'}; write one of "
                'inertia = "1 kg m^2", mass = "1 kg", [plant.chain], [plant.transfer], '
                'frf = "axis.csv"'
            )
        if self.frf is not None:
            _check_alone(self)
        if given[0] in ("chain", "transfer") and self.modes:
            raise ValueError(f"has modes beside a {given[0]}, which has its own; keep one of them")

    @property
    def body(self) -> str:
        """The key that says what moves."""
        return self._bodies[0]

    @property
    def _bodies(self) -> list[str]:
        keys = ("inertia", "mass", "chain", "transfer", "frf")
        return [name for name in keys if getattr(self, name) is not None]


def _check_alone(plant: PlantOf2) -> None:
    """Refuse what else is said of a plant that was measured."""
    beside = [
        field.name
        for field in fields(plant)
        if field.name != "frf" and getattr(plant, field.name) != field.default
    ]
    if beside:
        raise ValueError(
            f"has {', '.join(beside)} beside frf, which has everything of the plant in it; keep "
            "one of them"
        )


@dataclass(frozen=True, kw_only=True)
class ControllerOf2(ControllerSection):
    """[controller] of format 2."""

    gains: Annotated[
        PidSection | CascadeSection,
        Field(discriminator="kind"),
        BeforeValidator(checks.kind_of_gains),
        OrWord(("design", "published", "tune", "measured"), what_to_write("controller", "gains")),
    ] = _DESIGN
    specification: Annotated[_Specified, Field(validate_default=True)] = None


@dataclass(frozen=True, kw_only=True)
class FeedforwardOf2(FeedforwardSection):
    """[feedforward] of format 2."""

    inertia: Annotated[float | None, checks.INERTIA] = None
    error: Annotated[float, checks.quantity_of(checks.PERCENTAGE)] = 10.0

    def __post_init__(self) -> None:
        super().__post_init__()
        beside = "acceleration" if self.acceleration is not None else ""
        beside = "inverse" if self.inverse else beside
        if self.inertia is not None and beside:
            raise ValueError(f"has an inertia beside {beside}, which says the same; keep one")


class ModeOf2(_Mode):
    """A mode that the plant does not feel, and what shapers take it for."""

    believed_frequency: Annotated[float | None, checks.quantity_of(FREQUENCY)] = None
    believed_damping: Annotated[float | None, checks.quantity_of(checks.DAMPING)] = None


class _MoveOf2(MoveSection):
    shaper: Annotated[ShaperSection | None, OrWord(("none",), what_to_write("shaper"))] = None
    duration: Annotated[float | None, SECONDS] = None
    round_to: Annotated[float | None, SECONDS] = None
    minimum_jerk: Annotated[bool, choice(True, False)] = False
    disturbances: ActingSection | None = None


class FileOf2(_Section):
    """A scenario file of format 2."""

    format: Literal[2]
    title: Annotated[str | None, checks.NAME] = None
    position_unit: Annotated[str | None, checks.POSITION_UNIT] = None
    plant: PlantOf2
    believed: PlantOf2 | None = None
    controller: ControllerOf2
    feedforward: FeedforwardOf2 = FeedforwardOf2()
    filter: FilterSection | None = None
    shaper: ShaperSection | None = None
    limits: dict[str, LimitSet] = Field(default={}, min_length=1)
    modes: Annotated[tuple[ModeOf2, ...], checks.listed("modes")] = ()
    moves: Annotated[tuple[_MoveOf2, ...], _NOT_EMPTY, checks.listed("moves", least=1)] = ()
    tracking: Annotated[tuple[TrackingSection, ...], checks.listed("tracking")] = ()
    disturbances: DisturbanceSection = DisturbanceSection()
    requirements: Annotated[tuple[Requirement, ...], REQUIREMENTS] = ()


FORMATS: Mapping[int, type[_Section]] = {1: File, 2: FileOf2}
