"""Scenario files: a plant, its loop and the moves asked of it, as TOML with units in strings."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    WrapValidator,
)

from ..analysis.specification import Bound, Mode, Move, Specification
from . import scenario_checks as checks
from .overrides import Place, override
from .scenario_messages import problem_line, what_to_write
from .text_files import read_toml
from .units import FREQUENCY, Motion, factor, unit_of

GainRule = Literal["design", "published"]


class ScenarioError(ValueError):
    """A scenario file cannot be used; its message has a line for each problem."""


@dataclass(frozen=True)
class Gains:
    """Gains of a PID controller kp e + ki ∫e dt + kr de/dt, in N m and rad or in N and m."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    kp: Annotated[float, PlainValidator(checks.read_gain)]
    ki: Annotated[float, PlainValidator(checks.read_gain)]
    kr: Annotated[float, PlainValidator(checks.read_gain)]


@dataclass(frozen=True)
class _Specification:
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
    order: Annotated[int, PlainValidator(checks.read_filter_order)]


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A scenario file's content in SI units.

    Attributes
    ----------
    path : Path
        The file.
    title : str
        Its title, or the file's name without its suffix.
    motion : {"angle", "length"}
        Whether positions are in rad or in m.
    position_unit : str
        The unit in which positions are reported; `position_scale` is its SI value.
    inertia : float
        The plant's, in kg m² or kg.
    gains : {"design", "published"} or Gains
        The controller's gains, or how they follow from the specification.
    specification : Specification or None
        Always given where gains is "design".
    feedforward_inertia : float
        Ĵ of the feedforward Ĵs², in kg m² or kg.
    inertia_error : float
        The fraction by which Ĵ is varied.
    filter : FilterSection or None
        The filter behind the shaper.
    moves : tuple of Move
        At least one.
    modes : tuple of Mode
        What the moves must not leave ringing.
    overrides : tuple of str
        What was given in place of the file's own, as ``key = value``.
    """

    path: Path
    title: str
    motion: Motion
    position_unit: str
    inertia: float
    gains: GainRule | Gains
    specification: Specification | None
    feedforward_inertia: float
    inertia_error: float
    filter: FilterSection | None
    moves: tuple[Move, ...]
    modes: tuple[Mode, ...] = ()
    overrides: tuple[str, ...] = ()

    @property
    def position_scale(self) -> float:
        """SI value, in rad or m, of one `position_unit`."""
        return factor(self.position_unit)


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Plant(_Section):
    inertia: Annotated[float, PlainValidator(checks.read_inertia)]


class _Controller(_Section):
    # Typed by its table alone: in a union, pydantic would put the branch into the key's path.
    gains: Annotated[Gains, WrapValidator(checks.read_gains)] = Field(default=cast(Any, "design"))
    specification: Annotated[_Specification | None, WrapValidator(checks.read_specification)] = (
        Field(default=None, validate_default=True)
    )


class _Feedforward(_Section):
    inertia: Annotated[float | None, PlainValidator(checks.read_inertia)] = None
    error: Annotated[float, checks.quantity_of(checks.PERCENTAGE)] = 10.0


class _Move(_Section):
    name: Annotated[str, PlainValidator(checks.read_move_name)]
    distance: Annotated[float, PlainValidator(checks.read_distance)]
    limits: Annotated[str, PlainValidator(checks.read_limit_set)] = Field(
        default=None, validate_default=True
    )
    settle_to: Annotated[float, PlainValidator(checks.read_settle_to)]


class _Mode(_Section):
    name: Annotated[str, PlainValidator(checks.read_mode_name)]
    frequency: Annotated[float, checks.quantity_of(FREQUENCY)]
    damping: Annotated[float, checks.quantity_of(checks.DAMPING)] = 0.0


_LimitSet = Annotated[
    dict[str, Annotated[Bound, PlainValidator(checks.read_bound)]],
    BeforeValidator(checks.named_bounds),
]


class _File(_Section):
    title: Annotated[str | None, PlainValidator(checks.read_name)] = None
    position_unit: Annotated[str | None, PlainValidator(checks.read_position_unit)] = None
    plant: _Plant
    controller: _Controller
    feedforward: _Feedforward = _Feedforward()
    filter: FilterSection | None = None
    limits: dict[str, _LimitSet] = Field(min_length=1)
    modes: Annotated[tuple[_Mode, ...], BeforeValidator(checks.several_modes)] = ()
    moves: Annotated[tuple[_Move, ...], BeforeValidator(checks.several_moves)]


def load_scenario(
    path: str | PathLike[str], *, overrides: Mapping[str, Any] | None = None
) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : path-like
        A TOML file, UTF-8, laid out as the files in ``examples/`` explain.
    overrides : mapping of str to object, optional
        Values in place of the file's, by their keys, as TOML would have them:
        ``{"limits.axis.jerk": "3 deg/s^3", 'moves."60 arcsec step".settle_to': "20 mas"}``.

    Returns
    -------
    Scenario
        All of it, checked, in SI units.

    Raises
    ------
    ScenarioError
        If the file cannot be read, or for what it or an override says: a line for every
        problem, with the file, the key, the value, and what to write.
    """
    path = Path(path)
    content = _read(path)
    try:
        placed = override(content, overrides or {})
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}") from None
    context = checks.context_of(content)
    try:
        checked = _File.model_validate(content, context=context)
    except ValidationError as error:
        problems = error.errors(include_url=False)
    else:
        first = content["moves"][0]["distance"]
        texts = tuple(placed.values())
        return _scenario(path, checked, context.motions[0], unit_of(first), texts)
    lines = (f"{path}: {_whose(p, placed)}{problem_line(p)}" for p in problems)
    raise ScenarioError("\n".join(lines))


