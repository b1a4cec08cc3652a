"""FMI 3.0 co-simulation: instantiation with its callback, initialisation, step."""

from __future__ import annotations

import ctypes
import os
from ctypes import c_bool, c_char_p, c_double, c_int, c_size_t, c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from .description import FmuDescription
from .instance import (
    ARRAY,
    DoStep,
    EnterInitialization,
    Functions,
    Instance,
    Version,
    instance_of,
)
from .log import ERROR, TERMINATED, WARNING, Log

DTYPES: dict[str, Any] = {
    "Float64": np.float64,
    "Float32": np.float32,
    **{f"Int{bits}": np.dtype(f"int{bits}") for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": np.dtype(f"uint{bits}") for bits in (8, 16, 32, 64)},
    "Enumeration": np.int64,
    "Boolean": np.bool_,
}
"""What the binary takes for each type of variable."""

_EARLY = 1e-9  # of a step: what remains is rounding
_LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


def instantiate(
    library: ctypes.CDLL,
    description: FmuDescription,
    resources: Path,
    log: Log,
    *,
    logging_on: bool = False,
) -> Instance:
    """Return a new instance; FmuError, with what the FMU logged, where it refuses."""
    call = Functions(library, "fmi3")
    logger = _LOGGER(lambda _, status, category, text: log.add(status, category, text))
    function = call(
        "InstantiateCoSimulation",
        *(c_char_p, c_char_p, c_char_p, c_bool, c_bool, c_bool, c_bool),
        *(ARRAY, c_size_t, c_void_p, _LOGGER, c_void_p),
        returns=c_void_p,
    )
    where = os.fsencode(str(resources) + os.sep) if resources.is_dir() else None
    found = function(
        *(description.model_name.encode(), description.token.encode(), where),
        *(False, logging_on, False, False, None, 0, None, logger, None),
    )
    name = description.model_name
    return instance_of(found, call, _VERSION, name=name, log=log, kept=logger)


def _stepper(call: Functions, handle: c_void_p, log: Log) -> DoStep:
    function = call("DoStep", c_void_p, c_double, c_double, c_bool, ARRAY, ARRAY, ARRAY, ARRAY)
    flags, last = (c_bool * 3)(), c_double()
    first = ctypes.addressof(flags)
    events, end, early = (c_void_p(first + i) for i in range(3))
    last_time = c_void_p(ctypes.addressof(last))

    def do_step(time: float, length: float, no_way_back: bool) -> tuple[int, float]:
        until = last.value = time + length
        while True:
            flags[1] = flags[2] = False
            status: int = function(handle, time, length, no_way_back, events, end, early, last_time)
            if status > WARNING:
                return status, time
            if flags[1]:
                return TERMINATED, min(max(last.value, time), until)
            if not flags[2] or last.value >= until - _EARLY * length:
                return status, until
            if not last.value > time:
                log.add(ERROR, None, f"it came back early from time {time!r}".encode())
                return ERROR, time
            time, length = last.value, until - last.value
            last.value = until

    return do_step


def _initializer(call: Functions, handle: c_void_p) -> EnterInitialization:
    enter = call("EnterInitializationMode", c_void_p, c_bool, c_double, c_double, c_bool, c_double)

    def enter_initialization(
        start_time: float, stop_time: float | None, tolerance: float | None
    ) -> int:
        times = start_time, stop_time is not None, stop_time or 0.0
        status: int = enter(handle, tolerance is not None, tolerance or 0.0, *times)
        return status

    return enter_initialization


_VERSION = Version("FMUState", sized=True, stepper=_stepper, initializer=_initializer)
