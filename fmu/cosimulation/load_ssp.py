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
from typing import Any, NamedTuple

from ..importing.description import FmuError, FmuUnit
from ..importing.load import check_digest, load_fmu
from ..importing.reading import inspect_fmu
from ..importing.stepping import Fmu
from ..importing.unpacking import open_fmu
from .fmu_system import FmuSystem
from .participants import units_of
from .ssp_plan import SspPlan
from .ssp_reading import read_ssp


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
) -> FmuSystem:
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
    FmuSystem

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
    >>> from jounce.fmu import export_ssp
    >>> from jounce.fmu.exporting.compile import host_platform
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
    given: dict[str, Any] = {
        "dt": dt,
        "stop_time": stop_time,
        "tolerance": tolerance,
        "log": log,
        "max_unpacked_bytes": max_unpacked_bytes,
        "isolated": isolated,
        "timeout": timeout,
    }
    with _opened(Path(path), sha256, max_unpacked_bytes) as (plan, files), ExitStack() as loaded:
        structure = plan.structure
        given["start_time"] = structure.start_time or 0.0 if start_time is None else start_time
        settings, notes = plan.settings(parameters or {})
        recorded = plan.recorded(record)
        blocks: dict[str, Fmu] = {}
        for name, file in files.items():
            own = {"parameters": settings[name], "record": recorded[name], **given}
            digest = plan.descriptions[name].sha256
            with _told_of(name, file):
                blocks[name] = loaded.enter_context(load_fmu(file.path, sha256=digest, **own))
        system = FmuSystem(
            name=structure.name,
            blocks=MappingProxyType(blocks),
            connections=plan.connections(),
            inputs=MappingProxyType(plan.inputs()),
            outputs=MappingProxyType(plan.outputs()),
            units=MappingProxyType({**plan.units(), **_recorded_units(blocks)}),
            dt=_step(plan, blocks) if dt is None else dt,
            stop_time=structure.stop_time if stop_time is None else stop_time,
            notes=notes,
        )
        loaded.pop_all()
        return system


def inspect_ssp(path: str | os.PathLike[str], *, max_unpacked_bytes: int | None = None) -> SspPlan:
    """Return what an SSP and its FMUs say of themselves; nothing of them is run.

    Raises
    ------
    OSError, FmuError
        As `load_ssp` does.
    """
    with _opened(Path(path), None, max_unpacked_bytes) as (plan, _):
        return plan


class _File(NamedTuple):
    """An FMU of the archive: its entry, and where that was written to."""

    entry: str
    path: Path


@contextmanager
def _opened(
    path: Path, sha256: str | None, limit: int | None
) -> Iterator[tuple[SspPlan, dict[str, _File]]]:
    """Yield what an SSP says, and its FMUs as files that are there for the while."""
    with (
        open_fmu(path, limit) as (archive, digest),
        tempfile.TemporaryDirectory(prefix="jounce_ssp_") as folder,
    ):
        check_digest(path, digest, sha256)
        structure = read_ssp(archive)
        files = {c.name: _file(c.entry, archive, Path(folder)) for c in structure.components}
        described = {}
        for name, file in files.items():
            with _told_of(name, file):
                described[name] = inspect_fmu(file.path, max_unpacked_bytes=limit)
        yield SspPlan(structure, described, digest), files


def _file(entry: str, archive: zipfile.ZipFile, folder: Path) -> _File:
    """Write an entry of the archive to a file, once."""
    path = folder / f"{archive.namelist().index(entry)}.fmu"
    if not path.exists():
        with archive.open(entry) as source, path.open("xb") as copy:
            shutil.copyfileobj(source, copy)
    return _File(entry, path)


@contextmanager
def _told_of(name: str, file: _File) -> Iterator[None]:
    """Begin errors with the component that they are about."""
    try:
        yield
    except FmuError as error:
        told = str(error).replace(str(file.path), file.entry)
        raise FmuError(f"component {name!r}: {told}") from None


def _recorded_units(blocks: Mapping[str, Fmu]) -> dict[str, FmuUnit]:
    """Return the units of what FMUs show, also by other names than the variables' first ones."""
    return {
        f"{name}.{label}": unit
        for name, fmu in blocks.items()
        for label, unit in units_of(fmu.description, fmu.units).items()
    }


def _step(plan: SspPlan, blocks: Mapping[str, Fmu]) -> float:
    """Return the least step that an FMU suggests itself, or else that its loader took."""
    declared = [d.default_experiment.step_size for d in plan.descriptions.values()]
    return min([step for step in declared if step] or [fmu.dt for fmu in blocks.values()])
