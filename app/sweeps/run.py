"""The sweep itself: points worked through here, by processes, or by a Dask cluster."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...analysis.specification import FIGURES
from ..scenario import load_scenario, read_content
from .figures import Problem, check_figures
from .parameters import Parameter, parameters_of
from .progress import shown_progress
from .result import ScenarioSweep
from .sampling import Design, Point, points_of
from .store import NEEDS, Store

if TYPE_CHECKING:
    import xarray

_BATCHES = (4, 64)  # points that a worker takes at once, and that a kill may cost, by their count


class Stopped(RuntimeWarning):
    """A sweep was interrupted; what it returns has not all of its points."""


Row = tuple[tuple[float, ...], str]


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
        Gains that the file asks to be designed are designed once, for plant and delay in the file
        (and for whatever else of the controller is swept, such as its specification), as those
        of a drive that knows no better; False designs them anew at every point.
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
    if client is not None and not hasattr(client, "submit"):
        raise TypeError(
            f"client = {client!r}: expected a dask.distributed.Client, Client({client!r})"
        )
    path, known = Path(scenario), parameters_of(parameters)
    design, points = points_of(known, design, samples, seed)
    nominal = load_scenario(path)
    asked = check_figures(figures or [each.name for each in nominal.requirements])
    keys = tuple(parameter.key for parameter in known)
    problem = Problem(path, read_content(path), keys, asked, hold_gains)
    problem.scenario(points[0])  # a key that leads nowhere ends it here
    problem.refuse_missing(points[0])
    dataset = _empty(problem, known, points, nominal, {"design": design, "seed": seed})
    size = batch_of(len(points))
    store = Store(dataset, None if output is None else Path(output), size)
    todo = store.missing()
    rows = _rows(problem, points, list(_batches(todo, size)), workers, client)
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


def batch_of(points: int) -> int:
    """Return how many points are worked out together: enough for speed, few enough to share."""
    least, most = _BATCHES
    return max(least, min(most, points // 16))


def _batches(todo: Sequence[int], size: int) -> Iterator[range]:
    """Yield runs of consecutive points, none across the chunks that are written at once."""
    for _, run in groupby(enumerate(todo), lambda pair: (pair[1] - pair[0], pair[1] // size)):
        numbers = [number for _, number in run]
        yield range(numbers[0], numbers[-1] + 1)


def _rows(
    problem: Problem,
    points: Sequence[Point],
    batches: Sequence[range],
    workers: int | None,
    client: Any,
) -> Generator[tuple[int, list[Row]]]:
    """Yield what was found in each batch, in the order in which they are done."""
    given = [(batch.start, [points[k] for k in batch]) for batch in batches]
    if client is not None:
        yield from _by_cluster(problem, given, client)
        return
    count = workers_of(workers, len(given))
    if count == 1:
        yield from (_work(problem, *batch) for batch in given)
        return
    yield from _by_processes(problem, given, count)


def workers_of(workers: int | None, batches: int) -> int:
    """Return how many processes are of use."""
    if workers is not None and (type(workers) is not int or workers < 1):
        raise ValueError(f"workers = {workers!r}: expected a whole number from 1 on")
    return max(1, min(workers or os.cpu_count() or 1, batches))


def _work(problem: Problem, first: int, points: Sequence[Point]) -> tuple[int, list[Row]]:
    problem.prepare(points)
    return first, [problem.evaluate(point) for point in points]


def _by_processes(
    problem: Problem, given: Sequence[tuple[int, list[Point]]], count: int
) -> Iterator[tuple[int, list[Row]]]:
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(
        count,
        mp_context=get_context("spawn"),
        initializer=signal.signal,  # Ctrl-C is for the process that waits
        initargs=(signal.SIGINT, signal.SIG_IGN),
    )
    try:
        waiting = [pool.submit(_work_there, problem, *batch) for batch in given]
        for done in as_completed(waiting):
            yield done.result()
    except BrokenProcessPool:
        raise ChildProcessError(
            "a process of the sweep has died, as where memory runs out; the output keeps what is "
            "done: go on with the same call, and fewer workers"
        ) from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


_SENT: dict[str, Problem] = {}


def _work_there(problem: Problem, first: int, points: Sequence[Point]) -> tuple[int, list[Row]]:
    """Work in another process, which keeps the gains that it has designed for all its batches.

    The problem goes with every batch, not once to each worker: a worker may die or come late.
    """
    known = json.dumps([problem.content, problem.keys, problem.figures, problem.hold_gains])
    if known not in _SENT:
        _SENT.clear()
        _SENT[known] = problem
    return _work(_SENT[known], first, points)


def _by_cluster(
    problem: Problem, given: Sequence[tuple[int, list[Point]]], client: Any
) -> Iterator[tuple[int, list[Row]]]:
    from dask.distributed import as_completed

    work: Callable[..., Any] = _work_there
    waiting = [client.submit(work, problem, *batch, pure=False, retries=2) for batch in given]
    try:
        for done in as_completed(waiting):  # type: ignore[no-untyped-call]
            yield done.result()
            done.release()
    finally:
        client.cancel(waiting)
