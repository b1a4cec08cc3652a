"""The process of an isolated FMU: carries out what `isolation` asks it for, one by one."""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np

from .channel import DONE, LOGGED, REFUSED, Channel
from .description import FmuDescription, FmuError
from .instance import Instance
from .library import load_library, unload
from .log import TERMINATED, WARNING, Log
from .versions import binding_of

_LOOK_S = 0.5


def main(parent: int) -> None:
    """Answer on standard output what is asked on standard input, until that is closed.

    What the FMU prints goes to standard error. An end of the process `parent` ends this one, also
    while the FMU computes.
    """
    channel = Channel(os.dup(0), os.dup(1))
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    try:
        os.dup2(2, 1)
    except OSError:  # there is no standard error
        os.dup2(nothing, 1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is for the parent, which ends us
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    _serve(channel)
    os._exit(0)


def _serve(channel: Channel) -> None:
    host = _Host(channel)
    while True:
        try:
            name, arguments = channel.receive()
        except EOFError:
            return
        try:
            answer = DONE, host.carry_out(name, arguments)
        except FmuError as error:
            answer = REFUSED, str(error)
        channel.send(answer)


class _Host:
    """The library and the instance. What the parent asks for is a method, here or of Instance."""

    def __init__(self, channel: Channel) -> None:
        self._log = _SentLog(channel)
        self._library: ctypes.CDLL | None = None
        self._instance: Instance | None = None
        self._movers: list[tuple[Any, Callable[[], int]]] = []

    def carry_out(self, name: str, arguments: Sequence[Any]) -> Any:
        own = getattr(self, name, None) if not name.startswith("_") else None
        return (own or getattr(self._instance, name))(*arguments)

    def begin(self) -> None:
        """Answer, once Python has started."""

    def load(self, path: str) -> None:
        self._library = load_library(Path(path))

    def instantiate(self, description: bytes, resources: str, logging_on: bool) -> None:
        says: FmuDescription = pickle.loads(description)
        assert self._library is not None
        self._instance = binding_of(says).instantiate(
            self._library, says, Path(resources), self._log, logging_on=logging_on
        )

    def free(self) -> None:
        assert self._instance is not None
        assert self._library is not None
        self._instance.free()
        unload(self._library)

    def mover(self, verb: str, kind: str, references: Sequence[int], dtype: str, size: int) -> None:
        """Prepare one more call that sets or gets variables."""
        buffer: Any = np.zeros(size, dtype)
        make = getattr(self._instance, verb)
        self._movers.append((memoryview(buffer).cast("B"), make(kind, references, buffer)))

    def put(self, number: int, data: bytes) -> int:
        buffer, call = self._movers[number]
        buffer[:] = data
        return call()

    def fetch(self, number: int) -> tuple[int, bytes]:
        buffer, call = self._movers[number]
        status = call()
        return status, buffer.tobytes()

    def step(
        self,
        inputs: Sequence[tuple[int, bytes]],
        outputs: Sequence[int],
        time: float,
        length: float,
        no_way_back: bool,
    ) -> tuple[int, float | None, list[bytes]]:
        """Set inputs, step, get outputs: all of a step in one message.

        The time that is reached is None where the inputs were not taken.
        """
        assert self._instance is not None
        for number, data in inputs:
            status = self.put(number, data)
            if status > WARNING:
                return status, None, []
        status, reached = self._instance.do_step(time, length, no_way_back)
        if status > WARNING and status != TERMINATED:
            return status, reached, []
        found = [self.fetch(number) for number in outputs]
        if any(one > WARNING for one, _ in found):
            return status, reached, []
        return status, reached, [data for _, data in found]

    def directional(
        self, unknowns: Sequence[int], knowns: Sequence[int], seed: bytes
    ) -> tuple[int, bytes]:
        assert self._instance is not None
        status, found = self._instance.directional(unknowns, knowns, np.frombuffer(seed))
        return status, found.tobytes()


class _SentLog(Log):
    """A log whose messages are sent at once: a crash that follows does not lose them."""

    def __init__(self, channel: Channel) -> None:
        super().__init__()
        self._channel = channel

    def add(self, status: int, category: bytes | None, message: bytes | None) -> None:
        super().add(status, category, message)
        self._channel.send((LOGGED, (status, category, message)))


def _end_with(parent: int) -> None:
    if sys.platform == "win32":
        kernel: Any = ctypes.windll.kernel32
        handle = kernel.OpenProcess(0x00100000, False, parent)  # SYNCHRONIZE
        kernel.WaitForSingleObject(handle, 0xFFFFFFFF)
    else:
        first = os.getppid()
        while os.getppid() == first:
            sleep(_LOOK_S)
    os._exit(1)
