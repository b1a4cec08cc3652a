"""Scenario files: a plant, its loop and the moves asked of it, as TOML with units in strings."""

import difflib
import json
import math
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
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
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from ..shaping.derivatives import DERIVATIVE_NAMES
from ..shaping.limits import Bound
from .units import (
    FREQUENCY,
    Kind,
    Motion,
    UnitError,
    factor,
    motion_kind,
    parse_any,
    parse_motion,
    parse_quantity,
    parse_unit,
    show,
    unit_of,
)

GainRule = Literal["design", "published"]

HIGHEST_DERIVATIVE = 20
HIGHEST_FILTER_ORDER = 50

_EXAMPLE = tomllib.loads("""
title = "Telescope axis"
position_unit = "arcsec"
plant.inertia = "1 kg m^2"
feedforward = {inertia = "1 kg m^2", error = "10 %"}
filter = {corner = "2 Hz", order = 6}
limits.axis.acceleration = "0.2 deg/s^2"
[controller]
specification = {crossover = "1 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB"}
gains = {kp = "3 N m/rad", ki = "2 N m/(rad s)", kr = "5 N m s/rad"}
[[moves]]
name = "60 arcsec step"
distance = "60 arcsec"
limits = "axis"
settle_to = "50 mas"
""")
"""Every key once: what is known, and what to write where something is missing."""

_LIMIT_KEYS = DERIVATIVE_NAMES[1:] + tuple(
    f"derivative_{k}" for k in range(len(DERIVATIVE_NAMES), HIGHEST_DERIVATIVE + 1)
)
_LIMIT_KEYS_SHOWN = (*DERIVATIVE_NAMES[1:], f"derivative_7 to derivative_{HIGHEST_DERIVATIVE}")


def _positive(name: str, example: str, *, below: float = math.inf) -> Kind:
    unit = example.split(maxsplit=1)[1]
    return Kind(name=name, unit=unit, example=example, above=0.0, below=below)


_PHASE_MARGIN = _positive("an angle between 0 and 90 deg", "45 deg", below=90.0)
_GAIN_MARGIN = _positive("a positive ratio in dB", "12 dB")
_PERCENTAGE = _positive("a percentage between 0 and 100 %", "10 %", below=100.0)
_INERTIA: dict[Motion, tuple[Kind, ...]] = {
    "angle": (
        _positive("a positive moment of inertia for angular moves", "1 kg m^2"),
        _positive("a positive torque per angular acceleration", "1 N m s^2/rad"),
    ),
    "length": (_positive("a positive mass for linear moves", "1 kg"),),
}
_GAIN_UNITS: dict[Motion, dict[str, str]] = {
    "angle": {"kp": "N m/rad", "ki": "N m/(rad s)", "kr": "N m s/rad"},
    "length": {"kp": "N/m", "ki": "N/(m s)", "kr": "N s/m"},
}


class ScenarioError(ValueError):
    """A scenario file cannot be used; its message has a line for each problem."""


@dataclass(frozen=True)
class _Context:
    """What the check of one key must know of the rest of the file."""

    motions: tuple[Motion, ...]
    limit_sets: tuple[str, ...]
    names: set[str] = field(default_factory=set)

    def quantity(self, value: object, kinds: Callable[[Motion], Sequence[Kind]]) -> float:
        return parse_any(value, [kind for motion in self.motions for kind in kinds(motion)])[0]

    def moved(self, value: object, derivative: int, *, positive: bool = False) -> float:
        return self.quantity(value, lambda m: [motion_kind(m, derivative, positive=positive)])


def _context(info: ValidationInfo) -> _Context:
    return cast(_Context, info.context)


def _quantity(kind: Kind) -> PlainValidator:
    return PlainValidator(lambda value: parse_quantity(value, kind))


def _inertia(value: object, info: ValidationInfo) -> float:
    return _context(info).quantity(value, lambda motion: _INERTIA[motion])


