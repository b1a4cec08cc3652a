"""Changes of a move that are more than a number: its order, its input shaper."""

from __future__ import annotations

from typing import Any

from ...shaping.derivatives import DERIVATIVE_NAMES
from ..scenario_messages import key_path
from ..units import convert
from .move_view import modes_of, planned_of
from .quantities import said
from .state import State, put, value_at

_HIGHEST = 6
_SHARE = 0.1  # of the move's duration, in which the new highest limit builds up the one below
_UNITS = {"angle": "deg", "length": "mm"}


def with_order(state: State, order: int) -> State:
    """Return the state with limits up to a derivative: those above go, those missing come.

    A limit that comes lets the one below it be reached within a tenth of the move.
    """
    if not 1 <= order <= _HIGHEST:
        raise ValueError(f"order {order}: expected 1 (velocity) to {_HIGHEST} (pop)")
    limits = ["limits", state.scenario.moves[state.move].limits_name]
    names = list(value_at(state.content, key_path(limits)))
    above = [name for name in names if derivative_of(name) > order]
    values: dict[str, Any] = {key_path([*limits, name]): None for name in above}
    highest = DERIVATIVE_NAMES[order]
    if highest not in names:
        values[key_path([*limits, highest])] = _new_limit(state, order)
    return put(state, values)


def with_shaper(state: State, kind: str) -> State:
    """Return the state with an input shaper of a kind, or "none", for the lowest of its modes."""
    key = key_path(["moves", state.move, "shaper"])
    if kind == "none":
        return put(state, {key: "none"})
    own = value_at(state.content, key)
    shaper = own if isinstance(own, dict) else value_at(state.content, "shaper")
    if isinstance(shaper, dict):
        return put(state, {key: {**shaper, "kind": kind}})
    modes = sorted(modes_of(state), key=lambda mode: mode.frequency_hz)
    if not modes:
        raise ValueError(
            "an input shaper nulls a mode, and this scenario has none; write [[modes]] with name "
            "and frequency into it"
        )
    table = {"frequency": said(modes[0].frequency_hz, "Hz")}
    table["damping"] = said(100.0 * modes[0].damping, "%")
    return put(state, {key: {"kind": kind, **table}})


def derivative_of(name: str) -> int:
    """Return the number of the derivative that a key of a set of limits bounds."""
    if name in DERIVATIVE_NAMES:
        return DERIVATIVE_NAMES.index(name)
    return int(name.removeprefix("derivative_"))


def _new_limit(state: State, k: int) -> str:
    """Return a limit on derivative k: what the move has, or what it needs to get there soon."""
    trajectory = planned_of(state)
    assert trajectory is not None
    known = min(k, trajectory.order)
    value = trajectory.peak(known) / (_SHARE * trajectory.duration) ** (k - known)
    unit = _UNITS[state.scenario.motion]
    per = f"{unit}/s" if k == 1 else f"{unit}/s^{k}"
    return said(float(f"{convert(value, unit):.3g}"), per)
