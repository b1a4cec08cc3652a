"""The command `jounce sweep`: a scenario at many values of what is not known."""

from __future__ import annotations

import sys
import warnings
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from . import cli
from .common_options import QUIET, SCENARIO
from .exit_status import INTERRUPTED
from .printing import print_parts
from .units import show

if TYPE_CHECKING:
    from rich.table import Table

    from ..analysis.sweep_result import Influence
    from .sweeps.result import ScenarioSweep


def sweep_command(
    scenario: SCENARIO,
    sweep_file: Annotated[
        Path, cli.Argument(help="What varies, how it is sampled, what is kept (TOML).")
    ],
    output: Annotated[
        Path,
        cli.Option(
            "--output",
            "-o",
            help="Folder; a sweep that was stopped goes on, pictures are replaced.",
        ),
    ],
    workers: Annotated[int | None, cli.Option(help="Processes. Default: all processors.")] = None,
    scheduler: Annotated[
        str | None, cli.Option(help="A Dask cluster, such as tcp://10.0.0.1:8786.")
    ] = None,
    as_json: Annotated[bool, cli.Option("--json", help="Print the answers as JSON.")] = False,
    _: QUIET = False,
) -> None:
    """Sweep a scenario: figures at many values of its keys, worst cases, yield, influences.

    The folder has `sweep.zarr`, the dataset; `worst_….toml`, a scenario for each figure that
    reproduces its worst value; pictures of each figure (histogram, tornado, scatter, contours) and
    `scatter_matrix.png`.
    """
    from .scenario import load_scenario
    from .sweeps.run import Stopped, sweep
    from .sweeps.sweep_file import read_sweep_file, told_by

    if scheduler is not None and workers is not None:
        raise ValueError("--workers beside --scheduler: a cluster has its own; leave one out")
    if workers is not None and workers < 1:
        raise ValueError(f"--workers {workers}: expected a whole number from 1 on")
    asked = read_sweep_file(sweep_file)
    load_scenario(scenario)  # whose own faults are not the sweep file's
    client = _client(scheduler)
    try:
        with told_by(sweep_file, output), warnings.catch_warnings():
            warnings.simplefilter("ignore", Stopped)
            found = sweep(
                scenario, **asked, output=output / "sweep.zarr", workers=workers, client=client
            )
    finally:
        if client is not None:
            client.close()
    if not found.is_whole:
        print(f"jounce: stopped: {found!r}; the same command goes on", file=sys.stderr)
        raise SystemExit(INTERRUPTED)
    files = _write(found, output)
    if as_json:
        from .json_output import print_json

        print_json(_answers(found))
        return
    print_parts(*_told(found), f"Wrote {', '.join(sorted(files))} to {output}")


def _client(scheduler: str | None) -> Any:
    if scheduler is None:
        return None
    try:
        from dask.distributed import Client
    except ImportError:
        from .sweeps.store import NEEDS

        raise ValueError(NEEDS) from None
    try:
        # Else one that finds nobody stays what dask works by.
        client: Any = Client(scheduler, timeout="10s", set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:  # the latter of what is no address
        raise ValueError(
            f"--scheduler {show(scheduler)}: nobody answers there ({error}); give the address that "
            "the cluster's scheduler tells, such as tcp://10.0.0.1:8786"
        ) from None
    if not client.scheduler_info()["workers"]:
        warnings.warn(
            f"--scheduler {scheduler}: has no workers yet; the sweep waits for some", stacklevel=1
        )
    return client


def _write(found: ScenarioSweep, output: Path) -> list[str]:
    """Write the worst cases and the pictures; return the names of all files."""
    names = ["sweep.zarr"]
    for figure in found.figures:
        if not found.has(figure):
            continue
        path = output / f"worst_{figure.replace('/', '_').replace(' ', '_')}.toml"
        path.unlink(missing_ok=True)
        found.worst(figure).save(path)
        names.append(path.name)
        picture = path.with_name(path.name.replace("worst_", "").replace(".toml", ".png"))
        found.plot(figure).savefig(picture)
        names.append(picture.name)
    if len(found.figures) * len(found.parameters) > 1:
        from ..plots import plot_scatter_matrix

        plot_scatter_matrix(found).savefig(output / "scatter_matrix.png")
        names.append("scatter_matrix.png")
    return names


def _answers(found: ScenarioSweep) -> dict[str, Any]:
    """Return what a sweep says, for JSON."""
    required = found.met() if found.requirements else None
    return {
        "points": found.dataset.sizes["point"],
        "failures": {str(point): reason for point, reason in found.failures().items()},
        "yield": None if required is None else {**vars(required), "fraction": required.fraction},
        "worst": {
            figure: {
                "value": found.worst(figure).figures[figure],
                "unit": found.dataset[figure].attrs["units"],
                "overrides": dict(found.worst(figure).overrides),
            }
            for figure in found.figures
            if found.has(figure)
        },
        "swings": {figure: found.swings(figure) for figure in found.figures if found.has(figure)},
        "influences": {
            figure: {name: vars(index) for name, index in indices.items()}
            for figure, indices in _influences(found).items()
        },
    }


def _influences(found: ScenarioSweep) -> dict[str, dict[str, Influence]]:
    """Return Sobol's indices of the figures that have them; those of no other design have."""
    indices = {}
    for figure in found.figures:
        with suppress(ValueError):
            indices[figure] = found.influences(figure)
    return indices


def _what_moves(found: ScenarioSweep) -> Table:
    """Return how far each parameter moves the mean of each figure, and Sobol's indices."""
    from ..analysis.tables import plain_table

    indices = _influences(found)
    more = ("alone", "in all") if indices else ()
    title = "Means over each parameter" + (", Sobol's indices of it" if indices else "")
    table = plain_table(title, "", "over", "lowest", "highest", *more)
    for figure in found.figures:
        known = indices.get(figure, {})
        for name, (low, high) in found.swings(figure).items():
            share = [f"{x:.3f}" for x in vars(known[name]).values()] if name in known else ["", ""]
            means = f"{low:.5g}", f"{high:.5g}"
            table.add_row(_named(found, figure), name, *means, *share[: len(more)])
    return table


def _named(found: ScenarioSweep, figure: str) -> str:
    unit = found.dataset[figure].attrs["units"]
    return f"{figure} [{unit}]" if unit else figure


def _told(found: ScenarioSweep) -> list[object]:
    """Return the tables of a sweep."""
    import numpy as np

    from ..analysis.sweep_result import points_told
    from ..analysis.tables import plain_table

    table = plain_table(
        f"{found.dataset.attrs['title']}: {points_told(found.dataset.sizes['point'])}",
        *("", "median", "worst", "at"),
    )
    for figure in found.figures:
        name = _named(found, figure)
        if not found.has(figure):
            table.add_row(name, "none", "none", "")
            continue
        case, values = found.worst(figure), found.values(figure)
        median = float(np.nanmedian(values))
        table.add_row(
            name, f"{median:.5g}", f"{case.figures[figure]:.5g}", found.told_at(case.point)
        )
    told: list[object] = [table, _what_moves(found)] if len(found.parameters) > 1 else [table]
    if found.requirements:
        told.append(f"{found.met()}.")
    failures = found.failures()
    if failures:
        point, reason = next(iter(failures.items()))
        told.append(f"{points_told(len(failures))} failed; point {point}: {reason}")
    return told
