"""`load_fmu`: a file as an FMU that is ready to step."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from ....shaping.checks import finite, positive
from .description import CO_SIMULATION, FmuDescription, FmuError
from .instance import Instance
from .isolation import RemoteInstance, isolate
from .library import Log, Session, find_library
from .reading import describe
from .stepping import Fmu, binding_of
from .unpacking import open_fmu, unpack


def load_fmu(
    path: str | os.PathLike[str],
    *,
    sha256: str | None = None,
    dt: float | None = None,
    parameters: Mapping[str, Any] | None = None,
    start_time: float | None = None,
    isolated: bool = False,
    timeout: float | None = None,
) -> Fmu:
    """Return a co-simulation FMU, unpacked, loaded and initialised, ready to step.

    **This runs native code from the file**, with all the rights of this process: load only what
    you trust, and pin it with `sha256`. `inspect_fmu` reads a file without running any of it.

    Parameters
    ----------
    path : path
        FMI 2.0 or 3.0, with a binary for this machine.
    sha256 : str, optional
        What the file must be, in hexadecimal digits; anything else is refused before a byte of it
        is unpacked.
    dt : float, optional
        Communication step. Default: that of the FMU's default experiment, if it has one.
    parameters : mapping of str to value, optional
        Values by name set before the initialisation: parameters, start values, inputs. They
        outlast `Fmu.reset`.
    start_time : float, optional
        Default: that of the default experiment, or 0.
    isolated : bool, optional
        Whether the FMU runs in a process of its own: if it crashes or ends its process, that is
        an FmuError here, and what it prints goes to standard error. A step then takes some tens
        of microseconds more. The process may do all that this one may: no protection from malice.
    timeout : float, optional
        Seconds that a call of an isolated FMU may take, each step and its instantiation; then it
        is stopped, with an FmuError. Default: no limit.

    Returns
    -------
    Fmu
        A context manager: leaving it (or `close`, or the end of the process) frees the instance
        and removes the temporary folder.

    Raises
    ------
    OSError
        Where the file is not there or cannot be unpacked.
    FmuError
        A ValueError, for whatever `inspect_fmu` refuses; another sha256; no co-simulation; no
        binary for this machine; unknown or unsettable parameters; an FMU that reports an error,
        with what it logged. Nothing is left on disk then.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import Inertia
    >>> from jounce.plant.fmu import export_fmu
    >>> from jounce.plant.fmu.exporting.compile import host_platform
    >>> with TemporaryDirectory() as folder:
    ...     here = [host_platform()]
    ...     written = export_fmu(Inertia(2.0), f"{folder}/plant.fmu", platforms=here)
    ...     with load_fmu(written.path, dt=0.5) as plant:
    ...         steps = [plant.step([1.0]).tolist() for _ in range(2)]
    >>> steps  # position and velocity under a torque of 1
    [[0.0625, 0.25], [0.25, 0.5]]
    """
    if dt is not None:
        dt = positive("dt", dt)
    if timeout is not None:
        timeout = positive("timeout", timeout)
        if not isolated:
            raise FmuError(
                f"timeout = {timeout!r}: only an FMU in a process of its own can be stopped; give "
                "isolated=True, too"
            )
    with open_fmu(Path(path)) as (archive, digest):
        _check_digest(path, digest, sha256)
        description = describe(archive, digest)
        _check_loadable(description)
        session = Session(Path(tempfile.mkdtemp(prefix="jounce_fmu_")))
        try:
            unpack(archive, session.folder)
            return _start(
                session,
                description,
                dt,
                parameters or {},
                start_time,
                isolated=isolated,
                timeout=timeout,
            )
        except BaseException:
            session.close()
            raise


def _start(
    session: Session,
    description: FmuDescription,
    dt: float | None,
    parameters: Mapping[str, Any],
    start_time: float | None,
    *,
    isolated: bool,
    timeout: float | None,
) -> Fmu:
    experiment = description.default_experiment
    instantiate = partial(_instance, description, isolated=isolated, timeout=timeout)
    if dt is None and experiment.step_size is not None:
        dt = _suggested(experiment.step_size)
    start = experiment.start_time or 0.0 if start_time is None else start_time
    fmu = Fmu(session, instantiate, description, Log(), dt, finite("start_time", start))
    fmu.initialize(parameters)
    return fmu


def _instance(
    description: FmuDescription,
    session: Session,
    log: Log,
    *,
    isolated: bool,
    timeout: float | None,
) -> Instance | RemoteInstance:
    """Return a new instance, which the session will close."""
    library, resources = find_library(session.folder, description), session.folder / "resources"
    alone = session.twin and description.capabilities.only_one_instance_per_process
    if isolated or alone:
        session.process, session.instance = isolate(
            library, description, resources, log, timeout=timeout
        )
        return session.instance
    instance: Instance = binding_of(description).instantiate(
        session.load(library), description, resources, log
    )
    session.instance = instance
    return instance


def _suggested(step_size: float) -> float:
    if not 0.0 < step_size < math.inf:
        raise FmuError(
            f"stepSize of the default experiment = {step_size!r}: expected a positive number; give "
            "load_fmu a dt"
        )
    return step_size


def _check_digest(path: object, found: str, expected: str | None) -> None:
    if expected is not None and not isinstance(expected, str):
        raise TypeError(f"sha256 = {expected!r}: expected a string of hexadecimal digits")
    if expected is not None and found != expected.strip().lower():
        raise FmuError(
            f"{path}: sha256 {found}, expected {expected}: not the file that was pinned; nothing "
            "of it was run"
        )


def _check_loadable(description: FmuDescription) -> None:
    if CO_SIMULATION not in description.kinds:
        raise FmuError(
            f"{description.model_name} is for {' and '.join(description.kinds)} only: export it "
            "for co-simulation, with its solver inside"
        )
    if description.capabilities.needs_execution_tool:
        tool = description.generation_tool or "unknown"
        raise FmuError(
            f"{description.model_name} needs the tool that made it ({tool}): export it "
            "self-contained"
        )