def as_scenario(
    scenario: Scenario | str | PathLike[str], overrides: Mapping[str, Any] | None
) -> Scenario:
    """Return a scenario, read from its file where a path is given; only there can be overrides."""
    if not isinstance(scenario, Scenario):
        return load_scenario(scenario, overrides=overrides)
    if overrides:
        raise ScenarioError(
            f"{scenario.path}: overrides are for a scenario's file, not for one that is read; "
            "give load_scenario(path, overrides=…) or dataclasses.replace"
        )
    return scenario


def _whose(problem: Any, placed: Mapping[Place, str]) -> str:
    """Return the word that tells an override from what the file says."""
    where = problem["loc"]
    given = any(place[: len(where)] == where[: len(place)] for place in placed)
    return "override " if given else ""


def _read(path: Path) -> dict[str, Any]:
    try:
        content = read_toml(path, "a scenario file (TOML)")
    except ValueError as error:
        raise ScenarioError(str(error)) from None
    if not content:
        sections = ", ".join(
            what_to_write(key) for key in ("plant", "controller", "limits", "moves")
        )
        raise ScenarioError(f"{path}: holds no scenario; write {sections}")
    return content


def _scenario(
    path: Path, checked: _File, motion: Motion, first_unit: str, overrides: tuple[str, ...]
) -> Scenario:
    feedforward, asked = checked.feedforward, checked.controller.specification
    return Scenario(
        path=path,
        title=checked.title or path.stem,
        motion=motion,
        position_unit=checked.position_unit or first_unit,
        inertia=checked.plant.inertia,
        gains=checked.controller.gains,
        specification=None if asked is None else Specification(**vars(asked)),
        feedforward_inertia=feedforward.inertia or checked.plant.inertia,
        inertia_error=feedforward.error / 100.0,
        filter=checked.filter,
        moves=tuple(_move(move, checked.limits[move.limits]) for move in checked.moves),
        modes=tuple(Mode(m.name, m.frequency, m.damping / 100.0) for m in checked.modes),
        overrides=overrides,
    )


def _move(move: _Move, limits: dict[str, Bound]) -> Move:
    order = 1 + max(checks.LIMIT_KEYS.index(key) for key in limits)
    return Move(
        name=move.name,
        distance=move.distance,
        bounds=tuple(limits.get(key, math.inf) for key in checks.LIMIT_KEYS[:order]),
        limits_name=move.limits,
        settle_to=move.settle_to,
    )
