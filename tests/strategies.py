"""Hypothesis strategies: limits, and problems as plain numbers that can be pasted and re-run."""

from __future__ import annotations

from math import factorial

import numpy as np
from hypothesis import strategies as st

from jounce.shaping import Limits, Trajectory

MAGNITUDES = st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent)
UNIT_FACTORS = st.sampled_from([1e-6, 1e-3, 1.0, 1e3, 1e6])


@st.composite
def bound_lists(draw, min_order: int = 1, max_order: int = 6) -> list[float | None]:
    """Draw bounds for a unit distance, velocity first: any subset, the last one present.

    They lie around those of the perfect spline in unit time, so that all of them matter.
    """
    order = draw(st.integers(min_order, max_order))
    bounds: list[float | None] = []
    for k in range(1, order + 1):
        if k < order and draw(st.booleans()):
            bounds.append(None)
        else:
            typical = 4.0 ** (k - 1) * factorial(k - 1)
            bounds.append(typical * 10.0 ** draw(st.floats(-1.0, 1.5)))
    return bounds


@st.composite
def bound_pairs(draw, min_order: int = 1, max_order: int = 3) -> list[tuple[float, float] | None]:
    """Draw bounds that differ between the directions by up to a factor of 16."""
    symmetric = draw(bound_lists(min_order, max_order))
    skews = st.floats(0.25, 4.0)
    return [b and (-b * draw(skews), b * draw(skews)) for b in symmetric]


@st.composite
def any_limits(draw) -> Limits:
    """Draw limits of order 1 to 9 with numbers, pairs, one-sided pairs and gaps."""
    sides = st.floats(1e-300, 1e300)
    one_sided = sides.map(lambda side: (-np.inf, side)) | sides.map(lambda side: (-side, np.inf))
    pairs = st.tuples(sides.map(lambda side: -side), sides)
    bound = st.none() | sides | pairs | one_sided
    highest = sides | pairs | one_sided
    return Limits.from_bounds([*draw(st.lists(bound, max_size=8)), draw(highest)])


def any_trajectory(seed: int, order: int, pieces: int = 5, start: float = -0.7) -> Trajectory:
    """Return random pieces that jump in every derivative, position included."""
    rng = np.random.default_rng(seed)
    breaks = start + np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.5, pieces))])
    return Trajectory(breaks, rng.normal(size=(pieces, order + 1)))


def smooth_trajectory(seed: int, order: int, pieces: int = 5, start: float = -0.7) -> Trajectory:
    """Return random pieces continuous in every derivative below the highest, moving at both ends.

    Integrated here with numpy's polynomials.
    """
    rng = np.random.default_rng(seed)
    durations = rng.uniform(0.2, 1.5, pieces)
    state, states = rng.normal(size=order + 1), []
    for duration in durations:
        state[-1] = rng.normal()
        states.append(state.copy())
        piece = np.polynomial.Polynomial([x / factorial(j) for j, x in enumerate(state)])
        state = np.array([piece.deriv(k)(duration) if k else piece(duration)
                          for k in range(order + 1)])  # fmt: skip
    breaks = start + np.concatenate([[0.0], np.cumsum(durations)])
    return Trajectory(breaks, states)
