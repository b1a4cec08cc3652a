"""Knife edges of a run: where its outcome hangs on the last digits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..shaping.pieces import FloatArray
from .run import Run

_NEAR = 1e-9  # of the stiction, or of an encoder's step
_JUMPED = 1e-6  # of the stiction: less than that before a breakaway is no jump
_ROUNDING = 1e-15  # of a position


def knife_edges(run: Run) -> Iterator[str]:
    """Yield a sentence on each kind of knife edge that a run has met.

    A motor that sticks, or has just broken away by a jump of the torque, within 1e-9 of the
    stiction; a sample within 1e-9 of a step from the middle between two of the encoder's steps.
    """
    found = np.sort(np.concatenate([_held(run), _torn(run)]))
    if found.size:
        yield (
            f"Knife edge at {found[0]:.6g} s: the torque to be held is the stiction, up to "
            "rounding. Whether the motor breaks away hangs on the last digits; vary the stiction "
            "a little to see both."
        )
    between = _between_steps(run)
    if between.size:
        yield (
            f"Knife edge at {between[0]:.6g} s: a sample is in the middle between two of the "
            "encoder's steps, up to rounding. Which one it becomes hangs on the last digits; move "
            "the start a little to see both."
        )


def _held(run: Run) -> FloatArray:
    """Return the times at which the motor sticks on the edge."""
    friction = run.scene.axis.friction
    if friction is None or not friction.holds:
        return np.empty(0)
    sticks = np.array([mode.friction == 0 for mode in run.hybrid.modes])[run.modes]
    push = np.abs(np.sum(run.hybrid.pushing[run.modes] * run.states, axis=1))
    near = sticks & (np.abs(push - friction.holds) <= _NEAR * friction.holds)
    return np.asarray(run.scene.begin + run.times[near])


def _torn(run: Run) -> FloatArray:
    """Return the times at which a jump of the torque has just been enough to break away."""
    friction = run.scene.axis.friction
    if friction is None or not friction.holds:
        return np.empty(0)
    kinds = np.array([mode.friction for mode in run.hybrid.modes])[run.modes]
    away = 1 + np.flatnonzero((kinds[:-1] == 0) & (kinds[1:] != 0))
    after = np.abs(np.sum(run.hybrid.pushing[run.modes[away]] * run.states[away], axis=1))
    away = away[np.abs(after - friction.holds) <= _NEAR * friction.holds]
    modes, states = run.modes[away - 1], run.states[away - 1].copy()
    run.advance(states, modes, run.times[away] - run.times[away - 1])
    before = np.abs(np.sum(run.hybrid.pushing[modes] * states, axis=1))
    away = away[before < (1.0 - _JUMPED) * friction.holds]
    return np.asarray(run.scene.begin + run.times[away])


def _between_steps(run: Run) -> FloatArray:
    """Return the times of samples in the middle between two steps of the encoder."""
    scene, step = run.scene, run.scene.axis.encoder_step
    dt = scene.controller.sample_time
    if not step or dt is None or scene.noise is not None:
        return np.empty(0)
    times: FloatArray = np.asarray(dt * np.arange(len(run.samples)))
    seen = run.at(times)[1] @ run.seen_row
    off = np.abs(seen / step - np.floor(seen / step) - 0.5)
    near = off <= np.maximum(_NEAR, _ROUNDING * np.abs(seen) / step)
    return np.asarray(scene.begin + times[near])
