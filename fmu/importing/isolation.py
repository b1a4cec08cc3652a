"""An instance of an FMU in a process of its own, which may crash, exit or be stopped."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from typing import Any

import numpy as np

from ...shaping.pieces import FloatArray
from .channel import LOGGED, REFUSED, Channel
from .description import FmuDescription, FmuError
from .log import GONE, WARNING, Log

_BEGIN_S = 60.0  # for Python to start; the FMU does nothing in that time
_END_S = 2.0  # for the process to end by itself when nothing is asked any more
_CLOSE_S = 10.0  # for the FMU to be freed where a call has no limit
_LOOK_S = 0.05
_PROGRAM = "import sys; sys.path[:] = {path!r}; from {module} import main; main({parent})"


class EndedError(Exception):
    """The other process has ended."""


class Process:
    """The other process, asked call by call; `ending` tells how it ended, empty while it lives."""

    def __init__(self, log: Log, timeout: float | None) -> None:
        self.ending = ""
        self._log = log
        self.timeout = timeout
        self._deadline: float | None = None
        self._late = False
        self._over = Event()
        program = _PROGRAM.format(
            path=sys.path, module=f"{__package__}.isolated_process", parent=os.getpid()
        )
        self._popen = subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
        )
        assert self._popen.stdin is not None
        assert self._popen.stdout is not None
        self._pipes = self._popen.stdin, self._popen.stdout
        self._channel = Channel(self._pipes[1].fileno(), self._pipes[0].fileno())
        self._watch = Thread(target=self._stop_when_late, daemon=True)
        self._watch.start()

    def ask(self, name: str, *arguments: Any, limit: float | None = None) -> Any:
        """Return what a call returns there.

        Raises
        ------
        EndedError
            Where the process has ended, or is stopped because the call takes too long.
        FmuError
            What the call raised there.
        """
        if self.ending:
            raise EndedError
        limit = limit or self.timeout
        self._deadline = None if limit is None else monotonic() + limit
        try:
            self._channel.send((name, arguments))
            while True:
                kind, answer = self._channel.receive()
                if kind != LOGGED:
                    break
                self._log.add(*answer)
        except (OSError, EOFError, ValueError):
            self._end(limit)
            raise EndedError from None
        except BaseException:  # the answer to come would be taken for that to another call
            self._popen.kill()
            self._clear()
            self.ending = "was interrupted"
            raise
        finally:
            self._deadline = None
        if kind == REFUSED:
            self._log.told()  # as the error has it already
            raise FmuError(answer)
        return answer

    def close(self) -> None:
        """Have the process end, by force where it does not; nothing of it is left."""
        if not self.ending:
            self.ending = "was closed"
            self._pipes[0].close()
            try:
                self._popen.wait(_END_S)
            except subprocess.TimeoutExpired:
                self._popen.kill()
            self._clear()

    def kill(self) -> None:
        """End the process at once."""
        self._popen.kill()
        self.close()

    def _end(self, limit: float | None) -> None:
        try:
            self._popen.wait(_END_S)
        except subprocess.TimeoutExpired:  # it has closed its pipe, and hangs
            self._popen.kill()
        self._clear()
        if self._late:
            self.ending = f"did not return within {limit:g} s"
        else:
            self.ending = _how(self._popen.returncode)

    def _clear(self) -> None:
        self._popen.wait()
        self._over.set()
        self._watch.join()
        for pipe in self._pipes:
            pipe.close()

    def _stop_when_late(self) -> None:
        while not self._over.wait(_LOOK_S):
            deadline = self._deadline
            if deadline is not None and monotonic() > deadline:
                self._late = True
                self._popen.kill()
                return


class RemoteInstance:
    """What `Instance` is, in another process.

    The values of inputs wait until the next call, and a step brings the outputs with it: a whole
    step is one message and one answer.
    """

    def __init__(self, process: Process) -> None:
        self.took_inputs = True
        self._process = process
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._waiting: dict[int, bytes] = {}
        self._watched: dict[int, Any] = {}
        self._up_to_date = False
        self._unused_states: list[int] = []

    @property
    def ending(self) -> str:
        """How the process ended."""
        return self._process.ending

    def do_step(self, time: float, length: float, no_way_back: bool) -> tuple[int, float]:
        """Step, with the inputs that wait; what is to be seen after it is fetched."""
        inputs = tuple(self._waiting.items())
        self._waiting.clear()
        try:
            status, reached, found = self._ask(
                "step", inputs, tuple(self._watched), float(time), float(length), bool(no_way_back)
            )
        except EndedError:
            return GONE, time
        for buffer, data in zip(self._watched.values(), found, strict=False):
            buffer[:] = data
        self._up_to_date = bool(found)
        self.took_inputs = reached is not None
        return status, reached

    def enter_initialization(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> int:
        """Begin the initialisation."""
        return self._status("enter_initialization", start_time, stop_time, tolerance)

    def exit_initialization(self) -> int:
        """End the initialisation: from here on it steps."""
        return self._status("exit_initialization")

    def terminate(self) -> int:
        """End the simulation."""
        return self._status("terminate")

    def reset(self) -> int:
        """Go back to the state just after the instantiation."""
        return self._status("reset")

    def free(self) -> None:
        """Free the instance: no call may follow. Nothing is lost where it crashes."""
        try:
            self._process.ask("free", limit=self._process.timeout or _CLOSE_S)
        except EndedError:
            return

    def log_categories(self, names: Sequence[str]) -> int:
        """Have events of these categories logged."""
        return self._status("log_categories", tuple(names))

    def setter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a call without arguments that sets variables to what is in an array then."""
        number = self._mover("setter", kind, references, values)
        return lambda: self._status("put", number, values.tobytes())

    def getter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a call without arguments that puts variables into an array."""
        number = self._mover("getter", kind, references, values)
        buffer = memoryview(values).cast("B") if len(values) else None

        def fetch() -> int:
            try:
                status, data = self._ask("fetch", number)
            except EndedError:
                return GONE
            if buffer is not None:
                buffer[:] = data
            return int(status)

        return fetch

    def input_setter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a `setter` that waits for the next call, which tells its errors."""
        number = self._mover("setter", kind, references, values)

        def put() -> int:
            self._waiting[number] = values.tobytes()
            return 0

        return put

    def output_getter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a `getter` of what each step brings with it."""
        fetch = self.getter(kind, references, values)
        number = self._mover("getter", kind, references, values)
        self._watched[number] = memoryview(values).cast("B")
        return lambda: 0 if self._up_to_date else fetch()

    def set_text(self, reference: int, texts: Sequence[str]) -> int:
        """Set all the strings of a variable."""
        return self._status("set_text", reference, tuple(texts))

    def get_text(self, reference: int, count: int) -> tuple[int, list[str]]:
        """Return status and the strings of a variable."""
        return self._pair("get_text", [], reference, count)

    def set_binary(self, reference: int, values: Sequence[bytes]) -> int:
        """Set all the values of a binary variable; FMI 3.0 only."""
        return self._status("set_binary", reference, tuple(values))

    def get_binary(self, reference: int, count: int) -> tuple[int, list[bytes]]:
        """Return status and the values of a binary variable; FMI 3.0 only."""
        return self._pair("get_binary", [], reference, count)

    def get_state(self) -> tuple[int, int]:
        """Return status and a handle of a copy of the state, to be freed by `free_state`."""
        return self._pair("get_state", 0)

    def set_state(self, pointer: int) -> int:
        """Go back to a state."""
        return self._status("set_state", pointer)

    def free_state(self, pointer: int) -> None:
        """Free the copy of a state, with the next call: this one may come amidst another."""
        self._unused_states.append(pointer)

    def directional(
        self, unknowns: Sequence[int], knowns: Sequence[int], seed: FloatArray
    ) -> tuple[int, FloatArray]:
        """Return status and the derivative of `unknowns` along `seed` in the space of `knowns`."""
        data = np.asarray(seed, dtype=float).tobytes()
        status, found = self._pair("directional", b"", tuple(unknowns), tuple(knowns), data)
        return status, np.frombuffer(found)

    def _mover(self, verb: str, kind: str, references: Sequence[int], values: Any) -> int:
        key = (verb, kind, tuple(references), values.dtype.str, len(values))
        if key not in self._numbers:
            self._process.ask("mover", *key)
            self._numbers[key] = len(self._numbers)
        return self._numbers[key]

    def _status(self, name: str, *arguments: Any) -> int:
        try:
            return int(self._ask(name, *arguments))
        except EndedError:
            return GONE

    def _pair(self, name: str, nothing: Any, *arguments: Any) -> tuple[int, Any]:
        try:
            status, found = self._ask(name, *arguments)
        except EndedError:
            return GONE, nothing
        return status, found

    def _ask(self, name: str, *arguments: Any) -> Any:
        """Ask for a call, after what has waited for it."""
        self._up_to_date = False
        while self._unused_states:
            self._process.ask("free_state", self._unused_states.pop())
        while self._waiting:
            number, data = self._waiting.popitem()
            status: int = self._process.ask("put", number, data)
            if status > WARNING:
                return status
        return self._process.ask(name, *arguments)


def isolate(
    path: Path,
    description: FmuDescription,
    resources: Path,
    log: Log,
    *,
    timeout: float | None,
    logging_on: bool = False,
) -> tuple[Process, RemoteInstance]:
    """Return a new process with the library and an instance of it; FmuError where that fails."""
    name = description.model_name
    says = replace(
        description, variables=(), units=(), outputs=(), derivatives=(), initial_unknowns=()
    )
    process = Process(log, timeout)
    what = "Python was to start in a process of its own"
    try:
        process.ask("begin", limit=_BEGIN_S)
        what = "its library was to be loaded"
        process.ask("load", str(path))
        what = "it was to be instantiated"
        process.ask("instantiate", pickle.dumps(says), str(resources), logging_on)
    except EndedError:
        raise FmuError(f"{name} {process.ending} when {what}{log.told()}") from None
    except BaseException:
        process.kill()
        raise
    return process, RemoteInstance(process)


def _how(code: int) -> str:
    """Return how a process ended, from its exit code."""
    if code < 0:
        told = signal.strsignal(-code)
        return f"crashed ({signal.Signals(-code).name}{f': {told}' if told else ''})"
    if code >= 2**31:
        return f"crashed (exit code {code:#x})"
    return f"ended its own process (exit code {code})"
