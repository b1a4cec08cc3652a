"""Fields of an explorer: each a value of the scenario with its unit, its range and its words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import floor, log10
from typing import Any

from ...plant import PID
from ...shaping.derivatives import DERIVATIVE_NAMES
from ..scenario_messages import key_path
from .elements import filters_of
from .quantities import is_quantity, number_and_unit
from .state import State, value_at

Field = dict[str, Any]
Place = list[str | int]
"""Where a table stands: names, and numbers of a list."""

_WORDS = {
    "kp": "proportional kp",
    "ki": "integral ki",
    "kr": "rate kr",
    "position_gain": "position gain",
    "velocity_gain": "velocity gain",
    "reset_time": "reset time",
    "velocity_filter": "velocity filter",
    "derivative_filter": "rate filter",
    "sample_time": "sample time",
    "zero_damping": "damping of the zero",
    "pole_damping": "damping of the pole",
    "pole_frequency": "frequency of the pole",
    "settle_to": "settle to",
}
_GAINS = ("kp", "ki", "kr", "position_gain", "velocity_gain", "reset_time", "velocity_filter")
_PLANT = ("inertia", "mass", "viscous", "load_viscous", "spring")
_OF_FILTER = (
    "frequency",
    "pole_frequency",
    "zero_damping",
    "pole_damping",
    "zero",
    "pole",
    "corner",
    "order",
    "damping",
)
_SPAN = 30.0


def element_fields(state: State) -> list[dict[str, Any]]:
    """Return the elements of a loop: plant, how the controller runs, law, filters in order."""
    law = "PID" if isinstance(state.loop.controller_noun.law, PID) else "P-PI"
    elements = [
        _element(state, "plant", "plant", ["plant"], _PLANT),
        *_modes(state),
        _element(state, "run", "sampling", ["controller"], ("sample_time", "delay")),
        _element(state, "law", law, ["controller", "gains"], _GAINS),
    ]
    law_fields = elements[-1]["fields"]
    law_fields += _fields(state, ["controller"], ("derivative_filter",))
    for index, table in enumerate(filters_of(state)):
        label = f"{table['kind']} {index + 1}"
        where: Place = ["controller", "filters", index]
        element = _element(state, key_path(where), label, where, _OF_FILTER)
        elements.append(element | {"filter": index})
    return [each for each in elements if each["fields"] or "filter" in each]


def move_fields(state: State) -> list[dict[str, Any]]:
    """Return the elements of a move: the move, its limits, the filter behind it."""
    if not state.scenario.moves:
        return []
    where: Place = ["moves", state.move]
    limits: Place = ["limits", state.scenario.moves[state.move].limits_name]
    move = _element(state, "move", "move", where, ("distance", "duration", "settle_to"))
    bounds = _element(state, "limits", "limits", limits, _limit_names(state, limits))
    order = len(state.scenario.moves[state.move].bounds)
    bounds["fields"].insert(0, _order(order))
    shaper = _element(state, "shaper", "input shaper", ["moves", state.move], ())
    shaper["fields"] = [_shaper(state)]
    behind = _element(state, "filter", "jerk filter", ["filter"], ("corner", "order"))
    return [each for each in (move, bounds, shaper, behind) if each["fields"]]


def _element(
    state: State, name: str, label: str, where: Place, names: tuple[str, ...]
) -> dict[str, Any]:
    return {"name": name, "label": label, "fields": list(_fields(state, where, names))}


def _modes(state: State) -> Iterator[dict[str, Any]]:
    for index, mode in enumerate(state.content["plant"].get("modes", ())):
        label = f"mode {mode.get('name', index + 1)}"
        where: Place = ["plant", "modes", index]
        yield _element(state, key_path(where), label, where, ("frequency", "damping"))


def _fields(state: State, where: Place, names: tuple[str, ...]) -> Iterator[Field]:
    for name in names:
        value = value_at(state.content, key_path([*where, name]))
        if isinstance(value, list):
            for side, one in enumerate(value):
                label = f"{_label(name)}, {'lower' if side == 0 else 'upper'}"
                yield field_of(key_path([*where, name, side]), label, one)
        elif value is not None and is_quantity(value):
            yield field_of(key_path([*where, name]), _label(name), value)


def _label(name: str) -> str:
    return _WORDS.get(name, name.replace("_", " "))


def field_of(key: str, label: str, value: Any) -> Field:
    """Return a field with a range around its value, in steps that keep still while it changes.

    What is no number is a field of text.
    """
    if not is_quantity(value):
        return {"key": key, "label": label, "text": value, "scale": "text"}
    number, unit = number_and_unit(value)
    field = {"key": key, "label": label, "number": number, "unit": unit}
    if isinstance(value, int):
        return field | {"low": 1, "high": 12, "scale": "whole"}
    size = 10.0 ** floor(log10(abs(number)) + 0.5) if number else 1.0
    if not number:
        return field | {"low": 0.0, "high": size, "scale": "linear"}
    ends = sorted((number / abs(number) * size / _SPAN, number / abs(number) * size * _SPAN))
    return field | {"low": ends[0], "high": ends[1], "scale": "log"}


def _limit_names(state: State, where: Place) -> tuple[str, ...]:
    """Return the names of a set's limits, lowest derivative first."""
    table: Mapping[str, Any] = value_at(state.content, key_path(where))
    usual = [name.replace(" ", "_") for name in DERIVATIVE_NAMES]
    return tuple(sorted(table, key=lambda name: usual.index(name) if name in usual else 99))


def _order(order: int) -> Field:
    return {
        "key": "order",
        "label": "order",
        "number": order,
        "unit": "",
        "low": 1,
        "high": 6,
        "scale": "whole",
    }


def _shaper(state: State) -> Field:
    """Return the choice of the input shaper."""
    own = value_at(state.content, key_path(["moves", state.move, "shaper"]))
    shaper = value_at(state.content, "shaper") if own is None else own
    kind = shaper["kind"] if isinstance(shaper, Mapping) else "none"
    choices = ["none", "ZV", "ZVD", "ZVDD", "EI"]
    return {"key": "shaper", "label": "kind", "word": kind, "choices": choices}
