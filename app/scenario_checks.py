"""The checks of a scenario file's values: what each key accepts, and its value in SI units."""

import math
from typing import Any, cast

from pydantic import BeforeValidator, ValidationInfo, ValidatorFunctionWrapHandler, WithJsonSchema

from ..analysis.specification import Bound
from ..shaping.derivatives import DERIVATIVE_NAMES
from ..shaping.pieces import MAX_MOVE_ORDER
from .scenario_context import INERTIA_KINDS, Context, positive_kind
from .scenario_keys import Key, Quantity, quantity_schema
from .scenario_kinds import density_kind
from .scenario_messages import unknown_key, what_to_write
from .units import Kind, Motion, motion_kind, parse_unit, show

HIGHEST_DERIVATIVE = MAX_MOVE_ORDER
HIGHEST_FILTER_ORDER = 50

LIMIT_KEYS = DERIVATIVE_NAMES[1:] + tuple(
    f"derivative_{k}" for k in range(len(DERIVATIVE_NAMES), HIGHEST_DERIVATIVE + 1)
)
_LIMIT_KEYS_SHOWN = (*DERIVATIVE_NAMES[1:], f"derivative_7 to derivative_{HIGHEST_DERIVATIVE}")


PHASE_MARGIN = positive_kind("an angle between 0 and 90 deg", "45 deg", below=90.0)
GAIN_MARGIN = positive_kind("a positive ratio in dB", "12 dB")
PERCENTAGE = positive_kind("a percentage between 0 and 100 %", "10 %", below=100.0)
DAMPING = Kind(
    name="a damping from 0 to below 100 %", unit="%", example="2 %", least=0.0, below=100.0
)
GAIN_UNITS: dict[Motion, dict[str, str]] = {
    "angle": {"kp": "N m/rad", "ki": "N m/(rad s)", "kr": "N m s/rad"},
    "length": {"kp": "N/m", "ki": "N/(m s)", "kr": "N s/m"},
}


def _context(info: ValidationInfo) -> Context:
    return cast(Context, info.context)


def quantity_of(kind: Kind) -> Quantity:
    """Return the check of a key that takes one kind of quantity."""
    return Quantity((kind,), (kind,))


def read_inertia(value: object, info: ValidationInfo) -> float:
    """Return an inertia, which is a mass for linear moves."""
    return _context(info).quantity(value, lambda motion: INERTIA_KINDS[motion])


def read_gain(value: object, info: ValidationInfo) -> float:
    """Return the gain that the key names."""
    name = str(info.field_name)

    def kinds(motion: Motion) -> list[Kind]:
        unit = GAIN_UNITS[motion][name]
        article = "a positive gain" if name == "kp" else "a gain not below zero"
        bound: dict[str, float] = {"above" if name == "kp" else "least": 0.0}
        return [Kind(name=article, unit=unit, example=f"2 {unit}", **bound)]

    return _context(info).quantity(value, kinds)


def read_name(value: object) -> str:
    """Return printable text without surrounding space."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise ValueError(
            f"{show(value)} is not a name; write printable text such as 'azimuth offset'"
        )
    return value.strip()


def read_move_name(value: object, info: ValidationInfo) -> str:
    """Return a move's name, which no earlier move has."""
    return _new_name(value, "move", _context(info).moves)


def read_mode_name(value: object, info: ValidationInfo) -> str:
    """Return a mode's name, which no earlier mode has."""
    return _new_name(value, "mode", _context(info).modes)


def read_tracking_name(value: object, info: ValidationInfo) -> str:
    """Return the name of a tracking, which neither a move nor an earlier one has."""
    context = _context(info)
    return _new_name(value, "tracking", context.tracking)


def _new_name(value: object, of_what: str, taken: set[str]) -> str:
    name = read_name(value)
    if name in taken:
        raise ValueError(
            f"{show(name)} is the name of an earlier {of_what}; write one not yet used"
        )
    taken.add(name)
    return name


