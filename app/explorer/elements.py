"""The elements of a controller: law and filters, listed, added, removed, put in order."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from .quantities import DIGITS, said
from .state import State, with_content

KINDS = ("notch", "lead-lag", "low-pass")
"""Kinds of filter that can be added."""


def filters_of(state: State) -> list[Mapping[str, Any]]:
    """Return the tables of the filters, in the order of the signal."""
    return list(state.content["controller"].get("filters", []))


def added(state: State, kind: str, frequency_hz: float) -> State:
    """Return the state with one more filter, behind the others.

    Parameters
    ----------
    state : State
    kind : "notch", "lead-lag" or "low-pass"
    frequency_hz : float
        Where it acts; a filter that the sampling leaves no room for comes below that.
    """
    if kind not in KINDS:
        raise ValueError(f"kind = {kind!r}: expected one of {', '.join(KINDS)}")
    sample = state.scenario.controller.sample_time
    highest = frequency_hz if sample is None else 0.2 / sample
    return _with_filters(state, [*filters_of(state), _new(kind, min(frequency_hz, highest))])


def removed(state: State, index: int) -> State:
    """Return the state without one of the filters."""
    filters = filters_of(state)
    del filters[_there(index, filters)]
    return _with_filters(state, filters)


def moved(state: State, index: int, to: int) -> State:
    """Return the state with a filter at another place of the signal's way."""
    filters = filters_of(state)
    one = filters.pop(_there(index, filters))
    filters.insert(max(0, min(to, len(filters))), one)
    return _with_filters(state, filters)


def _there(index: int, filters: list[Any]) -> int:
    if not 0 <= index < len(filters):
        raise ValueError(f"filter {index}: there are {len(filters)} of them, counted from 0")
    return index


def _with_filters(state: State, filters: list[Any]) -> State:
    content = deepcopy(state.content)
    content["controller"]["filters"] = [dict(each) for each in filters]
    if not filters:
        del content["controller"]["filters"]
    return with_content(state, content)


def _new(kind: str, frequency_hz: float) -> dict[str, Any]:
    def hertz(ratio: float) -> str:
        return said(float(f"{ratio * frequency_hz:.{DIGITS}g}"), "Hz")

    if kind == "notch":
        damping = {"zero_damping": "5 %", "pole_damping": "50 %"}
        return {"kind": kind, "frequency": hertz(1.0), **damping}
    if kind == "lead-lag":
        return {"kind": kind, "zero": hertz(0.5), "pole": hertz(2.0)}
    return {"kind": kind, "corner": hertz(1.0), "order": 2, "damping": "70 %"}
