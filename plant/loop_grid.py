"""The responses of simulated loops on a grid, or at times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..shaping.checks import positive
from ..shaping.pieces import FloatArray
from ..shaping.propagate import grid
from ..shaping.real_numbers import real_array, shown
from .commands import derivatives_of, on_breaks
from .loop_response import LoopResponse
from .run import Run, Scene
from .simulate import simulate_all


def response_of(scene: Scene, dt: float | None, times: Any) -> LoopResponse:
    """Run a scene and return its response on a grid, or at times."""
    return responses_of((scene,), dt, times)[0]


def responses_of(scenes: Sequence[Scene], dt: float | None, times: Any) -> list[LoopResponse]:
    """Run scenes and return their responses on grids, or at times."""
    grids = [_grid_of(scene, dt, times) for scene in scenes]
    return [_shown(run, at) for run, at in zip(simulate_all(scenes), grids, strict=True)]


def _grid_of(scene: Scene, dt: float | None, times: Any) -> FloatArray:
    if times is not None:
        given = real_array("times", times)
        rising = given.ndim == 1 and bool((np.diff(given) >= 0.0).all())
        if not rising or not given.size or given[0] < scene.begin:
            raise ValueError(
                f"times = {shown(times)}: expected increasing times, none before the start at "
                f"{shown(scene.begin)}"
            )
        return given
    if dt is None:
        raise ValueError("dt is missing: give the spacing of the time grid, or times=…")
    return grid(scene.begin, scene.duration, positive("dt", dt))


def _shown(run: Run, times: FloatArray) -> LoopResponse:
    scene = run.scene
    modes, states = run.at(times - scene.begin)
    inputs = derivatives_of(scene.command, on_breaks(scene.command, times), 2)
    d = scene.axis.dynamics
    twist = run.layout.row(d.load - d.motor)
    position, load = states @ run.seen_row, states @ run.load_row
    torque = _by_mode(run.hybrid.torque, modes, states)
    outputs = [position, inputs[0] - position, torque]
    outputs += [load, states @ twist, _by_mode(run.torque_rows, modes, states)]
    response = LoopResponse(times, inputs, np.array(outputs), states.T, scene=scene)
    vars(response)["run"] = run  # what was simulated is kept
    return response


def _by_mode(rows: FloatArray, modes: Any, states: FloatArray) -> FloatArray:
    """Return what rows, one a mode, make of states."""
    if (rows == rows[0]).all():
        return np.asarray(states @ rows[0])
    return np.asarray((states * rows[modes]).sum(axis=1))