def _gain(value: object, info: ValidationInfo) -> float:
    name = str(info.field_name)

    def kinds(motion: Motion) -> list[Kind]:
        unit = _GAIN_UNITS[motion][name]
        article = "a positive gain" if name == "kp" else "a gain not below zero"
        bound: dict[str, float] = {"above" if name == "kp" else "least": 0.0}
        return [Kind(name=article, unit=unit, example=f"2 {unit}", **bound)]

    return _context(info).quantity(value, kinds)


def _text(value: object) -> str:
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise ValueError(
            f"{show(value)} is not a name; write printable text such as 'azimuth offset'"
        )
    return value.strip()


def _unique_name(value: object, info: ValidationInfo) -> str:
    name = _text(value)
    if name in _context(info).names:
        raise ValueError(f"{show(name)} is the name of an earlier move; write one not yet used")
    _context(info).names.add(name)
    return name


def _filter_order(value: object) -> int:
    whole = value if isinstance(value, int) and not isinstance(value, bool) else 0
    if not 1 <= whole <= HIGHEST_FILTER_ORDER:
        raise ValueError(
            f"{show(value)} is not a whole number from 1 to {HIGHEST_FILTER_ORDER}; "
            "write one without quotation marks such as order = 6"
        )
    return whole


def _gains(value: object, gains_of: ValidatorFunctionWrapHandler) -> Any:
    if value in ("design", "published"):
        return value
    if not isinstance(value, dict):
        table = _example("controller", "gains")
        raise ValueError(
            f"{show(value)} is not known; write 'design', 'published' or a table {table}"
        )
    return gains_of(value)


def _specification(
    value: object, specification_of: ValidatorFunctionWrapHandler, info: ValidationInfo
) -> Any:
    if value is not None:
        return specification_of(value)
    if info.data.get("gains") == "design":
        example = _example("controller", "specification")
        raise ValueError(f"is missing, and gains = 'design' needs it; write {example}")
    return None


def _named(value: object) -> object:
    """Pair each bound with its key, which its own check must know."""
    if value == {}:
        raise ValueError("is empty; write at least one limit such as acceleration = '0.2 deg/s^2'")
    return {k: (k, v) for k, v in value.items()} if isinstance(value, dict) else value


def _bound(named: tuple[str, object], info: ValidationInfo) -> Bound:
    key, value = named
    if key not in _LIMIT_KEYS:
        raise ValueError(_unknown(key, value, _LIMIT_KEYS, shown=_LIMIT_KEYS_SHOWN))
    derivative = _LIMIT_KEYS.index(key) + 1
    if not isinstance(value, list):
        return _context(info).moved(value, derivative, positive=True)
    sides = [_context(info).moved(side, derivative) for side in value[:2]]
    if len(value) != 2 or not sides[0] < 0.0 < sides[1]:
        raise ValueError(
            f"{show(value)} is not a pair around zero; write one quantity, "
            "or [lower, upper] with lower < 0 < upper"
        )
    return sides[0], sides[1]


def _limit_set(value: object, info: ValidationInfo) -> str:
    sets = _context(info).limit_sets
    if value is None and len(sets) == 1:
        return sets[0]
    if not isinstance(value, str) or value not in sets:
        problem = "is missing" if value is None else f"{show(value)} is not a set of limits here"
        raise ValueError(f"{problem}; write one of {', '.join(map(show, sets)) or 'none'}")
    return value


def _distance(value: object, info: ValidationInfo) -> float:
    distance = _context(info).moved(value, 0)
    if distance == 0.0:
        raise ValueError(f"{show(value)} is no move; write a distance other than zero")
    return distance


def _settle_to(value: object, info: ValidationInfo) -> float:
    tolerance = _context(info).moved(value, 0, positive=True)
    if tolerance >= abs(info.data.get("distance", math.inf)):
        raise ValueError(f"{show(value)} is not smaller than the distance; write a tighter one")
    return tolerance


def _several_moves(value: object) -> object:
    if not isinstance(value, list) or not value:
        raise ValueError(f"{show(value)} is not a list of moves; write {_example('moves')}")
    return value


def _position_unit(value: object, info: ValidationInfo) -> str:
    return parse_unit(value, [motion_kind(motion, 0) for motion in _context(info).motions])