def whole(most: int, example: str) -> Key:
    """Return a key that takes a whole number from 1 on."""

    def read(value: object) -> int:
        number = value if isinstance(value, int) and not isinstance(value, bool) else 0
        if not 1 <= number <= most:
            raise ValueError(
                f"{show(value)} is not a whole number from 1 to {most}; "
                f"write one without quotation marks such as {example}"
            )
        return number

    return Key(read, {"type": "integer", "minimum": 1, "maximum": most})


def read_mode_names(value: object) -> tuple[str, ...]:
    """Return names of modes."""
    if not isinstance(value, list) or not value:
        raise ValueError(f'{show(value)} is not a list of names; write one such as ["tower"]')
    return tuple(map(read_name, value))


def kind_of_gains(value: object) -> object:
    """Return a table of gains with its kind, that of a PID where it says none."""
    return {"kind": "pid", **value} if isinstance(value, dict) else value


def read_specification(
    value: object, specification_of: ValidatorFunctionWrapHandler, info: ValidationInfo
) -> Any:
    """Return the specification, which only gains by design need."""
    if value is not None:
        return specification_of(value)
    if info.data.get("gains") == "design":
        example = what_to_write("controller", "specification")
        raise ValueError(f"is missing, and gains = 'design' needs it; write {example}")
    return None


def named_bounds(value: object) -> object:
    """Pair each bound with its key, which its own check must know."""
    if value == {}:
        raise ValueError("is empty; write at least one limit such as acceleration = '0.2 deg/s^2'")
    return {k: (k, v) for k, v in value.items()} if isinstance(value, dict) else value


def read_bound(named: tuple[str, object], info: ValidationInfo) -> Bound:
    """Return the bound on the derivative that the key names."""
    key, value = named
    if key not in LIMIT_KEYS:
        raise ValueError(unknown_key(key, value, LIMIT_KEYS, shown=_LIMIT_KEYS_SHOWN))
    derivative = LIMIT_KEYS.index(key) + 1
    if not isinstance(value, list):
        return _context(info).moved(value, derivative, positive=True)
    sides = [_context(info).moved(side, derivative) for side in value[:2]]
    if len(value) != 2 or not sides[0] <= 0.0 <= sides[1] or sides[0] == sides[1]:
        raise ValueError(
            f"{show(value)} is not a pair around zero; write one quantity, "
            "or [lower, upper] with lower ≤ 0 ≤ upper"
        )
    return sides[0], sides[1]


def read_limit_set(value: object, info: ValidationInfo) -> str:
    """Return the name of a set of limits, which goes without saying where there is one."""
    sets = _context(info).limit_sets
    if value is None and len(sets) == 1:
        return sets[0]
    if not sets:
        raise ValueError(
            "has no limits to keep; write [limits.axis] with velocity, acceleration, … "
            "into the file"
        )
    if not isinstance(value, str) or value not in sets:
        problem = "is missing" if value is None else f"{show(value)} is not a set of limits here"
        raise ValueError(f"{problem}; write one of {', '.join(map(show, sets))}")
    return value


def read_distance(value: object, info: ValidationInfo) -> float:
    """Return a distance other than zero."""
    distance = _context(info).moved(value, 0)
    if distance == 0.0:
        raise ValueError(f"{show(value)} is no move; write a distance other than zero")
    return distance


def read_settle_to(value: object, info: ValidationInfo) -> float:
    """Return a tolerance smaller than the distance."""
    tolerance = _context(info).moved(value, 0, positive=True)
    if tolerance >= abs(info.data.get("distance", math.inf)):
        raise ValueError(f"{show(value)} is not smaller than the distance; write a tighter one")
    return tolerance


