"""What a scenario's numbers depend on: its conditions and its design, and what changed of them.

Conditions say what is asked and given: plant, specification, moves with their distances, limits
and tolerances, the filter that bounds their jerk, modes, tracking, disturbances, sample time and
delay, the error of Ĵ. Change one, and a number of the same name means another thing. The design
answers them: the gains, the controller's filters, the feedforward. It may change as long as the
numbers stand the comparison.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import Field, dataclass, fields, is_dataclass
from math import inf, isclose, isnan
from typing import Any, Literal, get_type_hints

from ...analysis.specification import Mode, Move
from ...shaping import InputShaper
from ...shaping.derivatives import derivative_name
from ..scenario import Scenario
from ..scenario_asked import FileSection, OntoSection, ScanSection
from ..scenario_checks import GAIN_UNITS
from ..scenario_frf import FrfSection
from ..scenario_keys import Quantity
from ..scenario_messages import key_path
from ..units import UnitError, conversion
from .numbers import Key

Conditions = Mapping[Key, str]
"""Values with their units, by the keys of the scenario file."""

NONE = "none"
_SAME = 1e-9  # relative: less than any number's tolerance, more than a unit's rounding
_ORIGIN = (
    *("path", "title", "motion", "position_unit", "overrides", "limits_name", "name"),
    *("limit_sets", "requirements", "body", "counted", "disturbed"),
)
_CONTROLLER = ("gains", "filters", "derivative_filter", "anti_windup", "discretisation")
_FEEDFORWARD = (
    *("inertia", "velocity", "acceleration", "jerk", "snap", "friction", "inverse", "lead"),
)
_DESIGN = (
    *(("controller", name) for name in _CONTROLLER),
    *(("feedforward", name) for name in _FEEDFORWARD),
    ("believed",),
)
_ENTRIES = ("moves", "modes", "tracking")
_KEYS: dict[str, Key] = {
    "gains": ("controller", "gains"),
    "specification": ("controller", "specification"),
    "feedforward_inertia": ("feedforward", "inertia"),
    "inertia_error": ("feedforward", "error"),
    "bounds": ("limits",),
}
_LISTS = ("filters", "modes")  # whose entries may have no name
_SUFFIXES = {"_hz": "Hz", "_deg": "deg", "_db": "dB", "_s": "s"}
_FRACTIONS = ("inertia_error", "damping")
_POSITIONS = ("distance", "settle_to")


@dataclass(frozen=True)
class Change:
    """A condition, or a part of the design, that is not as it was stored; shown as `Row` is.

    `was` and `now` have their units; "none" where there was, or is, nothing. The verdict of a
    condition is "changed", that of the design "redesigned".
    """

    key: Key
    was: str
    now: str

    @property
    def verdict(self) -> Literal["changed", "redesigned"]:
        """Whether the numbers mean something else now, or the loop is another one."""
        return "redesigned" if any(self.key[: len(d)] == d for d in _DESIGN) else "changed"

    @property
    def name(self) -> str:
        """The key as the scenario file writes it, an entry of a list by its name or number."""
        before = ("", *self.key)
        numbered = (
            part.isdecimal() and last in _LISTS
            for part, last in zip(self.key, before, strict=False)
        )
        pairs = zip(self.key, numbered, strict=True)
        return key_path([int(part) if number else part for part, number in pairs])

    @property
    def was_shown(self) -> str:
        """What was, as text."""
        return self.was

    @property
    def now_shown(self) -> str:
        """What is, as text."""
        return self.now

    @property
    def allowed(self) -> str:
        """What may be: nothing but what was, which stands beside it already."""
        return ""

    @property
    def message(self) -> str:
        """The change as a sentence."""
        why = ", and numbers depend on it" if self.verdict == "changed" else ""
        return f"{self.name} is {self.now}, was {self.was}: {self.verdict}{why}"


def scenario_conditions(scenario: Scenario) -> Conditions:
    """Return every value of a scenario but names and units, positions in the scenario's unit."""
    return {key: text for key, text in _leaves(scenario, (), scenario) if text != NONE}


def changes(stored: Conditions, now: Conditions) -> tuple[Change, ...]:
    """Return what differs; of moves and modes that are new or gone their numbers tell."""
    both = {(), *map(_entry, stored)} & {(), *map(_entry, now)}
    keys = [key for key in dict.fromkeys((*now, *stored)) if _entry(key) in both]
    pairs = [(key, stored.get(key, NONE), now.get(key, NONE)) for key in keys]
    return tuple(Change(*each) for each in pairs if not _is_same(*each[1:]))


def _entry(key: Key) -> Key:
    """Return the move or mode that a key belongs to; nothing for all other keys."""
    return key[:2] if key[0] in _ENTRIES else ()


def _is_same(was: str, now: str) -> bool:
    """Whether two texts say the same, in whatever units."""
    (numbers, unit), (others, to) = _quantity(was), _quantity(now)
    if was == now or len(numbers) != len(others) or not numbers:
        return was == now
    try:
        ratio = 1.0 if unit == to else conversion(unit, to)
    except UnitError:
        return False
    pairs = zip(numbers, others, strict=True)
    return all(isclose(ratio * a, b, rel_tol=_SAME) for a, b in pairs)


