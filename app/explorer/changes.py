"""Changes of a state that a page asks for, by the kind of its message."""

from __future__ import annotations

from base64 import b64decode
from binascii import Error
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import isfinite
from types import MappingProxyType
from typing import Any

from ...shaping.checks import finite, positive
from .asked import with_asked, with_feedforward, without_asked
from .data_files import read_bytes
from .elements import added, moved, removed
from .handles import crossover_gain, dragged, handles_of
from .loop_view import margins_of
from .move_changes import with_order, with_shaper
from .open_loops import open_gain
from .quantities import with_number
from .state import State, in_time, put, value_at

Message = Mapping[str, Any]
Change = Callable[[State, Message], State]
"""From the state that a gesture began from and a message to the state after."""


def _set(state: State, message: Message) -> State:
    """Put a number, with the unit that there is, a text with its unit, or a word."""
    key = str(message["key"])
    if key == "order":
        return with_order(state, round(finite("order", message["number"])))
    if key == "shaper":
        return with_shaper(state, str(message["word"]))
    if key == "feedforward":
        return with_feedforward(state, str(message["word"]))
    if "word" in message:
        return put(state, {key: str(message["word"])})
    if "number" in message:
        return put(state, {key: with_number(value_at(state.content, key), message["number"])})
    return put(state, {key: message["text"]})


def _drag(state: State, message: Message) -> State:
    """Move a handle by factors of frequency, gain and width from where its gesture began."""
    factors = {
        name: positive(name, message.get(name, 1.0)) for name in ("frequency", "gain", "width")
    }
    crossover = positive("crossover_hz", message.get("hz", 1.0))
    name = message["handle"]
    handles = handles_of(state, crossover)
    handle = next((each for each in handles if each.name == name), None)
    if handle is None:
        there = ", ".join(each.name for each in handles)
        raise ValueError(f"handle {name!r}: there are {there}")
    if name == "gain":
        frequency = factors.pop("frequency")
        factors["gain"] *= crossover_gain(open_gain(state.loop), crossover, frequency)
    return put(state, dragged(state, handle, **factors))


def _add(state: State, message: Message) -> State:
    place = message.get("hz")
    if place is None:
        peak = margins_of(state).sensitivity_peak_hz
        place = peak if isfinite(peak) and peak > 0.0 else 1.0
    return added(state, str(message["filter"]), positive("hz", place))


def _uncertain(state: State, message: Message) -> State:
    inertia = finite("inertia_error", message.get("inertia_error", state.inertia_error))
    delay = finite("delay_error_s", message.get("delay_error_s", state.delay_error_s))
    if not 0.0 <= inertia < 1.0 or delay < 0.0:
        raise ValueError(
            f"errors of {inertia:g} of the inertia and {delay:g} s: expected a share from 0 to "
            "below 1, and a time not below zero"
        )
    return in_time(replace(state, inertia_error=inertia, delay_error_s=delay))


def _source(state: State, message: Message) -> State:
    source = message["source"]
    if source not in ("model", "data") or (source == "data" and state.measured is None):
        raise ValueError(
            f"source = {source!r}: expected 'model', or 'data' where a file was opened"
        )
    return replace(state, source=source)


def _data(state: State, message: Message) -> State:
    """Take a measured response as a file's bytes, in base64."""
    name = str(message["name"])
    try:
        content = b64decode(message["content"], validate=True)
    except Error:
        raise ValueError(f"{name}: did not come whole; drop it again") from None
    found = read_bytes(name, content, message)
    after = replace(state, measured=found, measured_name=name, source="data")
    margins_of(after)  # refuses what does not go with the controller
    return after


def _move(state: State, message: Message) -> State:
    index, count = int(message["move"]), len(state.scenario.moves)
    if not 0 <= index < count:
        raise ValueError(f"move {index}: there are {count} of them, counted from 0")
    return replace(state, move=index)


CHANGES: Mapping[str, Change] = MappingProxyType(
    {
        "set": _set,
        "drag": _drag,
        "add": _add,
        "ask": lambda state, message: with_asked(
            state, str(message["section"]), str(message["name"])
        ),
        "leave": lambda state, message: without_asked(state, str(message["key"])),
        "remove": lambda state, message: removed(state, int(message["index"])),
        "reorder": lambda state, message: moved(state, int(message["index"]), int(message["to"])),
        "uncertain": _uncertain,
        "source": _source,
        "data": _data,
        "move": _move,
    }
)
