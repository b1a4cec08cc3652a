"""Margins at the worst, where the plant's inertia and its delay are off by as much as said."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite, nan
from typing import Any

import numpy as np

from ...analysis.margins import LoopMargins, loop_margins
from ...plant import PID, CascadedPI, Controller
from .state import State
from .verdicts import Margins

NAMES = {
    "phase_margin_deg": min,
    "lower_gain_margin_db": min,
    "upper_gain_margin_db": min,
    "delay_margin_s": min,
    "modulus_margin": min,
    "sensitivity_peak": max,
    "complementary_peak": max,
}
"""Margins that have a worst case, each with what picks it."""


def worst_parts(state: State) -> Iterator[dict[str, Any]]:
    """Yield "more" for each corner of what is uncertain, then the worst of each margin.

    L is taken times 1/(1 ± the inertia's error), which is exact for an inertia that is free, and
    with the delay's error added; of data the worst is that within the circles as well. Nothing is
    worst, where neither is off.
    """
    corners: list[Margins] = []
    for margins in _corners(state):
        corners.append(margins)
        yield {"part": "more"}
    yield {"part": "worst", **(_worst(corners) if corners else {"stable": None, "margins": {}})}


def _worst(corners: list[Margins]) -> dict[str, Any]:
    stable = all(margins.stable is not False for margins in corners)
    worst = {name: pick(_values(corners, name)) for name, pick in NAMES.items()}
    shown = {name: value if isfinite(value) else None for name, value in worst.items()}
    return {"stable": stable, "margins": shown if stable else {}}


def _values(corners: list[Margins], name: str) -> list[float]:
    found = [getattr(each, f"{name}_worst", getattr(each, name)) for each in corners]
    return [value for value in found if value == value] or [nan]


def _corners(state: State) -> Iterator[Margins]:
    gains = {1.0 / (1.0 + sign * state.inertia_error) for sign in (-1.0, 1.0)}
    for gain in sorted(gains):
        for late in sorted({0.0, state.delay_error_s}):
            if gain != 1.0 or late:
                yield _margins(state, gain, late)


def _margins(state: State, gain: float, late: float) -> Margins:
    controller = with_gain(state.loop.controller_noun, gain)
    if state.data is not None:
        return _of_data(state, controller, gain, late)
    return _of_model(state, controller, late)


def _of_model(state: State, controller: Controller, late: float) -> LoopMargins:
    if controller.sample_time is None:
        loop = replace(state.loop, controller=controller).loop_transfer()
        of_loop: LoopMargins = loop_margins(loop, delay=late)
        return of_loop
    later = replace(controller, delay=controller.delay + late)
    return loop_margins(replace(state.loop, controller=later, feedforward=None))


def _of_data(state: State, controller: Controller, gain: float, late: float) -> Margins:
    assert state.data is not None
    data, turn = state.data, np.exp(-2j * np.pi * state.data.frequency_hz * late)
    if data.kind == "plant":
        shifted = replace(data, response=data.response * turn) if late else data
        return loop_margins(shifted, controller=controller)
    if data.kind != "loop":
        return loop_margins(data, controller=state.data_controller)
    sigma = None if data.sigma is None else gain * data.sigma
    return loop_margins(replace(data, response=gain * data.response * turn, sigma=sigma))


def with_gain(controller: Controller, gain: float) -> Controller:
    """Return a controller with its torque times a gain."""
    law = controller.law
    if isinstance(law, PID):
        gains = {name: gain * getattr(law, name) for name in ("kp", "ki", "kr")}
        return replace(controller, law=replace(law, **gains))
    assert isinstance(law, CascadedPI)
    return replace(controller, law=replace(law, velocity_gain=gain * law.velocity_gain))
