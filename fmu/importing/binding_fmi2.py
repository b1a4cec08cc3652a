"""FMI 2.0 co-simulation: instantiation with its callbacks, initialisation, step."""

from __future__ import annotations

import ctypes
import sys
from ctypes import c_char_p, c_double, c_int, c_size_t, c_uint64, c_void_p
from pathlib import Path
from typing import Any
from weakref import ReferenceType, ref

import numpy as np

from ...core import FMI2_MARK, fmi2_logger
from .description import FmuDescription, FmuError
from .instance import DoStep, EnterInitialization, Functions, Instance, Version, instance_of
from .log import DISCARD, TERMINATED, WARNING, Log

DTYPES: dict[str, Any] = {
    "Real": np.float64,
    "Integer": np.int32,
    "Enumeration": np.int32,
    "Boolean": np.int32,
}
"""What the binary takes for each type of variable."""

_CO_SIMULATION = 1
_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3  # of fmi2StatusKind
_NOTE = ctypes.CFUNCTYPE(None, c_int, c_char_p, c_char_p)
_ALLOCATE = ctypes.CFUNCTYPE(c_void_p, c_size_t, c_size_t)
_FREE = ctypes.CFUNCTYPE(None, c_void_p)


class _Environment(ctypes.Structure):
    _fields_ = (("mark", c_uint64), ("note", _NOTE))


class _Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", c_void_p),
        ("allocateMemory", _ALLOCATE),
        ("freeMemory", _FREE),
        ("stepFinished", c_void_p),
        ("componentEnvironment", c_void_p),
    )
    environment: _Environment


def instantiate(
    library: ctypes.CDLL,
    description: FmuDescription,
    resources: Path,
    log: Log,
    *,
    logging_on: bool = False,
) -> Instance:
    """Return a new instance; FmuError, with what the FMU logged, where it refuses."""
    call = Functions(library, "fmi2")
    callbacks = _callbacks(log)
    function = call(
        "Instantiate",
        *(c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int),
        returns=c_void_p,
    )
    found = function(
        description.model_name.encode(),
        _CO_SIMULATION,
        description.token.encode(),
        resources.as_uri().encode(),
        ctypes.addressof(callbacks),
        0,
        int(logging_on),
    )
    name = description.model_name
    return instance_of(found, call, _VERSION, name=name, log=log, kept=callbacks)


def _stepper(call: Functions, handle: c_void_p, log: Log) -> DoStep:
    function = call("DoStep", c_void_p, c_double, c_double, c_int)

    def do_step(time: float, length: float, no_way_back: bool) -> tuple[int, float]:
        status: int = function(handle, time, length, no_way_back)
        if status != DISCARD:
            return status, time + length
        ended, reached = _asked(call, handle, time)
        if ended:
            return TERMINATED, reached
        log.add(DISCARD, None, f"it came to time {reached!r}; take a smaller step".encode())
        return DISCARD, reached

    return do_step


def _asked(call: Functions, handle: c_void_p, time: float) -> tuple[bool, float]:
    """Return whether a discarded step was the end of the simulation, and the time it reached."""
    ended, reached = c_int(0), c_double(time)
    try:
        of_truth = call("GetBooleanStatus", c_void_p, c_int, c_void_p)
        of_time = call("GetRealStatus", c_void_p, c_int, c_void_p)
    except FmuError:
        return False, time
    if of_truth(handle, _TERMINATED, ctypes.addressof(ended)) > WARNING:
        ended.value = 0
    if of_time(handle, _LAST_SUCCESSFUL_TIME, ctypes.addressof(reached)) > WARNING:
        reached.value = time
    return bool(ended.value), max(reached.value, time)


def _initializer(call: Functions, handle: c_void_p) -> EnterInitialization:
    setup = call("SetupExperiment", c_void_p, c_int, c_double, c_double, c_int, c_double)
    enter = call("EnterInitializationMode", c_void_p)

    def enter_initialization(
        start_time: float, stop_time: float | None, tolerance: float | None
    ) -> int:
        tolerant, stopped = int(tolerance is not None), int(stop_time is not None)
        times = start_time, stopped, stop_time or 0.0
        status: int = setup(handle, tolerant, tolerance or 0.0, *times)
        return status if status > WARNING else max(status, enter(handle))

    return enter_initialization


_VERSION = Version("FMUstate", sized=False, stepper=_stepper, initializer=_initializer)


_latest: list[ReferenceType[Log]] = []
"""The log of the FMU instantiated last: an FMU may lose the environment it was given."""


def _note_of_a_stray(status: int, category: bytes, text: bytes) -> None:
    log = _latest[0]() if _latest else None
    if log is not None:
        log.add(status, category, text)


_STRAYS = _NOTE(_note_of_a_stray)


def _callbacks(log: Log) -> _Callbacks:
    """Return what an FMU may call; its messages come with their arguments filled in, by C."""
    libc: Any = ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)
    environment = _Environment(FMI2_MARK, _NOTE(log.add))
    _latest[:] = [ref(log)]
    callbacks = _Callbacks(
        fmi2_logger(ctypes.cast(_STRAYS, c_void_p).value or 0),
        ctypes.cast(libc.calloc, _ALLOCATE),
        ctypes.cast(libc.free, _FREE),
        None,
        ctypes.addressof(environment),
    )
    callbacks.environment = environment  # lives as long
    return callbacks
