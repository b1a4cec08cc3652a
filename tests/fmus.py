"""Exported FMUs, and a host that drives either version of FMI through FMPy by names."""

from __future__ import annotations

import atexit
import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback
from tiers import SLOW

from jounce.fmu import export_fmu
from jounce.fmu.exporting.compile import host_compiler
from jounce.fmu.exporting.dispatch import block_of
from jounce.fmu.exporting.sources import sources_of

VERSIONS = ("2.0", "3.0")

needs_compiler = pytest.mark.skipif(
    host_compiler() is None, reason="no C compiler (cc, gcc or clang) on this machine"
)


@cache
def folder() -> Path:
    """Return a folder that lasts as long as the tests."""
    made = Path(tempfile.mkdtemp(prefix="jounce_test_fmus_"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return made


@cache
def fmu_of(make, version):
    """Return the path of the FMU of make(), built once for the host; `make` is a function."""
    path = folder() / f"{make.__module__.rpartition('.')[2]}_{make.__name__}_{version}.fmu"
    export_fmu(make(), path, fmi_version=version, platforms=["host"])
    return path


@cache
def unpacked(path):
    """Return the description of an FMU and where it is unpacked."""
    return fmpy.read_model_description(path), fmpy.extract(path, unzipdir=str(path) + ".d")


def driven(block, driver, *options):
    """Return a library made of the C sources of a block and a driver that includes them."""
    where = Path(tempfile.mkdtemp(dir=folder()))
    for name, text in sources_of(block_of(block), "2.0", "{token}").items():
        (where / name).write_bytes(text)
    (where / "driver.c").write_text(driver, encoding="ascii")
    optimised = "-O2" if SLOW else "-O0"  # it takes a fifth of the time
    command = [*host_compiler(), "-std=c99", optimised, "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([*command, *options, "-o", "driver.so", "driver.c"], cwd=where, check=True)
    return ctypes.CDLL(str(where / "driver.so"))


def pointer(array):
    """Return the address of an array of doubles."""
    assert array.dtype == float
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


class Host:
    """An instance of an FMU in initialisation mode; `messages` are those of its logger."""

    def __init__(self, path, *, start=0.0, token=None, logging=False, stop=None):
        self.description, where = unpacked(Path(path))
        self.old = self.description.fmiVersion == "2.0"
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.messages = []
        self.fmu = (FMU2Slave if self.old else FMU3Slave)(
            guid=token or self.description.guid or self.description.instantiationToken,
            unzipDirectory=where,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="tested",
        )
        self._keep = self._log_to_messages()
        if self.old:
            self.fmu.instantiate(callbacks=self._keep[1], loggingOn=logging)
        else:
            self.fmu.instantiate(loggingOn=logging, logMessage=self._keep[0])
        self.time, self._stop = start, stop
        self.initialize(start)

    def _log_to_messages(self):
        """Return callbacks that are to be kept alive."""

        def note(*arguments):
            self.messages.append(arguments[-1].decode())

        if not self.old:
            return (fmi3LogMessageCallback(note),)
        logger = fmi2CallbackLoggerTYPE(note)
        return logger, fmi2CallbackFunctions(logger=logger)

    def initialize(self, start=0.0):
        """Enter initialisation mode."""
        self.time = start
        if self.old:
            self.fmu.setupExperiment(startTime=start, stopTime=self._stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=self._stop)

    def run(self, **values):
        """Set start values and leave initialisation mode."""
        self.set(**values)
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values):
        """Set variables by name."""
        references = [self.reference[name] for name in values]
        given = [float(value) for value in values.values()]
        (self.fmu.setReal if self.old else self.fmu.setFloat64)(references, given)

    def get(self, *names):
        """Return variables by name."""
        references = [self.reference[name] for name in names]
        return (self.fmu.getReal if self.old else self.fmu.getFloat64)(references)

    def step(self, h):
        """Do one step; the time is added up as many hosts do."""
        self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=h)
        self.time += h

    def refused(self, action, *arguments, **values):
        """Return the message with which an action is refused."""
        self.messages.clear()
        with pytest.raises(FMICallException):
            action(*arguments, **values)
        [message] = self.messages
        return message

    def record(self, steps, *names, **inputs):
        """Return outputs (len(names), N) at the ends of steps; inputs are arrays (N,)."""
        rows = []
        for k, h in enumerate(steps):
            if inputs:
                self.set(**{name: values[k] for name, values in inputs.items()})
            self.step(h)
            rows.append(self.get(*names))
        return np.array(rows).T

    def close(self):
        """Free the instance and its library."""
        self.fmu.freeInstance()
