"""One instance of an FMU behind ctypes calls that are the same for FMI 2.0 and 3.0."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from ctypes import c_char_p, c_size_t, c_void_p
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...shaping.pieces import FloatArray
from .description import FmuError
from .log import Log

ARRAY = c_void_p

DoStep = Callable[[float, float, bool], tuple[int, float]]
"""Of time and length of the step, and whether no state before it will be gone back to (FMI's
noSetFMUStatePriorToCurrentPoint). Returns status and the time that was reached."""

EnterInitialization = Callable[[float, float | None, float | None], int]
"""Of start time, stop time or None, tolerance or None. Returns status."""


class Functions:
    """The functions of a library that begin with `prefix`."""

    def __init__(self, library: ctypes.CDLL, prefix: str) -> None:
        self._library = library
        self._prefix = prefix
        self._found: dict[str, Any] = {}

    def __call__(self, name: str, *arguments: Any, returns: Any = ctypes.c_int) -> Any:
        """Return a function with its argument types set; FmuError where it is not there."""
        if name in self._found:
            return self._found[name]
        try:
            function = self._library[self._prefix + name]
        except AttributeError:
            raise FmuError(
                f"the FMU's library has no function {self._prefix}{name}: it was built "
                "incompletely, or for another version of FMI; export it again"
            ) from None
        function.argtypes = arguments
        function.restype = returns
        self._found[name] = function
        return function


@dataclass(frozen=True)
class Version:
    """What calls on an instance are in one version of FMI and not in the other.

    Attributes
    ----------
    state_word : str
        How it spells FMUState.
    sized : bool
        Whether its functions take the number of values behind the values.
    stepper, initializer : callable
        What makes the step, and the start of the initialisation, of an instance.
    """

    state_word: str
    sized: bool
    stepper: Callable[[Functions, c_void_p, Log], DoStep]
    initializer: Callable[[Functions, c_void_p], EnterInitialization]


class Instance:
    """An instance of an FMU; calls that may fail return FMI's status.

    Parameters
    ----------
    functions : Functions
    handle : c_void_p
        What the FMU's instantiation returned.
    version : Version
    log : Log
    kept : object
        What must live as long as the instance, such as its callbacks.
    """

    ending = ""
    """How its process ended, where it has one of its own."""
    took_inputs = True
    """Whether it had its inputs before the last step, where they are sent with it."""

    def __init__(
        self, functions: Functions, handle: c_void_p, version: Version, log: Log, kept: object
    ) -> None:
        self.do_step = version.stepper(functions, handle, log)
        self.enter_initialization = version.initializer(functions, handle)
        self._call = functions
        self._handle = handle
        self._state_word = version.state_word
        self._sized = version.sized
        self._boolean = ctypes.c_bool if version.sized else ctypes.c_int
        self._kept = kept
        for name in ("ExitInitializationMode", "Terminate", "Reset"):
            functions(name, c_void_p)
        self._free = functions("FreeInstance", c_void_p, returns=None)

    def exit_initialization(self) -> int:
        """End the initialisation: from here on it steps."""
        return self.plain("ExitInitializationMode")

    def terminate(self) -> int:
        """End the simulation."""
        return self.plain("Terminate")

    def reset(self) -> int:
        """Go back to the state just after the instantiation."""
        return self.plain("Reset")

    def free(self) -> None:
        """Free the instance: no call may follow."""
        self._free(self._handle)

    def log_categories(self, names: Sequence[str]) -> int:
        """Have events of these categories logged; of all where none is named."""
        function = self._call("SetDebugLogging", c_void_p, self._boolean, c_size_t, ARRAY)
        texts = (c_char_p * len(names))(*(name.encode() for name in names))
        status: int = function(self._handle, True, len(names), texts if names else None)
        return status

    def plain(self, name: str) -> int:
        """Call a function that takes nothing but the instance."""
        status: int = self._call(name, c_void_p)(self._handle)
        return status

    def input_setter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a `setter` for inputs: errors may show in the step that follows."""
        return self.setter(kind, references, values)

    def output_getter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a `getter` for what is asked for after each step."""
        return self.getter(kind, references, values)

    def setter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a call without arguments that sets variables to what is in an array then."""
        return self._mover("Set", kind, references, values)

    def getter(self, kind: str, references: Sequence[int], values: Any) -> Callable[[], int]:
        """Return a call without arguments that puts variables into an array."""
        return self._mover("Get", kind, references, values)

    def set_text(self, reference: int, texts: Sequence[str]) -> int:
        """Set all the strings of a variable."""
        return self._text("Set", reference, (c_char_p * len(texts))(*(t.encode() for t in texts)))

    def get_text(self, reference: int, count: int) -> tuple[int, list[str]]:
        """Return status and the strings of a variable."""
        values = (c_char_p * count)()
        status = self._text("Get", reference, values)
        return status, [(value or b"").decode(errors="replace") for value in values]

    def set_binary(self, reference: int, values: Sequence[bytes]) -> int:
        """Set all the values of a binary variable; FMI 3.0 only."""
        sizes = (c_size_t * len(values))(*map(len, values))
        return self._binary("Set", reference, sizes, (c_char_p * len(values))(*values))

    def get_binary(self, reference: int, count: int) -> tuple[int, list[bytes]]:
        """Return status and the values of a binary variable; FMI 3.0 only."""
        sizes, values = (c_size_t * count)(), (c_void_p * count)()
        status = self._binary("Get", reference, sizes, values)
        pairs = zip(values, sizes, strict=True)
        return status, [ctypes.string_at(value, size) if value else b"" for value, size in pairs]

    def get_state(self) -> tuple[int, int]:
        """Return status and a pointer to a copy of the state, to be freed by `free_state`."""
        pointer = c_void_p()
        function = self._call(f"Get{self._state_word}", c_void_p, c_void_p)
        status = function(self._handle, ctypes.addressof(pointer))
        return status, pointer.value or 0

    def set_state(self, pointer: int) -> int:
        """Go back to a state."""
        function = self._call(f"Set{self._state_word}", c_void_p, c_void_p)
        status: int = function(self._handle, pointer)
        return status

    def free_state(self, pointer: int) -> None:
        """Free the copy of a state."""
        holder = c_void_p(pointer)
        function = self._call(f"Free{self._state_word}", c_void_p, c_void_p)
        function(self._handle, ctypes.addressof(holder))

    def directional(
        self, unknowns: Sequence[int], knowns: Sequence[int], seed: FloatArray
    ) -> tuple[int, FloatArray]:
        """Return status and the derivative of `unknowns` along `seed` in the space of `knowns`."""
        sizes = [c_size_t] if self._sized else []
        function = self._call(
            "GetDirectionalDerivative",
            *(c_void_p, ARRAY, c_size_t, ARRAY, c_size_t, ARRAY, *sizes, ARRAY, *sizes),
        )
        seed, found = np.array(seed, dtype=float), np.zeros(len(unknowns))
        status = function(
            self._handle,
            *(_references(unknowns), len(unknowns)),
            *(_references(knowns), len(knowns)),
            *(_address(seed), *self._size(seed), _address(found), *self._size(found)),
        )
        return status, found

    def _size(self, values: Any) -> list[int]:
        return [len(values)] if self._sized else []

    def _text(self, verb: str, reference: int, values: Any) -> int:
        sizes = [c_size_t] if self._sized else []
        function = self._call(f"{verb}String", c_void_p, ARRAY, c_size_t, ARRAY, *sizes)
        status: int = function(
            self._handle, _references([reference]), 1, values, *self._size(values)
        )
        return status

    def _binary(self, verb: str, reference: int, sizes: Any, values: Any) -> int:
        function = self._call(f"{verb}Binary", c_void_p, ARRAY, c_size_t, ARRAY, ARRAY, c_size_t)
        status: int = function(
            *(self._handle, _references([reference]), 1, sizes, values, len(values))
        )
        return status

    def _mover(
        self, verb: str, kind: str, references: Sequence[int], values: Any
    ) -> Callable[[], int]:
        # an enumeration is an integer: of 64 bits in FMI 3.0
        spelled = {"Enumeration": "Int64" if self._sized else "Integer"}.get(kind, kind)
        sizes = [c_size_t] if self._sized else []
        function = self._call(verb + spelled, c_void_p, ARRAY, c_size_t, ARRAY, *sizes)
        return partial(
            function,
            *(self._handle, _references(references), len(references)),
            *(_address(values), *self._size(values)),
        )


def instance_of(
    found: int | None, call: Functions, version: Version, *, name: str, log: Log, kept: object
) -> Instance:
    """Return what an FMU has instantiated; FmuError, with what it logged, where it refused."""
    if not found:
        raise FmuError(f"{name} cannot be instantiated{log.told()}")
    return Instance(call, c_void_p(found), version, log, kept)


def _address(values: Any) -> c_void_p:
    return c_void_p(values.ctypes.data)


def _references(references: Sequence[int]) -> Any:
    return (ctypes.c_uint32 * len(references))(*references)