@dataclass(frozen=True)
class Gains:
    """Gains of a PID controller kp e + ki ∫e dt + kr de/dt, in N m and rad or in N and m."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    kp: Annotated[float, PlainValidator(_gain)]
    ki: Annotated[float, PlainValidator(_gain)]
    kr: Annotated[float, PlainValidator(_gain)]


@dataclass(frozen=True)
class Specification:
    """What a loop must achieve: its crossover frequency and margins."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    crossover_hz: Annotated[float, Field(validation_alias="crossover"), _quantity(FREQUENCY)]
    phase_margin_deg: Annotated[
        float, Field(validation_alias="phase_margin"), _quantity(_PHASE_MARGIN)
    ]
    lower_gain_margin_db: Annotated[
        float, Field(validation_alias="lower_gain_margin"), _quantity(_GAIN_MARGIN)
    ]


@dataclass(frozen=True)
class FilterSection:
    """The jerk filter behind the shaper: corner frequency and number of poles."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid")
    corner_hz: Annotated[float, Field(validation_alias="corner"), _quantity(FREQUENCY)]
    order: Annotated[int, PlainValidator(_filter_order)]


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

    @property
    def position_scale(self) -> float:
        """SI value, in rad or m, of one `position_unit`."""
        return factor(self.position_unit)


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Plant(_Section):
    inertia: Annotated[float, PlainValidator(_inertia)]


class _Controller(_Section):
    # Typed by its table alone: in a union, pydantic would put the branch into the key's path.
    gains: Annotated[Gains, WrapValidator(_gains)] = Field(default=cast(Any, "design"))
    specification: Annotated[Specification | None, WrapValidator(_specification)] = Field(
        default=None, validate_default=True
    )


class _Feedforward(_Section):
    inertia: Annotated[float | None, PlainValidator(_inertia)] = None
    error: Annotated[float, _quantity(_PERCENTAGE)] = 10.0


class _Move(_Section):
    name: Annotated[str, PlainValidator(_unique_name)]
    distance: Annotated[float, PlainValidator(_distance)]
    limits: Annotated[str, PlainValidator(_limit_set)] = Field(default=None, validate_default=True)
    settle_to: Annotated[float, PlainValidator(_settle_to)]


_LimitSet = Annotated[dict[str, Annotated[Bound, PlainValidator(_bound)]], BeforeValidator(_named)]


class _File(_Section):
    title: Annotated[str | None, PlainValidator(_text)] = None
    position_unit: Annotated[str | None, PlainValidator(_position_unit)] = None
    plant: _Plant
    controller: _Controller
    feedforward: _Feedforward = _Feedforward()
    filter: FilterSection | None = None
    limits: dict[str, _LimitSet] = Field(min_length=1)
    moves: Annotated[tuple[_Move, ...], BeforeValidator(_several_moves)]


def load_scenario(path: str | PathLike[str]) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : path-like
        A TOML file, UTF-8, laid out as the files in ``examples/`` explain.

    Returns
    -------
    Scenario
        All of it, checked, in SI units.

    Raises
    ------
    ScenarioError
        If the file cannot be read, or for what it says: a line for every problem, with the
        file, the key, the value, and what to write.
    """
    path = Path(path)
    content = _read(path)
    motion = _motion(content)
    sets = content.get("limits")
    context = _Context(
        motions=("angle", "length") if motion is None else (motion,),
        limit_sets=tuple(sets) if isinstance(sets, dict) else (),
    )
    try:
        checked = _File.model_validate(content, context=context)
    except ValidationError as error:
        problems = error.errors(include_url=False)
    else:
        first = content["moves"][0]["distance"]
        return _scenario(path, checked, motion or "angle", unit_of(first))
    raise ScenarioError("\n".join(f"{path}: {_problem(p)}" for p in problems))


def _read(path: Path) -> dict[str, Any]:
    try:
        content = tomllib.loads(_text_of(path))
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}; correct that place") from None
    except (ValueError, RecursionError) as error:
        if isinstance(error, ScenarioError):
            raise
        raise ScenarioError(
            f"{path}: not readable TOML: a number of thousands of digits or brackets nested "
            "too deeply; write values as in the example scenarios"
        ) from None
    if not content:
        sections = ", ".join(_example(key) for key in ("plant", "controller", "limits", "moves"))
        raise ScenarioError(f"{path}: holds no scenario; write {sections}")
    return content


