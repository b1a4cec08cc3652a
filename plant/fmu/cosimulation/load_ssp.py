"""`load_ssp`: the FMUs of an SSP file, loaded and initialised, as a system that is ready to run."""

from __future__ import annotations

import os
import shutil
import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..importing.description import FmuDescription, FmuError
from ..importing.load import check_digest, load_fmu
from ..importing.reading import inspect_fmu
from ..importing.stepping import Fmu
from ..importing.unpacking import open_fmu
from .ssp_plan import SspPlan
from .ssp_reading import read_ssp
from .ssp_system import SspSystem


def load_ssp(
    path: str | os.PathLike[str],
    *,
    sha256: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    dt: float | None = None,
    start_time: float | None = None,
    stop_time: float | None = None,
    tolerance: float | None = None,
    log: bool = False,
    record: Iterable[str] = (),
    max_unpacked_bytes: int | None = None,
    isolated: bool = False,
    timeout: float | None = None,
) -> SspSystem:
    """Return the system of an SSP 1.0 file, its FMUs loaded and initialised, ready to run.

    **This runs native code from the file**, as `load_fmu` does.

    Connections, also those through systems within the system, are followed with their linear
    transformations and the conversion of units; parameter sets, inline or in the archive, are
    applied in their order, those of an outer system after those within it, through their mappings.

    Parameters
    ----------
    path : path
        Of the .ssp file.
    sha256 : str, optional
        What the file must be, or nothing of it is run.
    parameters : mapping of str to value, optional
        By "component.variable", or by name of an input or parameter of the system; they come
        after what the file's parameter sets say.
    record : iterable of str, optional
        "component.variable" each: further variables to be shown.
    start_time : float, optional
        Default: that of the file's default experiment, or 0.
    dt, stop_time, tolerance, log, max_unpacked_bytes, isolated, timeout
        Of each FMU, as in `load_fmu`.

    Returns
    -------
    SspSystem

    Raises
    ------
    OSError
        Where the file is not there or cannot be unpacked.
    FmuError
        A ValueError, for what is no SSP, what is not supported (named), and for what `load_fmu`
        refuses of a component. Nothing is left on disk then.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import PID, Inertia, ServoLoop
    >>> from jounce.plant.fmu import export_ssp
    >>> from jounce.plant.fmu.exporting.compile import host_platform
    >>> from jounce.shaping import Limits, min_time_move
    >>> move = min_time_move(1.0, Limits(acceleration=1.0))
    >>> loop = ServoLoop(Inertia(1.0), PID(kp=4.0, ki=1.0, kr=4.0))
    >>> with TemporaryDirectory() as folder:
    ...     here = [host_platform()]
    ...     made = export_ssp(f"{folder}/axis.ssp", move, loop, dt=0.01, platforms=here)
    ...     with load_ssp(made.path) as axis:
    ...         run = axis.run(1.0)
    >>> run.order
    ('controller', 'plant', 'shaper')
    """
    given = {
        "dt": dt,
        "start_time": start_time,
        "stop_time": stop_time,
        "tolerance": tolerance,
        "log": log,
        "max_unpacked_bytes": max_unpacked_bytes,
        "isolated": isolated,
        "timeout": timeout,
    }
    with open_fmu(Path(path)) as (archive, digest), ExitStack() as opened:
        check_digest(path, digest, sha256)
        structure = read_ssp(archive)
        if start_time is None:
            given["start_time"] = structure.start_time or 0.0
        folder = Path(opened.enter_context(tempfile.TemporaryDirectory(prefix="jounce_ssp_")))
        files = {c.name: (c.entry, _file(c.entry, archive, folder)) for c in structure.components}
        described = {}
        for name, (entry, file) in files.items():
            with _told_of(name, entry, file):
                described[name] = inspect_fmu(file)
        plan = SspPlan(structure, described)
        settings, notes = plan.settings(parameters or {})
        recorded = plan.recorded(record)
        blocks: dict[str, Fmu] = {}
        with ExitStack() as loaded:
            for name, (entry, file) in files.items():
                with _told_of(name, entry, file):
                    own = {
                        "sha256": described[name].sha256,
                        "parameters": settings[name],
                        "record": recorded[name],
                        **given,
                    }
                    blocks[name] = loaded.enter_context(load_fmu(file, **_present(own)))
            system = SspSystem(
                structure.name,
                MappingProxyType(blocks),
                plan.connections(),
                MappingProxyType(plan.inputs()),
                MappingProxyType(plan.outputs()),
                _step(described.values(), blocks.values()) if dt is None else dt,
                structure.stop_time if stop_time is None else stop_time,
                notes,
            )
            loaded.pop_all()
        return system


def _file(entry: str, archive: zipfile.ZipFile, folder: Path) -> Path:
    """Return an entry of the archive as a file, written once."""
    path = folder / f"{archive.namelist().index(entry)}.fmu"
    if not path.exists():
        with archive.open(entry) as source, path.open("xb") as copy:
            shutil.copyfileobj(source, copy)
    return path


@contextmanager
def _told_of(name: str, entry: str, file: Path) -> Iterator[None]:
    """Begin errors with the component that they are about."""
    try:
        yield
    except FmuError as error:
        raise FmuError(f"component {name!r}: {str(error).replace(str(file), entry)}") from None


def _step(described: Iterable[FmuDescription], blocks: Iterable[Fmu]) -> float | None:
    """Return the least step that an FMU suggests itself, or else its loader."""
    declared = [d.default_experiment.step_size for d in described]
    found = [step for step in declared if step] or [fmu.dt for fmu in blocks if fmu.dt]
    return min(found, default=None)


def _present(options: Mapping[str, Any]) -> dict[str, Any]:
    return {k: v for k, v in options.items() if v or k in ("start_time", "parameters")}
