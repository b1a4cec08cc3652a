"""What a sweep found: worst points, yield, which parameter matters, trade-offs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, nan
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..shaping.checks import one_of
from ..shaping.drawing import draw
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.told import table
from .specification import HIGHER_IS_BETTER

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

_CONFIDENCE = 0.95
_BINS = 5  # of a parameter, whose means of a figure are compared


@dataclass(frozen=True)
class Yield(Frozen):
    """How many points meet what is required.

    Attributes
    ----------
    met, points : int
        Points that failed count as not met.
    low, high : float
        95 % confidence interval of the fraction (Wilson), of a random sample; of a grid, which
        is no sample of anything, nan.
    """

    met: int
    points: int
    low: float
    high: float

    @property
    def fraction(self) -> float:
        """The part of the points that meets all."""
        return self.met / self.points

    def __str__(self) -> str:
        verb = "meets" if self.points == 1 else "meet"
        told = f"{self.met} of {points_told(self.points)} {verb} what is required "
        told += f"({self.fraction:.2%}"
        if np.isnan(self.low):
            return f"{told})"
        return f"{told}; 95 % confidence: {self.low:.2%} to {self.high:.2%})"


@dataclass(frozen=True)
class Influence(Frozen):
    """How much of a figure's variance a parameter explains, with all others varying.

    Attributes
    ----------
    first : float
        Sobol's first-order index: by the parameter alone.
    total : float
        With all that it does together with others.
    """

    first: float
    total: float


class SweepResult:
    """The points of a sweep as a labelled dataset, and answers.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over the dimension `point`: parameters as coordinates, figures as variables, each with
        `units`; `failure`, why a point has no figures; `done`.
    """

    def __init__(self, dataset: xarray.Dataset) -> None:
        self.dataset = dataset

    @property
    def parameters(self) -> tuple[str, ...]:
        """The keys that vary."""
        return tuple(np.atleast_1d(self.dataset.attrs["parameters"]).tolist())

    @property
    def figures(self) -> tuple[str, ...]:
        """The names of the figures."""
        return tuple(np.atleast_1d(self.dataset.attrs["figures"]).tolist())

    @property
    def requirements(self) -> Mapping[str, tuple[float, float]]:
        """Bounds on figures, in their units."""
        known = json.loads(self.dataset.attrs.get("requirements", "{}"))
        return {name: (low, high) for name, (low, high) in known.items()}

    @property
    def is_whole(self) -> bool:
        """Whether all points are done."""
        return bool(self.dataset["done"].values.all())

    def failures(self) -> dict[int, str]:
        """Return the points that could not be surveyed, each with its reason."""
        reasons = self.dataset["failure"].values
        return {int(i): str(reasons[i]) for i in np.flatnonzero(reasons != "")}

    def values(self, figure: str) -> FloatArray:
        """Return a figure at all points; ValueError for one that was not kept."""
        if figure not in self.figures:
            raise ValueError(
                f"figure {figure!r} was not kept: expected one of {', '.join(self.figures)}; "
                "sweep again with figures=[…]"
            )
        return np.asarray(self.dataset[figure].values, dtype=float)

    def has(self, figure: str) -> bool:
        """Whether any point has a figure."""
        return not np.isnan(self.values(figure)).all()

    def worst_point(self, figure: str, side: Literal["lowest", "highest"] | None = None) -> int:
        """Return the number of the point at which a figure is worst.

        Parameters
        ----------
        figure : str
        side : {"lowest", "highest"}, optional
            Default: the lowest of margins, the highest of everything else.

        Raises
        ------
        ValueError
            For a figure that was not kept, or that no point has.
        """
        values = self.values(figure)
        if side is not None:
            one_of("side", side, ("lowest", "highest"))
        if not self.has(figure):
            raise ValueError(f"figure {figure!r}: no point has one; see .failures()")
        lowest = is_worse_lower(figure) if side is None else side == "lowest"
        return int(np.nanargmin(values) if lowest else np.nanargmax(values))

    def met(
        self, requirements: Mapping[str, tuple[float | None, float | None]] | None = None
    ) -> Yield:
        """Return how many of the points done meet the requirements; one that failed does not.

        Parameters
        ----------
        requirements : mapping of str to (float, float), optional
            Least and greatest value of each figure, in the dataset's units; None where there is
            no bound. Default: the scenario's.

        Raises
        ------
        ValueError
            Where there is none, for a figure that was not kept, bounds that are no two numbers, or
            before a point is done.
        """
        bounds = self.requirements if requirements is None else requirements
        if not bounds:
            raise ValueError(
                "nothing is required of the figures kept: give requirements={'load_settling': "
                "(0.0, 2.0)}, or [requirements] in the scenario"
            )
        done = np.asarray(self.dataset["done"].values, dtype=bool)
        if not done.any():
            raise ValueError("no point is done yet: run the sweep again, it goes on")
        good = done.copy()
        for figure, both in bounds.items():
            values, (low, high) = self.values(figure), _bounds(figure, both)
            good &= (values >= low) & (values <= high)
        return Yield(int(good.sum()), int(done.sum()), *self._interval(good, done))

    def _interval(self, good: Any, done: Any) -> tuple[float, float]:
        """Return the interval by the points that are independent of each other."""
        design = self.dataset.attrs["design"]
        if design == "sensitivity":
            independent = 2 * (done.size // (len(self.parameters) + 2))
            good, done = good[:independent], done[:independent]
        if design in ("grid", "corners") or not done.any():
            return nan, nan
        from scipy.stats import binomtest

        counted = binomtest(int(good.sum()), int(done.sum()))
        found = counted.proportion_ci(_CONFIDENCE, method="wilson")
        return float(found.low), float(found.high)

    def influences(self, figure: str) -> dict[str, Influence]:
        """Return which parameter matters: Sobol's indices of a figure.

        Raises
        ------
        ValueError
            For another design than "sensitivity", or where a point failed or is infinite.

        References
        ----------
        Saltelli et al., "Variance based sensitivity analysis of model output", 2010.
        """
        if self.dataset.attrs["design"] != "sensitivity":
            raise ValueError(
                f"design = {self.dataset.attrs['design']!r}: Sobol's indices need the points of "
                "sweep(…, design='sensitivity', samples=1024)"
            )
        from scipy.stats import sobol_indices

        values = self.values(figure)
        missing = int((~np.isfinite(values)).sum())
        if missing:
            raise ValueError(
                f"figure {figure!r} is missing or infinite at {missing} points: narrow the ranges "
                "to where every loop is stable and has one; see .failures()"
            )
        count = len(self.parameters)
        a, b, *mixed = np.split(values, count + 2)
        parts: Any = {"f_A": a[None], "f_B": b[None], "f_AB": np.array(mixed)[:, None]}
        found = sobol_indices(func=parts, n=len(a))
        first, total = np.ravel(found.first_order), np.ravel(found.total_order)
        return {
            name: Influence(float(first[k]), float(total[k]))
            for k, name in enumerate(self.parameters)
        }

    def swings(self, figure: str) -> dict[str, tuple[float, float]]:
        """Return the lowest and the highest mean of a figure over each parameter, the most first.

        Not the figure's own range with one parameter moved and all others held, as in the tornado
        of a textbook, but that of its conditional means: over the points at each value of a list,
        or in each fifth of a range, with all others varying. A parameter that acts only together
        with others, or up as much as down, moves no mean: Sobol's total index shows it
        (`influences`). Points that failed count in none.
        """
        values, found = self.values(figure), {}
        for name in self.parameters:
            means = [float(np.nanmean(values[k])) for k in self._groups(name, values)]
            found[name] = (min(means, default=nan), max(means, default=nan))
        return dict(sorted(found.items(), key=lambda item: item[1][0] - item[1][1]))

    def _groups(self, name: str, values: FloatArray) -> list[Any]:
        column = self.dataset[name].values
        kinds = np.unique(column)
        if len(kinds) > 2 * _BINS and column.dtype.kind == "f":
            edges = np.quantile(column, np.linspace(0.0, 1.0, _BINS + 1)[1:-1])
            column = np.searchsorted(edges, column)
            kinds = np.unique(column)
        known = ~np.isnan(values)
        groups = [(column == kind) & known for kind in kinds]
        return [group for group in groups if group.any()]

    def pareto(self, first: str, second: str) -> xarray.Dataset:
        """Return the points of which no other is better in both figures, by the first.

        Better is higher for margins, lower for everything else.
        """
        x, y = (
            np.where(is_worse_lower(name), -1.0, 1.0) * self.values(name)
            for name in (first, second)
        )
        order = np.lexsort((y, x))
        order = order[~(np.isnan(x) | np.isnan(y))[order]]
        best = np.minimum.accumulate(y[order]) if order.size else y[order]
        ahead = np.concatenate([[True], y[order][1:] < best[:-1]]) if order.size else order
        return self.dataset.isel(point=order[ahead.astype(bool)])

    def plot(self, figure: str | None = None) -> Figure:
        """Draw a figure (default: the first): histogram with its limits, and what it depends on."""
        drawn: Figure = draw(self) if figure is None else draw(self.of(figure))
        return drawn

    def of(self, figure: str) -> SweepResult:
        """Return the same sweep with this figure first."""
        self.values(figure)
        others = [name for name in self.figures if name != figure]
        dataset = self.dataset.assign_attrs(figures=[figure, *others])
        return SweepResult(dataset)

    def _repr_html_(self) -> str:
        """Return points, yield, and of each figure the median and the worst, with where that is."""
        done = int(np.asarray(self.dataset["done"].values).sum())
        rows = [("points", f"{done} of {self.dataset.sizes['point']}")]
        if self.failures():
            rows.append(("failed", str(len(self.failures()))))
        if self.requirements and done:
            rows.append(("yield", str(self.met())))
        rows += [(figure, self._summary(figure)) for figure in self.figures]
        return table(str(self.dataset.attrs.get("title", "sweep")), rows)

    def _summary(self, figure: str) -> str:
        if not self.has(figure):
            return "none"
        values, worst = self.values(figure), self.worst_point(figure)
        unit = self.dataset[figure].attrs.get("units", "")
        median, most = (f"{x:.5g} {unit}".strip() for x in (np.nanmedian(values), values[worst]))
        return f"median {median}, worst {most} at {self.told_at(worst)}"

    def told_at(self, point: int) -> str:
        """Return the parameters of a point as text, rounded: ``key = value unit, …``."""
        return ", ".join(f"{key} = {self._at(key, point)}" for key in self.parameters)

    def _at(self, parameter: str, point: int) -> str:
        column = self.dataset[parameter]
        value, unit = column.values[point], column.attrs.get("units", "")
        return f"{value:.5g} {unit}".strip() if column.dtype.kind == "f" else str(value)

    def __repr__(self) -> str:
        done = int(np.asarray(self.dataset["done"].values).sum())
        return (
            f"{type(self).__name__}({done} of {points_told(self.dataset.sizes['point'])}, "
            f"parameters {', '.join(self.parameters)}; figures {', '.join(self.figures)})"
        )


def _bounds(figure: str, given: Any) -> tuple[float, float]:
    """Return least and greatest value of a figure; ValueError for what is no such pair."""
    try:
        least, greatest = given
        low = -inf if least is None else float(least)
        high = inf if greatest is None else float(greatest)
    except (TypeError, ValueError):
        low = high = nan
    if not low <= high:
        raise ValueError(
            f"requirements[{figure!r}] = {given!r}: expected least and greatest value, increasing, "
            "such as (44.0, None)"
        )
    return low, high


def points_told(count: int) -> str:
    """Return how many points there are in words."""
    return f"{count} point" if count == 1 else f"{count} points"


def is_worse_lower(figure: str) -> bool:
    """Whether a figure gets worse as it falls."""
    return figure.rpartition(".")[2] in HIGHER_IS_BETTER
