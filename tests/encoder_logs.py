"""Logs of encoders, of moves that are known."""

import numpy as np

from jounce.shaping import Limits, min_time_move

NOISES = {
    "fine noise": (1e-6, 0.0),
    "noise": (1e-4, 0.0),
    "coarse noise": (1e-3, 0.0),
    "fine counts": (0.0, 1e-4),
    "counts": (0.0, 1e-3),
    "noisy counts": (1e-3, 1e-3),
}
NONE = Limits(velocity=1.0)


def random_move(order, seed):
    rng = np.random.default_rng((order, seed))
    bounds = [10.0 ** rng.uniform(0.0, 0.7 * k) for k in range(1, order + 1)]
    return min_time_move(1.0, Limits.from_bounds(bounds), method="closed-form")


def encoder_log(move, seed, kind, count=800):
    """Return a log with rests, evenly spaced or not, and its resolution."""
    rng = np.random.default_rng(seed)
    noise, counts = NOISES[kind]
    rest = (0.02, 0.2, 1.0)[seed % 3] * move.duration
    times = np.linspace(-rest, move.duration + rest, count)
    if seed % 2:
        times = np.sort(rng.uniform(-rest, move.duration + rest, count))
    positions = move(times) + noise * rng.standard_normal(count)
    if counts:
        positions = counts * np.round(positions / counts + rng.uniform())
    return times, positions, counts or None
