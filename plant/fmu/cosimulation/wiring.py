"""Connections of a co-simulation: by name, checked, as weights on the blocks' outputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....shaping.checks import finite
from ....shaping.pieces import FloatArray
from ..importing.description import FmuError, candidates
from .participants import Participant

Connections = Mapping[str, str | Sequence[str]] | Iterable[tuple[str | float, str | Sequence[str]]]
"""Pairs of source and target, or a mapping from sources to targets."""

_MAX_LOOPS = 50


@dataclass(frozen=True, eq=False)
class Wiring:
    """Inputs of each block as constants + weights @ (all outputs).

    `links` are (block of the source, block of the target, "source -> target").
    """

    constants: Mapping[str, FloatArray]
    weights: Mapping[str, FloatArray]
    links: tuple[tuple[str, str, str], ...]


def connect(blocks: Mapping[str, Participant], connections: Connections) -> Wiring:
    """Return the wiring of blocks; FmuError for unknown names, algebraic loops, loose inputs."""
    outputs = [f"{name}.{signal}" for name, block in blocks.items() for signal in block.outputs]
    inputs = [f"{name}.{signal}" for name, block in blocks.items() for signal in block.inputs]
    constants = {name: block.held.copy() for name, block in blocks.items()}
    weights = {name: np.zeros((len(b.inputs), len(outputs))) for name, b in blocks.items()}
    links = []
    touched: set[str] = set()
    for source, target in _pairs(connections):
        if target not in inputs:
            raise FmuError(_unknown(target, inputs, outputs, "input", "output"))
        name, signal = target.split(".", 1)
        row = blocks[name].inputs.index(signal)
        if target not in touched:
            touched.add(target)
            constants[name][row] = 0.0
        if not isinstance(source, str):
            constants[name][row] += finite(f"source of {target}", source)
            continue
        sign, plain = (-1.0, source[1:].strip()) if source.startswith("-") else (1.0, source)
        if plain not in outputs:
            raise FmuError(_unknown(plain, outputs, inputs, "output", "input"))
        _check_units(blocks, plain, target)
        weights[name][row, outputs.index(plain)] += sign
        links.append((plain.split(".", 1)[0], name, f"{source} -> {target}"))
    _check_loose(blocks, constants)
    _check_algebraic(blocks, outputs, weights)
    return Wiring(constants, weights, tuple(links))


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


def _pairs(connections: Connections) -> Iterable[tuple[str | float, str]]:
    items = connections.items() if isinstance(connections, Mapping) else connections
    for item in items:
        if isinstance(item, str) or len(item) != 2:
            raise FmuError(
                f"connection {item!r}: expected a pair (source, target), each 'block.signal'"
            )
        source, targets = item
        for target in [targets] if isinstance(targets, str) else targets:
            yield source, target


def _unknown(name: str, wanted: Sequence[str], other: Sequence[str], kind: str, not_: str) -> str:
    if name in other:
        return (
            f"{name!r} is an {not_}; a connection goes from an output to an input, as in "
            "('controller.u', 'plant.u')"
        )
    return f"no {kind} {name!r}{candidates(name, wanted)}"


def _check_units(blocks: Mapping[str, Participant], source: str, target: str) -> None:
    given, taken = (
        blocks[name].units.get(signal, "")
        for name, signal in (end.split(".", 1) for end in (source, target))
    )
    if given and taken and given != taken:
        raise FmuError(
            f"{source!r} is in {given}, {target!r} in {taken}: export both in one unit, or put a "
            "gain between them, control.ss([], [], [], [[factor]], dt)"
        )


def _check_loose(blocks: Mapping[str, Participant], constants: Mapping[str, FloatArray]) -> None:
    for name, block in blocks.items():
        for signal, value in zip(block.inputs, constants[name], strict=True):
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
