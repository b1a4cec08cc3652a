"""The table [requirements]: bounds on figures of the survey, of all moves or of one."""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import inf
from typing import Any, cast

from pydantic import ValidationInfo

from ..analysis.specification import FIGURES, Requirement
from .scenario_context import Context
from .scenario_keys import Key, number, quantity_schema
from .scenario_kinds import figure_kinds
from .scenario_messages import PlaceError, unknown_key
from .units import show

_FORCES = {"peak_force": "peak_torque", "rms_force": "rms_torque"}
"""What figures may be called on a linear axis."""

_KNOWN = FIGURES | {name: FIGURES[figure] for name, figure in _FORCES.items()}

_SIDES = {"min": "least", "max": "most"}


def read_requirements(value: object, info: ValidationInfo) -> tuple[Requirement, ...]:
    """Return the requirements of a table by figure, or by the name of a move and figure."""
    if not isinstance(value, dict):
        raise ValueError(
            f"{show(value)} is not a table; write [requirements] with {_example('load_settling')}"
        )
    context = cast(Context, info.context)
    return tuple(_requirements(value, context))


def _requirements(table: dict[str, Any], context: Context) -> Iterator[Requirement]:
    owners = (*context.moves, *context.tracking)
    for key, value in table.items():
        if key in _KNOWN:
            yield _requirement((key,), value, context)
        elif key not in owners:
            raise PlaceError((key,), unknown_key(key, value, (*_KNOWN, *owners)))
        elif not isinstance(value, dict):
            raise PlaceError(
                (key,), f"{show(value)} is not a table; write {{{_example('duration')}}}"
            )
        else:
            for figure, bounds in value.items():
                yield _requirement((key, figure), bounds, context)


def _requirement(place: tuple[str, ...], bounds: object, context: Context) -> Requirement:
    figure = place[-1]
    if figure not in _KNOWN:
        raise PlaceError(place, unknown_key(figure, bounds, tuple(_KNOWN)))
    if not isinstance(bounds, dict) or not bounds or not set(bounds) <= set(_SIDES):
        raise PlaceError(place, f"{show(bounds)} is not a bound; write {_example(figure)}")
    sides = {}
    for side, value in bounds.items():
        try:
            sides[_SIDES[side]] = _bound(figure, value, context)
        except ValueError as error:
            raise PlaceError((*place, side), str(error)) from None
    if sides.get("least", -inf) > sides.get("most", inf):
        raise PlaceError(place, "its min is above its max; exchange the two")
    return Requirement(".".join([*place[:-1], _FORCES.get(figure, figure)]), **sides)


def _bound(figure: str, value: object, context: Context) -> float:
    kinds = figure_kinds(_KNOWN[figure])
    if kinds is None:
        return float(number("max").read(value))
    return context.quantity(value, kinds.kinds)


def _example(figure: str) -> str:
    kinds = figure_kinds(_KNOWN[figure])
    return f"{figure} = {{max = {'1.6' if kinds is None else json.dumps(kinds.angle[0].example)}}}"


def _schema() -> dict[str, Any]:
    figures = {figure: _bounds_schema(figure) for figure in _KNOWN}
    of_one = {"type": "object", "properties": figures, "additionalProperties": False}
    return {"type": "object", "properties": figures, "additionalProperties": of_one}


def _bounds_schema(figure: str) -> dict[str, Any]:
    kinds = figure_kinds(_KNOWN[figure])
    one = {"type": "number"} if kinds is None else quantity_schema(*kinds.angle, *kinds.length)
    return {
        "type": "object",
        "properties": dict.fromkeys(_SIDES, one),
        "additionalProperties": False,
        "minProperties": 1,
    }


REQUIREMENTS = Key(read_requirements, _schema())
