"""Connections of a co-simulation: by name, checked, as weights on the blocks' outputs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shaping.pieces import FloatArray
from ..importing.description import FmuError, FmuUnit, candidates
from .conversion import conversion
from .over_time import Source, over_time
from .participants import Participant

Connections = Mapping[str, str | Sequence[str]] | Iterable[tuple[Source, str | Sequence[str]]]
"""Pairs of source and target, or a mapping from sources to targets."""

_MAX_LOOPS = 50
_GAIN = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*\*\s*(.+)")
_NO_UNIT = FmuUnit("")


@dataclass(frozen=True, eq=False)
class Wiring:
    """Inputs of each block at step k as given[k] + weights @ (all outputs).

    `links` are (block of the source, block of the target, "source -> target"); `notes` tell
    which units were converted, and where tables were held beyond their ends.
    """

    given: Mapping[str, FloatArray]
    weights: Mapping[str, FloatArray]
    links: tuple[tuple[str, str, str], ...]
    notes: tuple[str, ...]


def connect(
    blocks: Mapping[str, Participant], connections: Connections, time: FloatArray
) -> Wiring:
    """Return the wiring of blocks; FmuError for unknown names, algebraic loops, loose inputs."""
    outputs = [f"{name}.{signal}" for name, block in blocks.items() for signal in block.outputs]
    inputs = [f"{name}.{signal}" for name, block in blocks.items() for signal in block.inputs]
    given: dict[str, Any] = {
        name: np.tile(np.asarray(block.held, _dtype(block)), (len(time), 1))
        for name, block in blocks.items()
    }
    weights = {name: np.zeros((len(b.inputs), len(outputs))) for name, b in blocks.items()}
    links, notes = [], []
    touched: set[str] = set()
    pairs = [p for pair in _pairs(connections) for p in _by_element(*pair, outputs, inputs)]
    for source, target in pairs:
        if target not in inputs:
            raise FmuError(_unknown(target, inputs, outputs, "input", "output"))
        name, signal = target.split(".", 1)
        row = blocks[name].inputs.index(signal)
        if target not in touched:
            touched.add(target)
            given[name][:, row] = 0
        if not isinstance(source, str):
            part = blocks[name]
            values, note = over_time(
                source, target, time, steps=part.steps[row], exact=signal in part.wide
            )
            given[name][:, row] += values
            notes.append(note)
            continue
        factor, plain = _factored(source, outputs)
        if plain not in outputs:
            raise FmuError(_unknown(plain, outputs, inputs, "output", "input"))
        gain, offset, note = _conversion(blocks, source, plain, target, factor)
        weights[name][row, outputs.index(plain)] += gain
        given[name][:, row] += offset
        notes.append(note)
        links.append((plain.split(".", 1)[0], name, f"{source} -> {target}"))
    _check_loose(blocks, given)
    _check_algebraic(blocks, outputs, weights)
    return Wiring(given, weights, tuple(links), tuple(filter(None, notes)))


def _dtype(block: Participant) -> type:
    """Return what holds the inputs of a block: integers of 64 bits are objects."""
    return object if any(name in block.wide for name in block.inputs) else float


def loops(links: Iterable[tuple[str, str]], order: Sequence[str]) -> list[tuple[str, ...]]:
    """Return loops of blocks, each once, beginning with its first block in order; at most 50."""
    ahead: dict[str, list[str]] = {}
    for source, target in dict.fromkeys(links):
        ahead.setdefault(source, []).append(target)
    place = {name: i for i, name in enumerate(order)}
    found: list[tuple[str, ...]] = []
    for first in order:
        paths: list[tuple[str, ...]] = [(first,)]
        while paths and len(found) < _MAX_LOOPS:
            path = paths.pop()
            for following in ahead.get(path[-1], []):
                if following == first:
                    found.append(path)
                elif following not in path and place[following] > place[first]:
                    paths.append((*path, following))
    return found[:_MAX_LOOPS]


def _pairs(connections: Connections) -> Iterable[tuple[Source, str]]:
    items = connections.items() if isinstance(connections, Mapping) else connections
    for item in items:
        if isinstance(item, str) or len(item) != 2:
            raise FmuError(
                f"connection {item!r}: expected a pair (source, target), each 'block.signal'"
            )
        source, targets = item
        for target in [targets] if isinstance(targets, str) else targets:
            yield source, target


def _by_element(
    source: Source, target: str, outputs: Sequence[str], inputs: Sequence[str]
) -> Iterable[tuple[Source, str]]:
    """Yield a connection, or, where it is of whole arrays, those of their elements."""
    places = _places(target, inputs)
    if target in inputs or not places or not isinstance(source, str):
        yield source, target
        return
    plain = _factored(source, outputs)[1]
    if _places(plain, outputs) != places:
        raise FmuError(
            f"{target!r} is an array of {len(places)} values, {plain!r} is none with the same "
            f"elements: connect them one by one, such as '{target}{places[0]}'"
        )
    before = source.rstrip().removesuffix(plain)
    for place in places:
        yield f"{before}{plain}{place}", f"{target}{place}"


def _places(name: str, names: Sequence[str]) -> list[str]:
    return [found[len(name) :] for found in names if found.startswith(f"{name}[")]


def _unknown(name: str, wanted: Sequence[str], other: Sequence[str], kind: str, not_: str) -> str:
    if name in other:
        return (
            f"{name!r} is an {not_}; a connection goes from an output to an input, as in "
            "('controller.u', 'plant.u')"
        )
    return f"no {kind} {name!r}{candidates(name, wanted)}"


def _factored(source: str, outputs: Sequence[str]) -> tuple[float | str, str]:
    """Return what stands before a source, a gain or only its sign, and its name."""
    if source in outputs:
        return "+", source
    if found := _GAIN.fullmatch(source):
        return float(found[1]), found[2].strip()
    return ("-", source[1:].strip()) if source.startswith("-") else ("+", source)


def _conversion(
    blocks: Mapping[str, Participant], text: str, source: str, target: str, factor: float | str
) -> tuple[float, float, str]:
    """Return gain and offset of a connection, and what of its units the user should know."""
    given, taken = (
        blocks[name].units.get(signal, _NO_UNIT)
        for name, signal in (end.split(".", 1) for end in (source, target))
    )
    differ = bool(given.name and taken.name and given.name != taken.name)
    if not isinstance(factor, str):
        told = f"{text} -> {target}: {given.name} becomes {taken.name} by the gain that is given"
        return factor, 0.0, told if differ else ""
    found = conversion(given, taken)
    if found is None:
        raise FmuError(
            f"{source!r} is in {given.name}, {target!r} in {taken.name}, which cannot be converted "
            f"into each other: export both in one unit, or give the gain, ('1.0*{source}', "
            f"'{target}')"
        )
    sign = -1.0 if factor == "-" else 1.0
    gain, offset = found
    shift = f" {'+' if offset > 0.0 else '−'} {abs(offset):.9g}" if offset else ""
    told = f"{text} -> {target}: {given.name} converted to {taken.name}, ×{gain:.9g}{shift}"
    return sign * gain, sign * offset, told if differ else ""


def _check_loose(blocks: Mapping[str, Participant], given: Mapping[str, FloatArray]) -> None:
    for name, block in blocks.items():
        for signal, value in zip(block.inputs, given[name][0], strict=True):
            if np.isnan(value):
                raise FmuError(
                    f"'{name}.{signal}' is connected to nothing: connect it, or feed it a number, "
                    f"(0.0, '{name}.{signal}')"
                )


def _check_algebraic(
    blocks: Mapping[str, Participant], outputs: list[str], weights: Mapping[str, FloatArray]
) -> None:
    """Refuse a loop of outputs each of which passes the next one on within no time."""
    at_once = np.concatenate(
        [
            (block.through.astype(float) @ np.abs(weights[name])) > 0.0
            for name, block in blocks.items()
        ]
    )
    left = set(range(len(outputs)))
    while True:
        free = {i for i in left if not any(at_once[i, j] for j in left)}
        if not free:
            break
        left -= free
    if left:
        # what remains leads into a loop: follow it round
        path = [min(left)]
        while True:
            following = next(j for j in sorted(left) if at_once[path[-1], j])
            if following in path:
                names = [outputs[i] for i in reversed(path[path.index(following) :])]
                raise FmuError(
                    f"algebraic loop {' -> '.join([*names, names[0]])}: each passes its input on "
                    "within no time; put a delay or a plant between them, or combine them with "
                    "control.interconnect"
                )
            path.append(following)