def _text_of(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ScenarioError(
            f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8 text"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ScenarioError(f"{path}: {reason}; name a scenario file (TOML)") from None


def _motion(content: dict[str, Any]) -> Motion | None:
    """Return what most quantities say, so that a single slip is the one that is reported."""
    plant, moves = content.get("plant"), content.get("moves")
    votes: Counter[Motion] = Counter()
    if isinstance(plant, dict):
        for motion, kinds in _INERTIA.items():
            with suppress(UnitError):
                parse_any(plant.get("inertia"), kinds)
                votes[motion] += 1
    for move in moves if isinstance(moves, list) else ():
        for key in ("distance", "settle_to") if isinstance(move, dict) else ():
            with suppress(UnitError):
                votes[parse_motion(move.get(key), 0)[1]] += 1
    return votes.most_common(1)[0][0] if votes else None


def _scenario(path: Path, checked: _File, motion: Motion, first_unit: str) -> Scenario:
    feedforward = checked.feedforward
    return Scenario(
        path=path,
        title=checked.title or path.stem,
        motion=motion,
        position_unit=checked.position_unit or first_unit,
        inertia=checked.plant.inertia,
        gains=checked.controller.gains,
        specification=checked.controller.specification,
        feedforward_inertia=feedforward.inertia or checked.plant.inertia,
        inertia_error=feedforward.error / 100.0,
        filter=checked.filter,
        moves=tuple(_move(move, checked.limits[move.limits]) for move in checked.moves),
    )


def _move(move: _Move, limits: dict[str, Bound]) -> Move:
    order = 1 + max(_LIMIT_KEYS.index(key) for key in limits)
    return Move(
        name=move.name,
        distance=move.distance,
        bounds=tuple(limits.get(key, math.inf) for key in _LIMIT_KEYS[:order]),
        limits_name=move.limits,
        settle_to=move.settle_to,
    )


def _problem(error: Any) -> str:
    """Return one of pydantic's findings in our own words."""
    where, kind, value = error["loc"], error["type"], error["input"]
    section = tuple(part for part in where if isinstance(part, str))
    if kind == "value_error":
        problem = str(error["ctx"]["error"])
    elif kind == "missing":
        problem = f"is missing; write {_example(*section)}"
    elif kind in ("extra_forbidden", "unexpected_keyword_argument"):
        problem = _unknown(section[-1], value, tuple(_known(section[:-1])[1]))
    else:
        shown = "is empty" if value == {} else f"{show(value)} is not a table"
        problem = f"{shown}; write {_example(*section)}"
    return f"{_key(where)}: {problem}"


def _unknown(
    key: str, value: object, known: Sequence[str], *, shown: Sequence[str] | None = None
) -> str:
    near = difflib.get_close_matches(key, known, n=1)
    remedy = f"did you mean {near[0]}?" if near else "remove it"
    return f"unknown key (with {show(value)}); accepted: {', '.join(shown or known)}; {remedy}"


def _key(where: Sequence[str | int]) -> str:
    text = ""
    for part in where:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += "." + (part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else json.dumps(part))
    return text.removeprefix(".")


def _known(where: Sequence[str]) -> tuple[str, Any]:
    """Return an example's path and value; any name of a set of limits leads to the example's."""
    path, value = [], _EXAMPLE
    for key in where:
        path.append(key if key in value else next(iter(value)))
        value = value[path[-1]]
        value = value[0] if isinstance(value, list) else value
    return ".".join(path), value


def _example(*where: str) -> str:
    """Return what to write for a key."""
    path, value = _known(where)
    if not isinstance(value, dict):
        return f"{where[-1]} = {json.dumps(value)}"
    key, first = next(iter(value.items()))
    if isinstance(first, dict):
        return _example(*where, key)
    header = f"[[{path}]]" if path == "moves" else f"[{path}]"
    return f"{header} with {', '.join(value)}"
