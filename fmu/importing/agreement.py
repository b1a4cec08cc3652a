"""Whether an FMU answers the same while a snapshot of it is kept as it does without one."""

from __future__ import annotations

import warnings
from contextlib import suppress

import numpy as np

from ...shaping.pieces import FloatArray
from .description import FmuError, FmuVariable
from .rewindable import Rewindable

CONTINUOUS = ("Real", "Float64", "Float32")
"""Types of variables that have derivatives."""

_ALIKE = 1e-6  # of the largest deviation from the start
_ROUNDING = 1e-12


def answers_alike(fmu: Rewindable, dt: float, steps: int) -> bool:
    """Return whether an FMU answers with a snapshot alive as it does without.

    While one is, FMI's noSetFMUStatePriorToCurrentPoint is False, and an FMU may hold back what it
    cannot undo. A twin of the FMU, at its start, is run with a snapshot, brought back, and run
    without, both times with the same random inputs. A warning where no twin can be made.
    """
    try:
        with fmu.twin() as twin:
            inputs = _inputs(twin, steps)
            state, first = twin.get_state(), twin.outputs.astype(float)
            kept = _run(twin, inputs, dt) - first
            twin.set_state(state)
            del state
            free = _run(twin, inputs, dt) - first
    except FmuError as error:
        warnings.warn(
            f"{fmu.description.model_name}: whether it answers the same when it is brought back "
            f"could not be checked, for a second instance failed ({error})",
            stacklevel=3,
        )
        return True
    with np.errstate(invalid="ignore", over="ignore"):
        scale = _ALIKE * np.abs(free).max(axis=0, initial=0.0) + _ROUNDING * np.abs(first)
        alike = np.abs(kept - free) <= scale
    same = (kept == free) | (np.isnan(kept) & np.isnan(free))
    return bool((alike | same).all())


def _run(fmu: Rewindable, inputs: FloatArray, dt: float) -> FloatArray:
    """Return the outputs after each step, nan from where the FMU goes no further."""
    rows = np.full((len(inputs), len(fmu.output_names)), np.nan)
    with suppress(FmuError):
        for row, given in zip(rows, inputs, strict=True):
            row[:] = fmu.step(given, dt)
    return rows


def _inputs(fmu: Rewindable, steps: int) -> FloatArray:
    """Return random inputs about the present ones, within their bounds."""
    known = {label: v for v in fmu.description.of_causality("input") for label in v.labels}
    rows = np.random.default_rng(0).choice([-1.0, 1.0], (steps, len(fmu.input_names)))
    for column, name, held in zip(rows.T, fmu.input_names, fmu.inputs.tolist(), strict=True):
        column[:] = _varied(known[name], float(held), column)
    return rows


def _varied(variable: FmuVariable, held: float, signs: FloatArray) -> FloatArray:
    if variable.type not in CONTINUOUS:
        return np.full(len(signs), held)
    low = -np.inf if variable.min is None else variable.min
    high = np.inf if variable.max is None else variable.max
    found: FloatArray = np.clip(held + abs(variable.nominal or 1.0) * signs, low, high)
    return found