def _quantity(text: str) -> tuple[list[float], str]:
    """Return the numbers of a text, a pair as "1 to 2 mm" among them, and its unit."""
    words = text.split()
    numbers = []
    while words:
        try:
            numbers.append(float(words[0]))
        except ValueError:
            break
        words = words[2 if words[1:2] == ["to"] else 1 :]
    return numbers, " ".join(words)


def _leaves(part: Any, where: Key, scenario: Scenario) -> Iterator[tuple[Key, str]]:
    """Yield key and text of each value in a dataclass, and in those within it."""
    for field in fields(part):
        value = getattr(part, field.name)
        if field.name in _ORIGIN or _is_left_out(part, field, value):
            continue
        key = (*where, *_key_of(field.name))
        if isinstance(part, Move) and field.name == "disturbances":
            continue
        if part is scenario and field.name == "inertia":
            key = ("plant", scenario.body)
            if scenario.body in ("inertia", "mass"):
                yield key, _text(part, field.name, value, scenario)
        elif field.name == "bounds":
            yield from _limits(value, key, scenario)
        elif isinstance(part, FileSection | OntoSection | ScanSection) and field.name == "limits":
            yield from _limits(scenario.limit_sets[value], key, scenario)
        elif is_dataclass(value) and not isinstance(value, type):
            yield from _leaves(value, key, scenario)
        elif isinstance(value, tuple) and value and all(map(_is_table, value)):
            for number, entry in enumerate(value):
                name = getattr(entry, "name", None) or str(number)
                yield from _leaves(entry, (*key, name), scenario)
        else:
            yield key, _text(part, field.name, value, scenario)
    if isinstance(part, Move) and part.name in scenario.disturbed:
        yield from _leaves(scenario.disturbed[part.name], (*where, "disturbances"), scenario)


def _is_left_out(part: Any, field: Field[Any], value: Any) -> bool:
    """Whether a value stands for what a file leaves out; those of format 1 are told, too."""
    if isinstance(part, FrfSection) and field.name == "file":  # its numbers are what is compared
        return True
    return not isinstance(part, Scenario | Mode) and bool(value == field.default)


def _is_table(value: Any) -> bool:
    return is_dataclass(value) and not isinstance(value, type | InputShaper)


def _key_of(name: str) -> Key:
    for suffix in _SUFFIXES:
        if name.endswith(suffix):
            return (name.removesuffix(suffix),)
    return _KEYS.get(name, (name,))


def _limits(bounds: tuple[Any, ...], key: Key, scenario: Scenario) -> Iterator[tuple[Key, str]]:
    for k, bound in enumerate(bounds, start=1):
        low, high = bound if isinstance(bound, tuple) else (-bound, bound)
        sides = (high,) if low == -high else (low, high)
        if inf not in sides:
            unit = f"{scenario.position_unit}/s{f'^{k}' if k > 1 else ''}"
            texts = " to ".join(_number(side / scenario.position_scale) for side in sides)
            yield (*key, derivative_name(k).replace(" ", "_")), f"{texts} {unit}"


def _text(part: Any, name: str, value: Any, scenario: Scenario) -> str:
    """Return a value with its unit."""
    if value is None or value == ():
        return NONE
    if name == "shapers":
        return " ".join(_number(each) for shaper in value for each in _parts(shaper))
    if isinstance(value, tuple):
        kind = _quantity_of(type(part), name)
        unit = "" if kind is None else kind.kinds(scenario.motion)[0].unit
        return f"{' '.join(map(_number, value))} {unit}".strip()
    if isinstance(value, bool) or not isinstance(value, float):
        return str(value).lower() if isinstance(value, bool) else str(value)
    if isnan(value):
        return NONE
    kind = _quantity_of(type(part), name)
    if kind is not None:
        return f"{_number(value / kind.scale)} {kind.kinds(scenario.motion)[0].unit}"
    if name in _FRACTIONS:
        return f"{_number(100.0 * value)} %"
    if name in _POSITIONS:
        return f"{_number(value / scenario.position_scale)} {scenario.position_unit}"
    return f"{_number(value)} {_unit(name, scenario)}".strip()


def _parts(shaper: InputShaper) -> Iterator[float]:
    """Yield times and amplitudes of a shaper."""
    yield from shaper.times.tolist()
    yield from shaper.amplitudes.tolist()


def _unit(name: str, scenario: Scenario) -> str:
    if name in GAIN_UNITS[scenario.motion]:
        return GAIN_UNITS[scenario.motion][name]
    if name.endswith("inertia"):
        return "kg m^2" if scenario.motion == "angle" else "kg"
    if name in ("duration", "round_to"):
        return "s"
    return next((unit for suffix, unit in _SUFFIXES.items() if name.endswith(suffix)), "")


def _quantity_of(kind: type, name: str) -> Quantity | None:
    """Return what a key of a table of format 2 takes, where that is a quantity."""
    hint = get_type_hints(kind, include_extras=True).get(name)
    found = (each for each in getattr(hint, "__metadata__", ()) if isinstance(each, Quantity))
    return next(found, None)


def _number(value: float) -> str:
    return f"{value:.12g}"
