"""A snapshot of an FMU, freed with the last reference to it."""

from __future__ import annotations

from typing import NoReturn

from ...shaping.pieces import FloatArray
from .library import Session
from .standing import Clock


class FmuState:
    """A snapshot of an `Fmu`, of `Fmu.get_state`; freed with the last reference to it."""

    __slots__ = ("__weakref__", "_clock", "_inputs", "_pointer", "_session")

    def __init__(self, session: Session, pointer: int, clock: Clock, inputs: FloatArray) -> None:
        self._session = session
        self._pointer = pointer
        self._clock = clock
        self._inputs = inputs
        session.states.add(pointer)

    def __del__(self) -> None:
        self._session.free_state(self._pointer)

    def __reduce__(self) -> NoReturn:
        raise TypeError("an FmuState cannot be copied or pickled: take another with get_state")
