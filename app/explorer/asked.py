"""What a scenario says besides plant, controller and moves: values to edit, to add, to leave out.

Its feedforward, its disturbances and what is required of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

from ...analysis.specification import FIGURES, HIGHER_IS_BETTER
from ...shaping.derivatives import DERIVATIVE_NAMES
from ..overrides import parts_of
from ..scenario_kinds import figure_kinds, gain, moved, torque
from ..scenario_messages import key_path
from .fields import Field, Place, field_of
from .quantities import said, with_number
from .state import State, put, value_at, with_content

SECTIONS = ("feedforward", "disturbances", "requirements")

_OWN = ("inertia", "velocity", "acceleration", "jerk", "snap", "inverse")
_KINDS = ("of the inertia", "by derivatives", "inverse", "inverse at low frequency")
_RATIO = 1.6
_WORDS: Mapping[str, tuple[str, ...]] = {
    "on": ("motor", "load"),
    "kind": ("first_order", "double_pole", "von_karman"),
}
"""Choices, by the name of the key."""


def asked_part(state: State) -> dict[str, Any]:
    """Return the sections as elements, each with what may be added to it.

    A field that can be left out has the key that is taken away then.
    """
    return {"part": "asked", "elements": [_section(state, name) for name in SECTIONS]}


def with_asked(state: State, section: str, name: str) -> State:
    """Return the state with one value more in a section, which begins with a usual one."""
    begin = dict(_missing(state, section))
    if name not in begin:
        raise ValueError(f"{section}.{name}: expected one of {', '.join(begin)}")
    return put(state, {key_path([section, name]): begin[name]})


def without_asked(state: State, key: str) -> State:
    """Return the state without a value of a section, and without tables that it leaves empty."""
    place = parts_of(key)
    if value_at(state.content, key) is None or place[0] not in SECTIONS or len(place) < 2:
        raise ValueError(f"{key}: expected a value of {', '.join(SECTIONS)} that is there")
    content = deepcopy(state.content)
    _pruned(content, place)
    return with_content(state, content)


def with_feedforward(state: State, kind: str) -> State:
    """Return the state with a feedforward of another kind; by derivatives it begins as it was."""
    if kind not in _KINDS:
        raise ValueError(f"feedforward {kind!r}: expected one of {', '.join(_KINDS)}")
    content = deepcopy(state.content)
    for name in _OWN:
        if name in content.get("feedforward", {}):
            _pruned(content, ["feedforward", name])
    plain = with_content(state, content)
    return put(plain, dict(_of_kind(state, kind))) if kind != _KINDS[0] else plain


def _of_kind(state: State, kind: str) -> Iterator[tuple[str, Any]]:
    if kind != "by derivatives":
        yield "feedforward.inverse", True if kind == "inverse" else "low-frequency"
        return
    gains = state.loop.feedforward_noun.torque
    for k in (1, 2, 3, 4):
        if gains.get(k) or k == 2:
            unit = _gain_unit(state, k)
            yield f"feedforward.{DERIVATIVE_NAMES[k]}", said(gains.get(k, 0.0), unit)


def _pruned(table: dict[str, Any], place: list[str | int]) -> None:
    first, *rest = place
    if rest:
        _pruned(table[str(first)], rest)
    if not rest or not table[str(first)]:
        del table[str(first)]


def _section(state: State, name: str) -> dict[str, Any]:
    fields = list(_walked(state.content.get(name, {}), [name]))
    if name == "feedforward":
        fields = [field for field in fields if field["key"] != "feedforward.inverse"]
        fields.insert(0, _kind(state))
    more = [each for each, _ in _missing(state, name)]
    return {"name": name, "label": name, "fields": fields, "section": name, "more": more}


def _walked(table: Mapping[str, Any], where: Place) -> Iterator[Field]:
    """Yield a field for each value of a table and of those within it, but lists and flags."""
    for name, value in table.items():
        place: Place = [*where, name]
        if isinstance(value, Mapping):
            yield from _walked(value, place)
        elif isinstance(value, str | int | float) and not isinstance(value, bool):
            yield {**_field(place, value), **_leaving(table, place)}


def _leaving(table: Mapping[str, Any], place: Place) -> Field:
    """Return what leaving a value out takes away: a disturbance goes as a whole."""
    if place[0] != "disturbances" or len(place) == 2:
        return {"leave": key_path(place)}
    return {"leave": key_path(place[:2])} if place[-1] == next(iter(table)) else {}


def _field(place: Place, value: Any) -> Field:
    label = ", ".join(str(part).replace("_", " ") for part in place[1:])
    field, words = field_of(key_path(place), label, value), _WORDS.get(str(place[-1]), ())
    if field["scale"] == "text" and value in words:
        return {"key": field["key"], "label": label, "word": value, "choices": list(words)}
    return field


def _kind(state: State) -> Field:
    there = state.content.get("feedforward", {})
    kind = _KINDS[1] if set(there) & set(_OWN[1:5]) else _KINDS[0]
    if there.get("inverse"):
        kind = _KINDS[2] if there["inverse"] is True else _KINDS[3]
    return {"key": "feedforward", "label": "kind", "word": kind, "choices": list(_KINDS)}


def _missing(state: State, section: str) -> Iterator[tuple[str, Any]]:
    """Yield what may be added to a section, and what it begins with."""
    there = state.content.get(section, {})
    usual = {
        "feedforward": _of_feedforward,
        "disturbances": _of_disturbances,
        "requirements": _of_requirements,
    }
    if section not in usual:
        raise ValueError(f"section {section!r}: expected one of {', '.join(usual)}")
    for name, begin in usual[section](state):
        if name not in there and name.replace("torque", "force") not in there:
            yield name, begin


def _gain_unit(state: State, k: int) -> str:
    example = gain(k, "gain").kinds(state.scenario.motion)[0].example
    return example.partition(" ")[2]


def _of_feedforward(state: State) -> Iterator[tuple[str, Any]]:
    kind = _kind(state)["word"]
    if kind == "by derivatives":
        for k in (1, 2, 3, 4):
            yield DERIVATIVE_NAMES[k], f"0 {_gain_unit(state, k)}"
    elif kind == "of the inertia" and state.scenario.motion == "angle":
        yield "inertia", said(state.loop.feedforward_noun.torque.get(2, 0.0), "kg m^2")
    yield "friction", with_number(_torque(state), 0.0)
    yield "lead", "0 s" if state.scenario.controller.sample_time is None else "auto"
    yield "error", "10 %"


def _of_disturbances(state: State) -> Iterator[tuple[str, Any]]:
    size = _torque(state)
    yield "torque_step", {"torque": size, "on": "load"}
    yield "torque_sine", {"amplitude": size, "frequency": "1 Hz", "duration": "10 s"}
    yield "wind", {"kind": "first_order", "sigma": size, "corner": "0.5 Hz"}
    if state.scenario.controller.sample_time is not None:
        example = moved().kinds(state.scenario.motion)[0].example
        yield "encoder_noise", with_number(example, 0.0)


def _of_requirements(state: State) -> Iterator[tuple[str, Any]]:
    for figure, unit in FIGURES.items():
        kinds = figure_kinds(unit)
        begin = _RATIO if kinds is None else kinds.kinds(state.scenario.motion)[0].example
        if figure in HIGHER_IS_BETTER and kinds is None:
            begin = round(1.0 / _RATIO, 2)
        yield figure, {"min" if figure in HIGHER_IS_BETTER else "max": begin}


def _torque(state: State) -> str:
    text: str = with_number(torque().kinds(state.scenario.motion)[0].example, 1.0)
    return text
