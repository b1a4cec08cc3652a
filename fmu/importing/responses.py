"""Impulse responses of an FMU, measured by going back to one point, if it is linear."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...shaping.checks import positive
from ...shaping.pieces import FloatArray
from .description import FmuError, FmuVariable
from .stepping import Fmu

_AMPLITUDES = 10.0 ** -np.arange(0, 7)
_SEQUENCE = 4096  # steps of the sequence of impulses, at most
_FLOOR = 1e-12  # values below, relative to a channel's peak, are rounding


@dataclass(frozen=True, eq=False)
class UnitResponse:
    """Response `values` (horizon, outputs) to a unit impulse, from impulses of `size`.

    `change` is by how much it changes when the amplitude is halved.
    """

    values: FloatArray
    size: float
    change: float


def unit_response(
    origin: Origin,
    dt: float,
    j: int,
    rows: list[int],
    amplitude: float | None,
    horizon: int,
    tolerance: float,
) -> UnitResponse:
    """Return the response to a unit impulse at input j; FmuError where it is not linear."""
    fmu = origin.fmu
    variable = _input(fmu, j)
    largest = _room(variable, float(origin.inputs[j]))
    if amplitude is not None:
        tries = [min(positive("amplitude", amplitude), largest)]
    else:
        tries = [min(abs(variable.nominal or 1.0), largest) * a for a in _AMPLITUDES.tolist()]
    one = np.zeros(horizon)
    one[0] = 1.0
    changes: dict[float, float] = {}
    for size in tries:
        values = _run(origin, dt, j, size * one)[:, rows] / size
        if changes and not values.any():
            _refuse_dead_zone(fmu, j, list(changes)[-1], size)
        half = 0.5 * size
        change = difference(_run(origin, dt, j, half * one)[:, rows] / half, values)
        if change <= tolerance:
            return UnitResponse(values, size, change)
        changes[size] = change
    size = min(changes, key=lambda tried: changes[tried])
    raise FmuError(
        f"the response of {fmu.description.model_name} to {fmu.input_names[j]!r} is not linear: "
        f"half an impulse of {size:g} changes it by {changes[size]:.2g} of its peak, tolerance = "
        f"{tolerance:g}; give another amplitude, a shorter horizon or a larger tolerance; or, if "
        "it has a solver inside that is too coarse, load_fmu(…, tolerance=1e-9)"
    )


def check_time_invariance(
    origin: Origin, dt: float, j: int, rows: list[int], response: UnitResponse, tolerance: float
) -> None:
    """Refuse an FMU whose response to a sequence of impulses is not the sum of their responses.

        y_{k+1} = Σ_i h_{k−i}·w_i,   w_i = ± size/√N with random signs

    Errors are relative to Σ_i |h_{k−i}·w_i|, and may exceed `tolerance` by what the smaller
    impulses make of the response's own `change`.
    """
    fmu = origin.fmu
    count = min(len(response.values), _SEQUENCE)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], count)
    signs[0] = 1.0
    weights = signs * response.size / np.sqrt(count)
    found = _run(origin, dt, j, weights)[:, rows]
    for channel, h in zip(found.T, response.values[:count].T, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):
            expected = np.convolve(weights, h)[:count]
            scale = np.maximum.accumulate(np.convolve(np.abs(weights), np.abs(h))[:count])
            scale = np.maximum(scale, max(_FLOOR * scale[-1], np.finfo(float).tiny))
            error = float(np.nan_to_num(np.abs(channel - expected) / scale, nan=np.inf).max())
        if error > tolerance + np.sqrt(count) * response.change:
            told = f"{error:.2g} of its size" if error < 1.0 else "more than its size"
            raise FmuError(
                f"{fmu.description.model_name} does not respond to {fmu.input_names[j]!r} alike at "
                f"every step of dt = {dt!r} (off by {told}): it samples at another rate "
                "inside, changes with time, or small impulses act otherwise than large ones; give "
                "as dt the FMU's own sampling time or a whole multiple of it, or step the FMU to a "
                "point of rest first; or, if it has a solver inside that is too coarse, "
                "load_fmu(…, tolerance=1e-9)"
            )


def difference(found: FloatArray, expected: FloatArray) -> float:
    """Return the largest difference, relative to each channel's largest value so far."""
    peaks = np.maximum.accumulate(np.abs(expected), axis=0)
    floor = np.where(peaks[-1] > 0.0, np.finfo(float).tiny, np.inf)
    scale = np.maximum(peaks, floor)
    with np.errstate(invalid="ignore", over="ignore"):
        ratio = np.abs(found - expected) / np.maximum(scale, _FLOOR * peaks[-1])
    return float(np.nan_to_num(ratio, nan=np.inf).max(initial=0.0))


class Origin:
    """The point about which an FMU is linearised, and the way back to it.

    By a snapshot; or, `by_restart`, by a new instance each time, with no snapshot alive, which
    leads to the FMU's start.
    """

    def __init__(self, fmu: Fmu, *, by_restart: bool = False) -> None:
        self.fmu = fmu
        self.inputs = fmu.inputs
        self._state = None if by_restart else fmu.get_state()

    def back(self) -> None:
        """Go there."""
        if self._state is None:
            self.fmu.restart()
        else:
            self.fmu.set_state(self._state)


def _run(origin: Origin, dt: float, j: int, weights: FloatArray) -> FloatArray:
    """Return half the difference of the outputs with input j raised and lowered by weights."""
    fmu, held, runs = origin.fmu, origin.inputs, []
    for sign in (1.0, -1.0):
        origin.back()
        outputs = np.empty((len(weights), len(fmu.output_names)))
        inputs = held.copy()
        for k, weight in enumerate((sign * weights).tolist()):
            inputs[j] = held[j] + weight
            outputs[k] = fmu.step(inputs, dt)
        runs.append(outputs)
    with np.errstate(over="ignore", invalid="ignore"):
        found: FloatArray = 0.5 * (runs[0] - runs[1])
    if not np.isfinite(found).all():
        raise FmuError(
            f"the impulse response of {fmu.description.model_name} leaves the range of a double "
            f"within {len(weights)} steps: shorten the horizon"
        )
    return found


def _refuse_dead_zone(fmu: Fmu, j: int, larger: float, size: float) -> None:
    raise FmuError(
        f"the response of {fmu.description.model_name} to {fmu.input_names[j]!r} is not linear: an "
        f"impulse of {larger:g} moves its outputs and one of {size:g} does not (a limit, a dead "
        "zone or rounding to steps); step the FMU to a point where small changes act, or give an "
        "amplitude"
    )


def _input(fmu: Fmu, j: int) -> FmuVariable:
    inputs = fmu.description.of_causality("input")
    return next(variable for variable in inputs if fmu.input_names[j] in variable.labels)


def _room(variable: FmuVariable, present: float) -> float:
    """Return how far an input may go both ways; FmuError where it is at a bound already."""
    above = np.inf if variable.max is None else variable.max - present
    below = np.inf if variable.min is None else present - variable.min
    room = float(min(above, below))
    if not room > 0.0:
        raise FmuError(
            f"{variable.name!r} = {present!r} is at a bound ({variable.min} to {variable.max}): "
            "step the FMU with an input between them first"
        )
    return room
