"""The sweep itself: its points, who works them out, and what is kept of them."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...analysis.specification import FIGURES
from ..scenario import load_scenario, read_content
from ..units import show
from .figures import Problem, check_figures
from .parameters import Parameter, parameters_of
from .progress import shown_progress
from .result import ScenarioSweep
from .sampling import Design, Point, points_of
from .store import NEEDS, Store
from .workers import batch_of, batches_of, check_workers, rows_of

if TYPE_CHECKING:
    import xarray


class Stopped(RuntimeWarning):
    """A sweep was interrupted; what it returns has not all of its points."""


def sweep(
    scenario: str | Path,
    parameters: Mapping[str, object],
    *,
    figures: Sequence[str] | None = None,
    samples: int | None = None,
    design: Design | None = None,
    seed: int = 0,
    hold_gains: bool = True,
    output: str | Path | None = None,
    workers: int | None = None,
    client: Any = None,
    progress: bool | None = None,
) -> ScenarioSweep:
    """Return figures of a scenario at many values of its keys.

    Parameters
    ----------
    scenario : str or Path
        A scenario file.
    parameters : mapping of str to list or range
        Keys as `load_scenario`'s overrides have them; each with a list of values, or `Uniform`,
        `LogUniform` or `Normal`.
    figures : sequence of str, optional
        What is kept, by the names that `[requirements]` knows: ``"load_settling"``,
        ``"slew.peak_torque"``, ``"phase_margin"``. Of a figure that each move has, the worst
        counts. Default: those that the file requires. Only what is asked for is worked out.
    samples : int, optional
        How many points of ranges (or of lists, drawn from) are taken.
    design : str, optional
        "grid", every value of each list with every other; "corners", both ends of each;
        "sobol" or "latin-hypercube", points that fill the space; "sensitivity", samples·(d + 2)
        points for Sobol's indices of d parameters. Default: the grid where all are lists and no
        `samples` are given, else "sobol".
    seed : int, optional
        Of the sample: the same seed gives the same points.
    hold_gains : bool, optional
        A drive knows no better than the file: gains that it asks to be designed, feedforward,
        and shapers of modes are made for plant, modes and delay in the file (and for
        whatever else of the controller is swept, such as its specification), and held. False
        makes them anew at every point.
    output : path, optional
        A folder ``….zarr`` or a file ``….nc`` that the results are saved to as they come. A
        sweep that was stopped goes on where it was.
    workers : int, optional
        Processes; 1 is this one. Default: one for each processor. The numbers are the same.
    client : dask.distributed.Client, optional
        A cluster that does the work in their place.
    progress : bool, optional
        Whether rate and time left are shown. Default: on a terminal and in notebooks.

    Returns
    -------
    ScenarioSweep
        A labelled `dataset` with answers.

    Raises
    ------
    ScenarioError
        For a file, or a key, that cannot be used at all.
    ValueError, TypeError
        For parameters, figures or a design that do not fit.
    ImportError
        Without the extra ``jounce[sweep]``.

    Notes
    -----
    A point that cannot be surveyed, as its loop is unstable or its move cannot be planned, is
    recorded with its reason, and nan in its figures. Ctrl-C ends the sweep, not the script: what is
    done is returned, with a warning.
    """
    if not isinstance(hold_gains, bool):
        raise ValueError(f"hold_gains = {show(hold_gains)}: expected True or False")
    if client is not None and not hasattr(client, "submit"):
        raise TypeError(
            f"client = {client!r}: expected a dask.distributed.Client, Client({client!r})"
        )
    check_workers(workers)
    path, known = Path(scenario), parameters_of(parameters)
    design, points = points_of(known, design, samples, seed)
    nominal = load_scenario(path)
    asked = check_figures(
        [each.name for each in nominal.requirements] if figures is None else figures
    )
    keys = tuple(parameter.key for parameter in known)
    problem = Problem(path, read_content(path), keys, asked, hold_gains)
    problem.refuse_missing(problem.first_sound(points))
    dataset = _empty(problem, known, points, nominal, {"design": design, "seed": seed})
    size = batch_of(len(points))
    store = Store(dataset, None if output is None else Path(output), size)
    todo = store.missing()
    rows = rows_of(problem, points, list(batches_of(todo, size)), workers, client)
    done = len(points) - len(todo)
    with shown_progress(len(points), done, progress) as advance, closing(rows):
        try:
            for first, found in rows:
                store.write(first, found)
                done += len(found)
                advance(len(found))
        except KeyboardInterrupt:
            _tell_stopped(done, len(points), output)
            return ScenarioSweep(store.dataset)
    store.finish()
    return ScenarioSweep(store.dataset)


def _tell_stopped(done: int, points: int, output: str | Path | None) -> None:
    kept = "with output=… the next one would go on" if output is None else "the same call goes on"
    warnings.warn(f"stopped at {done} of {points} points; {kept}", Stopped, stacklevel=3)


def _empty(
    problem: Problem,
    parameters: Sequence[Parameter],
    points: Sequence[Point],
    nominal: Any,
    asked: Mapping[str, object],
) -> xarray.Dataset:
    """Return the dataset of a sweep of which nothing is done yet."""
    try:
        import xarray
        import zarr  # noqa: F401 (else it fails after the work)
    except ImportError:
        raise ImportError(NEEDS) from None
    count, labels = len(points), nominal.labels
    columns = {
        parameter.key: (
            "point",
            np.array([parameter.number(point[k]) for point in points]),
            {"units": parameter.unit},
        )
        for k, parameter in enumerate(parameters)
    }
    values: dict[str, Any] = {
        name: ("point", np.full(count, np.nan), {"units": _unit(labels, name)})
        for name in problem.figures
    }
    values["failure"] = "point", np.full(count, "", dtype=object)
    values["done"] = "point", np.zeros(count, dtype=bool)
    bounds = {each.name: _bounds(each, labels) for each in nominal.requirements}
    attributes = {
        "title": nominal.title,
        "scenario": str(problem.path),
        "content": json.dumps(problem.content),
        "parameters": list(columns),
        "figures": list(problem.figures),
        "hold_gains": int(problem.hold_gains),
        "design": str(asked["design"]),
        "requirements": json.dumps({k: v for k, v in bounds.items() if k in problem.figures}),
        "sweep": _identity(problem, points),
    }
    return xarray.Dataset(values, coords=columns, attrs=attributes)


def _unit(labels: Any, figure: str) -> str:
    return str(labels.unit_of(FIGURES[figure.rpartition(".")[2]])[0])


def _bounds(requirement: Any, labels: Any) -> list[float]:
    scale = labels.unit_of(requirement.unit)[1]
    return [side / scale for side in requirement.bounds]


def _identity(problem: Problem, points: Sequence[Point]) -> str:
    """Return what makes a sweep the same one, by parts."""
    parts = {
        "scenario": json.dumps(problem.content),
        "figures": problem.figures,
        "points": (problem.keys, points),
        "gains": problem.hold_gains,
    }
    digests = {k: hashlib.sha256(repr(v).encode()).hexdigest()[:16] for k, v in parts.items()}
    return json.dumps(digests)
