"""Handles in the Bode plot: places of a controller's elements, and what dragging one changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, pi
from typing import Any

from ...plant import PID
from .elements import filters_of
from .open_loops import OpenGain
from .quantities import scaled
from .state import State, value_at

Powers = Mapping[str, float]
"""Keys of values, each with the power of a factor that it is multiplied by."""


@dataclass(frozen=True)
class Handle:
    """A handle at a frequency.

    Parameters
    ----------
    name : str
    label : str
        For people: ``"notch 1"``.
    frequency_hz : float
    across : mapping of str to float
        What dragging by a factor of frequency multiplies, each by a power of that factor.
    along : mapping of str to float
        The same for dragging by a factor of gain.
    wide : mapping of str to float
        The same for making it wider.
    """

    name: str
    label: str
    frequency_hz: float
    across: Powers = field(default_factory=dict)
    along: Powers = field(default_factory=dict)
    wide: Powers = field(default_factory=dict)


def handles_of(state: State, crossover_hz: float) -> list[Handle]:
    """Return the handles of a loop's controller, its gain first, which is put at a crossover."""
    return [*_of_law(state, crossover_hz), *_of_filters(state)]


def dragged(
    state: State, handle: Handle, *, frequency: float = 1.0, gain: float = 1.0, width: float = 1.0
) -> dict[str, Any]:
    """Return the values that a handle puts when it is dragged by factors from where it was."""
    ratios: dict[str, float] = {}
    for powers, factor in ((handle.across, frequency), (handle.along, gain), (handle.wide, width)):
        for key, power in powers.items():
            ratios[key] = ratios.get(key, 1.0) * factor**power
    moved = {key: ratio for key, ratio in ratios.items() if ratio != 1.0}
    return {key: scaled(value_at(state.content, key), ratio) for key, ratio in moved.items()}


def crossover_gain(gain: OpenGain, crossover_hz: float, frequency: float) -> float:
    """Return by what factor the gain has to change for the crossover to change by a factor."""
    size = gain.size([crossover_hz, crossover_hz * frequency])
    return float(size[0] / size[1])


def _of_law(state: State, crossover_hz: float) -> Iterator[Handle]:
    law = state.loop.controller_noun.law
    gains = "controller.gains"
    if isinstance(law, PID):
        every = {f"{gains}.{name}": 1.0 for name in ("kp", "ki", "kr")}
        yield Handle("gain", "gain", crossover_hz, along=every)
        if law.kp > 0.0 and law.ki > 0.0:
            corner = law.ki / law.kp / (2.0 * pi)
            yield Handle("integral", "integral corner", corner, {f"{gains}.ki": 1.0})
        if law.kp > 0.0 and law.kr > 0.0:
            corner = law.kp / law.kr / (2.0 * pi)
            yield Handle("derivative", "derivative corner", corner, {f"{gains}.kr": -1.0})
        filtered, key = law.derivative_filter, "controller.derivative_filter"
    else:
        yield Handle("gain", "velocity gain", crossover_hz, along={f"{gains}.velocity_gain": 1.0})
        corner = law.position_gain / (2.0 * pi)
        yield Handle("position", "position gain", corner, {f"{gains}.position_gain": 1.0})
        if 0.0 < law.reset_time < inf:
            corner = 1.0 / (2.0 * pi * law.reset_time)
            yield Handle("integral", "reset time", corner, {f"{gains}.reset_time": -1.0})
        filtered, key = law.velocity_filter, f"{gains}.velocity_filter"
    if filtered > 0.0:
        yield Handle("rate", "rate filter", 1.0 / (2.0 * pi * filtered), {key: -1.0})


def _of_filters(state: State) -> Iterator[Handle]:
    nouns: Sequence[Any] = state.loop.controller_noun.filters
    for index, (table, noun) in enumerate(zip(filters_of(state), nouns, strict=True)):
        key, label = f"controller.filters[{index}]", f"{table['kind']} {index + 1}"
        if table["kind"] == "notch":
            moved = [name for name in ("frequency", "pole_frequency") if name in table]
            dampings = ("zero_damping", "pole_damping")
            yield Handle(
                key,
                label,
                noun.zero_hz,
                {f"{key}.{name}": 1.0 for name in moved},
                {f"{key}.zero_damping": 1.0},
                {f"{key}.{name}": 1.0 for name in dampings},
            )
        elif table["kind"] == "lead-lag":
            for name in ("zero", "pole"):
                yield Handle(
                    f"{key}.{name}",
                    f"{label} {name}",
                    getattr(noun, f"{name}_hz"),
                    {f"{key}.{name}": 1.0},
                )
        elif table["kind"] == "low-pass":
            yield Handle(key, label, noun.corner_hz, {f"{key}.corner": 1.0}, _peak(key, table))


def _peak(key: str, table: Mapping[str, Any]) -> Powers:
    """Return what the gain at the corner hangs on: 1/(2ζ) of order 2."""
    return {f"{key}.damping": -1.0} if "damping" in table and table.get("order", 2) == 2 else {}