def listed(key: str, *, least: int = 0, write: str | None = None) -> BeforeValidator:
    """Return a check that refuses what is not a list of moves, or modes, or too short a one."""

    def check(value: object) -> object:
        if not isinstance(value, list) or len(value) < least:
            remedy = what_to_write(key) if write is None else write
            raise ValueError(f"{show(value)} is not a list of {key}; write {remedy}")
        return value

    return BeforeValidator(check)


def read_position_unit(value: object, info: ValidationInfo) -> str:
    """Return the unit in which positions are reported, or are given in a file."""
    if isinstance(value, str) and value.strip() in ("count", "counts"):
        _context(info).spelled_out("count", value)
        return "count"
    return parse_unit(value, [motion_kind(motion, 0) for motion in _context(info).motions])


def read_torque_unit(value: object, info: ValidationInfo) -> str:
    """Return the unit of torques in a file."""
    units = {"angle": ("a torque", "N m"), "length": ("a force", "N")}
    named = [units[motion] for motion in _context(info).motions]
    kinds = [Kind(name=name, unit=unit, example=f"5 {unit}") for name, unit in named]
    return parse_unit(value, kinds)


def read_torque_density_unit(value: object, info: ValidationInfo) -> str:
    """Return the unit of a torque's power spectral density in a file."""
    return parse_unit(value, [density_kind("torque", m) for m in _context(info).motions])


def read_position_density_unit(value: object, info: ValidationInfo) -> str:
    """Return the unit of a position's power spectral density in a file."""
    kinds = [density_kind("position", m) for m in _context(info).motions]
    if isinstance(value, str):
        parse_unit(_context(info).spelled_out(value, value)[1], kinds)
        return value
    return parse_unit(value, kinds)


def _text(description: str, example: str) -> dict[str, Any]:
    return {"type": "string", "description": description, "examples": [example]}


def _moved_schema(derivative: int = 0, *, positive: bool = False) -> dict[str, Any]:
    kinds = (motion_kind(motion, derivative, positive=positive) for motion in INERTIA_KINDS)
    return quantity_schema(*kinds)


_NAME = _text("a name", "azimuth offset")
INERTIA = Key(
    read_inertia, quantity_schema(*(k for kinds in INERTIA_KINDS.values() for k in kinds))
)
GAIN = Key(read_gain, _text("a gain of the PID controller", "2 N m/rad"))
NAME = Key(read_name, _NAME)
MOVE_NAME = Key(read_move_name, _NAME)
MODE_NAME = Key(read_mode_name, _NAME)
TRACKING_NAME = Key(read_tracking_name, _NAME)
MODE_NAMES = Key(read_mode_names, {"type": "array", "items": _NAME, "minItems": 1})
FILTER_ORDER = whole(HIGHEST_FILTER_ORDER, "order = 6")
_ONE_BOUND = _text("a bound on the derivative that the key names", "0.2 deg/s^2")
_BOUND = {
    "anyOf": [_ONE_BOUND, {"type": "array", "items": _ONE_BOUND, "minItems": 2, "maxItems": 2}]
}
LIMIT_SET = Key(read_limit_set, _text("the name of a set of limits", "axis"))
DISTANCE = Key(read_distance, _moved_schema())
SETTLE_TO = Key(read_settle_to, _moved_schema(positive=True))
POSITION_UNIT = Key(read_position_unit, _text("the unit in which positions are told", "arcsec"))
TORQUE_UNIT = Key(read_torque_unit, _text("the unit of torques in a file", "N m"))
_DENSITY = "the unit of densities in a file"
TORQUE_DENSITY_UNIT = Key(read_torque_density_unit, _text(_DENSITY, "N^2 m^2/Hz"))
POSITION_DENSITY_UNIT = Key(read_position_density_unit, _text(_DENSITY, "arcsec^2/Hz"))
BOUND = Key(read_bound, _BOUND)
LIMITS = WithJsonSchema(
    {
        "type": "object",
        "properties": dict.fromkeys(LIMIT_KEYS, _BOUND),
        "additionalProperties": False,
        "minProperties": 1,
    },
)
