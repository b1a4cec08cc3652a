"""`load_fmu`: a file as an FMU that is ready to step."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ...shaping.checks import finite, positive
from .description import CO_SIMULATION, FmuDescription, FmuError
from .instance import Instance
from .isolation import RemoteInstance, isolate
from .library import Session, find_library
from .log import Log
from .reading import describe
from .stepping import Experiment, Fmu
from .unpacking import open_fmu, unpack
from .versions import binding_of

_STEPS = 1000
_SPAN = 1.0  # of time, where an FMU names none


def load_fmu(
    path: str | os.PathLike[str],
    *,
    sha256: str | None = None,
    dt: float | None = None,
    parameters: Mapping[str, Any] | None = None,
    start_time: float | None = None,
    stop_time: float | None = None,
    tolerance: float | None = None,
    log: bool = False,
    record: Sequence[str] = (),
    max_unpacked_bytes: int | None = None,
    isolated: bool = False,
    timeout: float | None = None,
) -> Fmu:
    """Return a co-simulation FMU, unpacked, loaded and initialised, ready to step.

    **This runs native code from the file**, with all the rights of this process: load only what
    you trust, and pin it with `sha256`. `inspect_fmu` reads a file without running any of it.

    Parameters
    ----------
    path : path
        FMI 2.0 or 3.0, with a binary for this machine; or a folder with the contents of an FMU,
        which is copied and stays as it is.
    sha256 : str, optional
        What the file must be, in hexadecimal digits; anything else is refused before a byte of it
        is unpacked. `inspect_fmu` says what it is, and what it means for a folder.
    dt : float, optional
        Communication step. Default: stepSize of the FMU's default experiment; without it
        fixedInternalStepSize; without either a thousandth of the default experiment, of
        `stop_time` − `start_time` if it names no stop, of 1 s if you do not either.
    parameters : mapping of str to value, optional
        Values by name set before the initialisation: parameters, start values, inputs; an array
        in its own shape or by element, "A[1,2]", an enumeration as a number or an item's name.
        They outlast `Fmu.reset`.
    start_time : float, optional
        Default: that of the default experiment, or 0.
    stop_time : float, optional
        What the FMU is told as the end, beyond which it may refuse to step. Default: none is told.
    tolerance : float, optional
        Relative, of the FMU's own solver; an FMU without one ignores it. Default: that of the
        default experiment, else the FMU's own.
    log : bool, optional
        Whether the FMU is asked to log all it can, for `Fmu.messages`; it may take several times
        as long. Errors are told with what was logged either way.
    record : sequence of str, optional
        Variables to show behind the outputs, whatever they are: locals, parameters, elements,
        aliases, but only numbers. What is an input or an output anyway is not shown twice.
    max_unpacked_bytes : int, optional
        To how many bytes the file may unpack, if it is more than `inspect_fmu` takes.
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
    >>> from jounce.fmu import export_fmu
    >>> from jounce.fmu.exporting.compile import host_platform
    >>> with TemporaryDirectory() as folder:
    ...     here = [host_platform()]
    ...     written = export_fmu(Inertia(2.0), f"{folder}/plant.fmu", platforms=here)
    ...     with load_fmu(written.path, dt=0.5) as plant:
    ...         steps = [plant.step([1.0]).tolist() for _ in range(2)]
    >>> steps  # position and velocity under a torque of 1
    [[0.0625, 0.25], [0.25, 0.5]]
    """
    if isinstance(record, str):
        raise TypeError(f"record = {record!r}: expected a list of names, as in [{record!r}]")
    if timeout is not None:
        timeout = positive("timeout", timeout)
        if not isolated:
            raise FmuError(
                f"timeout = {timeout!r}: only an FMU in a process of its own can be stopped; give "
                "isolated=True, too"
            )
    with open_fmu(Path(path), max_unpacked_bytes) as (archive, digest):
        check_digest(path, digest, sha256)
        description = describe(archive, digest)
        _check_loadable(description)
        experiment = _experiment(description, dt, start_time, stop_time, tolerance)
        session = Session(Path(tempfile.mkdtemp(prefix="jounce_fmu_")))
        try:
            unpack(archive, session.folder)
            make = partial(_instance, description, log=log, isolated=isolated, timeout=timeout)
            messages = Log(everything=log)
            fmu = Fmu(session, make, description, messages, experiment, record)
            fmu.initialize(parameters or {})
            return fmu
        except BaseException:
            session.close()
            raise


def _instance(
    description: FmuDescription,
    session: Session,
    messages: Log,
    *,
    log: bool,
    isolated: bool,
    timeout: float | None,
) -> Instance | RemoteInstance:
    """Return a new instance, which the session will close."""
    resources = session.folder / "resources"
    alone = session.twin and description.capabilities.only_one_instance_per_process
    try:
        library = find_library(session.folder, description)
        if isolated or alone:
            session.process, session.instance = isolate(
                library, description, resources, messages, timeout=timeout, logging_on=log
            )
            return session.instance
        instance: Instance = binding_of(description).instantiate(
            session.load(library), description, resources, messages, logging_on=log
        )
    except FmuError as error:
        raise FmuError(f"{error}{description.tool_hint}") from None
    session.instance = instance
    return instance


def _experiment(
    description: FmuDescription,
    dt: float | None,
    start_time: float | None,
    stop_time: float | None,
    tolerance: float | None,
) -> Experiment:
    """Return what is asked for, else what the FMU suggests."""
    own = description.default_experiment
    start = finite("start_time", own.start_time or 0.0 if start_time is None else start_time)
    if stop_time is not None and not finite("stop_time", stop_time) > start:
        raise FmuError(f"stop_time = {stop_time!r}: expected one after start_time = {start!r}")
    if tolerance is None and own.tolerance is not None and 0.0 < own.tolerance < math.inf:
        tolerance = own.tolerance
    elif tolerance is not None:
        tolerance = positive("tolerance", tolerance)
    step = _suggested_step(description, start, stop_time) if dt is None else positive("dt", dt)
    return Experiment(step, start, stop_time, tolerance)


def _suggested_step(description: FmuDescription, start: float, stop_time: float | None) -> float:
    own = description.default_experiment
    if own.step_size is not None and not 0.0 < own.step_size < math.inf:
        raise FmuError(
            f"stepSize of the default experiment = {own.step_size!r}: expected a positive number; "
            "give load_fmu a dt"
        )
    spans = [
        end - begin
        for begin, end in ((own.start_time or 0.0, own.stop_time), (start, stop_time))
        if end is not None
    ]
    steps = [
        own.step_size,
        description.capabilities.fixed_internal_step,
        *(span / _STEPS for span in [*spans, _SPAN]),
    ]
    return next(step for step in steps if step is not None and 0.0 < step < math.inf)


def check_digest(path: object, found: str, expected: str | None) -> None:
    """Refuse a file that is not the one that was pinned."""
    if expected is not None and not isinstance(expected, str):
        raise TypeError(f"sha256 = {expected!r}: expected a string of hexadecimal digits")
    if expected is not None and found != expected.strip().lower():
        raise FmuError(
            f"{path}: sha256 {found}, expected {expected}: not the file that was pinned; nothing "
            "of it was run"
        )


def _check_loadable(description: FmuDescription) -> None:
    if CO_SIMULATION not in description.kinds:
        tool = f" from {description.generation_tool}" if description.generation_tool else ""
        raise FmuError(
            f"{description.model_name} is for {' and '.join(description.kinds)} only: export it "
            f"for co-simulation{tool}, with its solver inside (FMI 2.0 or 3.0)"
        )
