"""The checks of a scenario file's values: what each key accepts, and its value in SI units."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, cast

from pydantic import PlainValidator, ValidationInfo, ValidatorFunctionWrapHandler

from ..analysis.specification import Bound
from ..shaping.closed_moves import MAX_MOVE_ORDER
from ..shaping.derivatives import DERIVATIVE_NAMES
from .scenario_messages import unknown_key, what_to_write
from .units import (
    Kind,
    Motion,
    UnitError,
    motion_kind,
    parse_any,
    parse_motion,
    parse_quantity,
    parse_unit,
    show,
)

HIGHEST_DERIVATIVE = MAX_MOVE_ORDER
HIGHEST_FILTER_ORDER = 50

LIMIT_KEYS = DERIVATIVE_NAMES[1:] + tuple(
    f"derivative_{k}" for k in range(len(DERIVATIVE_NAMES), HIGHEST_DERIVATIVE + 1)
)
_LIMIT_KEYS_SHOWN = (*DERIVATIVE_NAMES[1:], f"derivative_7 to derivative_{HIGHEST_DERIVATIVE}")


def _positive(name: str, example: str, *, below: float = math.inf) -> Kind:
    unit = example.split(maxsplit=1)[1]
    return Kind(name=name, unit=unit, example=example, above=0.0, below=below)


PHASE_MARGIN = _positive("an angle between 0 and 90 deg", "45 deg", below=90.0)
GAIN_MARGIN = _positive("a positive ratio in dB", "12 dB")
PERCENTAGE = _positive("a percentage between 0 and 100 %", "10 %", below=100.0)
DAMPING = Kind(
    name="a damping from 0 to below 100 %", unit="%", example="2 %", least=0.0, below=100.0
)
_INERTIA: dict[Motion, tuple[Kind, ...]] = {
    "angle": (
        _positive("a positive moment of inertia for angular moves", "1 kg m^2"),
        _positive("a positive torque per angular acceleration", "1 N m s^2/rad"),
    ),
    "length": (_positive("a positive mass for linear moves", "1 kg"),),
}
GAIN_UNITS: dict[Motion, dict[str, str]] = {
    "angle": {"kp": "N m/rad", "ki": "N m/(rad s)", "kr": "N m s/rad"},
    "length": {"kp": "N/m", "ki": "N/(m s)", "kr": "N s/m"},
}


@dataclass(frozen=True)
class Context:
    """What the check of one key must know of the rest of the file."""

    motions: tuple[Motion, ...]
    limit_sets: tuple[str, ...]
    moves: set[str] = field(default_factory=set)
    modes: set[str] = field(default_factory=set)

    def quantity(self, value: object, kinds: Callable[[Motion], Sequence[Kind]]) -> float:
        """Return a quantity of a kind that fits the file's motions."""
        return parse_any(value, [kind for motion in self.motions for kind in kinds(motion)])[0]

    def moved(self, value: object, derivative: int, *, positive: bool = False) -> float:
        """Return a position or one of its derivatives."""
        return self.quantity(value, lambda m: [motion_kind(m, derivative, positive=positive)])


def context_of(content: dict[str, Any]) -> Context:
    """Return the context of a file: what most quantities say they are, so that a slip shows."""
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
    sets = content.get("limits")
    return Context(
        motions=(votes.most_common(1)[0][0],) if votes else ("angle", "length"),
        limit_sets=tuple(sets) if isinstance(sets, dict) else (),
    )


def _context(info: ValidationInfo) -> Context:
    return cast(Context, info.context)


def quantity_of(kind: Kind) -> PlainValidator:
    """Return the check of a key that takes one kind of quantity."""
    return PlainValidator(lambda value: parse_quantity(value, kind))


def read_inertia(value: object, info: ValidationInfo) -> float:
    """Return an inertia, which is a mass for linear moves."""
    return _context(info).quantity(value, lambda motion: _INERTIA[motion])


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


def _new_name(value: object, of_what: str, taken: set[str]) -> str:
    name = read_name(value)
    if name in taken:
        raise ValueError(
            f"{show(name)} is the name of an earlier {of_what}; write one not yet used"
        )
    taken.add(name)
    return name


def read_filter_order(value: object) -> int:
    """Return the number of poles of the filter."""
    whole = value if isinstance(value, int) and not isinstance(value, bool) else 0
    if not 1 <= whole <= HIGHEST_FILTER_ORDER:
        raise ValueError(
            f"{show(value)} is not a whole number from 1 to {HIGHEST_FILTER_ORDER}; "
            "write one without quotation marks such as order = 6"
        )
    return whole


def read_gains(value: object, gains_of: ValidatorFunctionWrapHandler) -> Any:
    """Return the rule for the gains, or the gains of a table."""
    if value in ("design", "published"):
        return value
    if not isinstance(value, dict):
        table = what_to_write("controller", "gains")
        raise ValueError(
            f"{show(value)} is not known; write 'design', 'published' or a table {table}"
        )
    return gains_of(value)


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
    if len(value) != 2 or not sides[0] < 0.0 < sides[1]:
        raise ValueError(
            f"{show(value)} is not a pair around zero; write one quantity, "
            "or [lower, upper] with lower < 0 < upper"
        )
    return sides[0], sides[1]


def read_limit_set(value: object, info: ValidationInfo) -> str:
    """Return the name of a set of limits, which goes without saying where there is one."""
    sets = _context(info).limit_sets
    if value is None and len(sets) == 1:
        return sets[0]
    if not isinstance(value, str) or value not in sets:
        problem = "is missing" if value is None else f"{show(value)} is not a set of limits here"
        raise ValueError(f"{problem}; write one of {', '.join(map(show, sets)) or 'none'}")
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


def several_moves(value: object) -> object:
    """Refuse what is not a list of moves, or an empty one."""
    return _listed(value, "moves", least=1)


def several_modes(value: object) -> object:
    """Refuse what is not a list of modes."""
    return _listed(value, "modes", least=0)


def _listed(value: object, key: str, *, least: int) -> object:
    if not isinstance(value, list) or len(value) < least:
        raise ValueError(f"{show(value)} is not a list of {key}; write {what_to_write(key)}")
    return value


def read_position_unit(value: object, info: ValidationInfo) -> str:
    """Return the unit in which positions are reported."""
    return parse_unit(value, [motion_kind(motion, 0) for motion in _context(info).motions])
