"""The gate of a sweep: its yield and its worst cases beside their baseline and bounds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...analysis.sweep_result import SweepResult, is_worse_lower
from ..scenario import Scenario, load_scenario
from ..sweeps.run import sweep
from ..sweeps.sweep_file import read_sweep_file, told_by
from .baseline import Baseline, check_origin, in_unit, load_baseline, stored_conditions
from .check import (
    baseline_beside,
    checks_beside,
    missing_baseline,
    refuse_bounded_positions,
    there,
)
from .check_file import Checks, load_checks
from .comparison import compare, measured_baseline
from .conditions import Change, Conditions, changes, scenario_conditions
from .numbers import WORST, Better, Key, Number
from .report import GateReport

_EITHER = ("crossover", "bandwidth")  # have no better side


def check_sweep(
    scenario: str | Path,
    sweep_file: str | Path,
    *,
    baseline: str | Path | None = None,
    checks: str | Path | None = None,
    update: bool = False,
    workers: int | None = None,
) -> GateReport:
    """Judge the yield and the worst cases of a sweep by a check file and a baseline.

    Parameters
    ----------
    scenario : str or Path
        A scenario file.
    sweep_file : str or Path
        What varies, as `jounce sweep` reads it.
    baseline, checks : str or Path, optional
        As in `check_scenario`; default: ``<sweep file>.baseline.json`` and ``….check.toml``
        beside the sweep file, their names without its ``.toml``.
    update : bool, optional
        As in `check_scenario`.
    workers : int, optional
        As in `sweep`; the numbers are the same.

    Returns
    -------
    GateReport
        Of ``sweep.yield_percent``, the part of all points that meets the scenario's requirements
        (where it has any of the figures kept), ``sweep.failed_points``, and ``worst.FIGURE`` of
        each figure. What varies, and how it is sampled, are conditions that must be as stored.

    Raises
    ------
    ScenarioError, CheckError, ValueError
        As `check_scenario` and `sweep` do.
    """
    path, loaded = Path(sweep_file), load_scenario(scenario)
    asked = read_sweep_file(path)
    title, unit = f"{loaded.title}, swept by {path.stem}", loaded.position_unit
    stored_at = there(baseline, baseline_beside(path), missing_is_fine=update)
    checks_at = there(checks, checks_beside(path))
    missing = missing_baseline(path, stored_at, checks_at, update=update)
    stored = Baseline(title, unit, {}) if update else None
    if stored_at is not None:
        before = load_baseline(stored_at)
        stored = in_unit(before, unit)
        check_origin(stored, stored_at, title, unit)
    with told_by(path):
        found = sweep(scenario, **asked, workers=workers)
    numbers, now = tuple(_numbers(found)), _conditions(loaded, asked, found)
    written = Checks() if checks_at is None else load_checks(checks_at, numbers)
    changed: tuple[Change, ...] = ()
    if stored is not None and stored_at is not None:
        if before.position_unit != unit and not update:
            refuse_bounded_positions(written, checks_at, loaded, before.position_unit)
        changed = changes(stored_conditions(stored, stored_at), now)
    measured = measured_baseline(
        numbers, stored, written, scenario=title, position_unit=unit, conditions=now
    )
    rows = compare(numbers, stored, written)
    report = GateReport(title, path, unit, rows, measured=measured, update=update)
    return replace(report, changes=changed, missing=missing)


def _numbers(found: SweepResult) -> Iterator[Number]:
    """Yield what is compared; a figure that no point has is left out, and then gone."""
    yield Number(("sweep", "failed_points"), float(len(found.failures())), "lower")
    if found.requirements:
        yield Number(("sweep", "yield_percent"), 100.0 * found.met().fraction, "higher")
    for figure in found.figures:
        if found.has(figure):
            worst = float(found.values(figure)[found.worst_point(figure)])
            yield Number((WORST, figure), worst, _better(figure))


def _better(figure: str) -> Better:
    if figure.rpartition(".")[2] in _EITHER:
        return None
    return "higher" if is_worse_lower(figure) else "lower"


def _conditions(scenario: Scenario, asked: Mapping[str, Any], found: SweepResult) -> Conditions:
    """Return what the numbers depend on: the scenario, what varies, and the sample."""
    told = {
        "points": str(found.dataset.sizes["point"]),
        "design": str(found.dataset.attrs["design"]),
        "seed": str(asked.get("seed", 0)),
        "hold_gains": str(bool(asked.get("hold_gains", True))),
    }
    sampled: dict[Key, str] = {("sweep", name): text for name, text in told.items()}
    sampled |= {("parameters", key): str(value) for key, value in asked["parameters"].items()}
    return {**scenario_conditions(scenario), **sampled}
