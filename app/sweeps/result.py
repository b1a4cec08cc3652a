"""A sweep of a scenario file: its answers lead back to scenarios."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ...analysis.sweep_result import SweepResult
from ..overrides import override
from ..scenario import Scenario
from .figures import Problem
from .store import NEEDS, read

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Case:
    """One point of a sweep.

    Attributes
    ----------
    point : int
        Its number in the dataset.
    figures : mapping of str to float
        In the dataset's units.
    overrides : mapping of str to object
        What is put into the scenario file, held gains included: what `load_scenario` takes.
    """

    point: int
    figures: Mapping[str, float]
    overrides: Mapping[str, object]
    problem: Problem = field(repr=False)

    @property
    def scenario(self) -> Scenario:
        """The scenario of this point."""
        return self.problem.with_overrides(self.overrides)

    def save(self, path: str | Path) -> None:
        """Write the scenario to a file that gives these figures; FileExistsError if it is there."""
        import tomlkit

        document: Any = tomlkit.parse(tomlkit.dumps(self.problem.content))
        override(document, self.overrides)
        with Path(path).open("x", encoding="utf-8") as file:
            file.write(tomlkit.dumps(document))


class ScenarioSweep(SweepResult):
    """The sweep of a scenario file: `SweepResult` with the scenarios behind its points."""

    @classmethod
    def load(cls, path: str | Path) -> ScenarioSweep:
        """Return a sweep that was saved as ``….zarr`` or ``….nc``; ValueError for anything else."""
        path = Path(path)
        if path.suffix not in (".nc", ".zarr"):
            raise ValueError(f"{path}: expected a sweep, ….zarr or ….nc")
        try:
            return cls(read(path, "name the output of one"))
        except ImportError:
            raise ImportError(NEEDS) from None

    def worst(self, figure: str, side: Literal["lowest", "highest"] | None = None) -> Case:
        """Return the case in which a figure is worst; `SweepResult.worst_point` says of what."""
        return self.case(self.worst_point(figure, side))

    def case(self, point: int) -> Case:
        """Return one point with its scenario; ValueError for one that there is not."""
        count = self.dataset.sizes["point"]
        if isinstance(point, bool) or not isinstance(point, int | np.integer):
            raise ValueError(f"point = {point!r}: expected the number of a point, from 0 on")
        if not 0 <= point < count:
            raise ValueError(f"point = {point}: expected one of the {count}, 0 to {count - 1}")
        attributes = self.dataset.attrs
        problem = Problem(
            Path(attributes["scenario"]),
            json.loads(attributes["content"]),
            self.parameters,
            self.figures,
            bool(attributes["hold_gains"]),
        )
        values = [_as_given(self.dataset[name], point) for name in self.parameters]
        figures = {name: float(self.dataset[name].values[point]) for name in self.figures}
        return Case(int(point), figures, problem.overrides(values), problem)


def _as_given(column: xarray.DataArray, point: int) -> object:
    value, unit = column.values[point], column.attrs.get("units", "")
    if column.dtype.kind != "f":
        return str(value)
    return f"{float(value)!r} {unit}" if unit else float(value)
