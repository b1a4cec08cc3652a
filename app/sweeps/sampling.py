"""The points of a sweep: full grids, corners, and samples that fill the space."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Sequence
from math import prod
from typing import Any, Literal, get_args

import numpy as np

from ...shaping.pieces import FloatArray
from ..units import show
from .parameters import Parameter

Design = Literal["grid", "corners", "sobol", "latin-hypercube", "sensitivity"]
"""How the points of a sweep are chosen."""

MOST_POINTS = 10_000_000

Point = tuple[object, ...]


def points_of(
    parameters: Sequence[Parameter], design: Design | None, samples: int | None, seed: int
) -> tuple[Design, list[Point]]:
    """Return the points of a sweep, each the values of all parameters, and how they were chosen.

    Without a design it is the full grid where every parameter is a list, else Sobol's sequence.

    Raises
    ------
    ValueError
        For a design that there is not, ranges in a grid, samples of a grid or none of a
        sequence, more corners or points than can be worked through.
    """
    lists = all(parameter.range is None for parameter in parameters)
    design = design or ("grid" if lists and samples is None else "sobol")
    if design not in get_args(Design):
        raise ValueError(
            f"design = {show(design)}: expected {', '.join(map(repr, get_args(Design)))}"
        )
    if design in ("grid", "corners"):
        return design, _product(parameters, design, samples)
    _check_samples(design, samples)
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise ValueError(
            f"seed = {show(seed)}: expected a whole number from 0 on, by which the points are the "
            "same each time"
        )
    assert samples is not None
    fractions = _FRACTIONS[design](len(parameters), samples, seed)
    _check_count(len(fractions))
    return design, [
        tuple(parameter.at(float(f)) for parameter, f in zip(parameters, row, strict=True))
        for row in fractions
    ]


def _product(parameters: Sequence[Parameter], design: Design, samples: int | None) -> list[Point]:
    if samples is not None:
        raise ValueError(
            f"samples = {samples!r}: design = {design!r} has points of its own; leave samples out, "
            "or give design='sobol'"
        )
    for parameter in parameters:
        if design == "grid" and parameter.range is not None:
            raise ValueError(
                f"parameter {parameter.key} is a range, which has no grid: give a list of values, "
                "or samples=… for a sample of all"
            )
    values = [p.choices if design == "grid" else p.ends for p in parameters]
    _check_count(prod(len(each) for each in values))
    return list(itertools.product(*values))


def _check_samples(design: str, samples: Any) -> None:
    if not isinstance(samples, int) or isinstance(samples, bool) or samples < 1:
        raise ValueError(
            f"samples = {show(samples)}: expected how many points, a whole number from 1 on, such "
            "as samples=1024"
        )
    if design == "sensitivity" and samples & (samples - 1):
        raise ValueError(
            f"samples = {samples}: Sobol's indices need a power of two, such as "
            f"{1 << samples.bit_length()}"
        )


def _check_count(count: int) -> None:
    if count > MOST_POINTS:
        raise ValueError(
            f"{count} points are more than {MOST_POINTS}: give shorter lists, or samples=… of all"
        )


def _sobol(dimensions: int, samples: int, seed: int) -> FloatArray:
    from scipy.stats import qmc

    with warnings.catch_warnings():  # it warns where `samples` is no power of two
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(samples))


def _latin(dimensions: int, samples: int, seed: int) -> FloatArray:
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed))
    return np.asarray(sampler.random(samples))


def _sensitivity(dimensions: int, samples: int, seed: int) -> FloatArray:
    """Return A, B, and A with each column of B in turn: what Sobol's indices are made of."""
    both = _sobol(2 * dimensions, samples, seed)
    a, b = both[:, :dimensions], both[:, dimensions:]
    mixed = [np.where(np.arange(dimensions) == k, b, a) for k in range(dimensions)]
    return np.concatenate([a, b, *mixed])


_FRACTIONS = {"sobol": _sobol, "latin-hypercube": _latin, "sensitivity": _sensitivity}
