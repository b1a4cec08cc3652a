"""The core in C, as `binding.c` shows it to Python."""

from collections.abc import Sequence
from typing import Any, TypeVar, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
StatusArray = NDArray[np.int8]
Numbers = tuple[float, ...] | list[float]
_T = TypeVar("_T")

OK: int
UNREACHABLE: int
NO_DURATION: int
RANGE: int
CHATTER: int
FMI2_MARK: int

@final
class Pieces:
    def __new__(
        cls,
        breaks: FloatArray,
        states: FloatArray,
        durations: FloatArray,
        end_state: FloatArray,
        coasting: int,
        /,
    ) -> Pieces: ...
    def at(self, t: ArrayLike, derivative: int, /) -> FloatArray: ...
    def up_to(self, t: ArrayLike, highest: int, out: FloatArray | None, /) -> FloatArray: ...

@final
class Motion:
    @property
    def duration(self) -> float: ...
    @property
    def inside_after(self) -> float: ...
    @property
    def count(self) -> int: ...
    @property
    def order(self) -> int: ...
    @property
    def end_state(self) -> tuple[float, ...]: ...
    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]: ...
    def pieces(self) -> Pieces: ...

@final
class Follower:
    def __new__(
        cls, bounds: Numbers, dt: float, period: float, omega: float, lags: int, /
    ) -> Follower: ...
    def step(
        self, state: Numbers, command: float, command_velocity: float, /
    ) -> tuple[float, ...] | int: ...
    def output(self, state: Numbers, /) -> tuple[float, ...]: ...
    def run(
        self,
        state: Numbers,
        commands: FloatArray,
        command_velocities: FloatArray,
        rows: FloatArray,
        /,
    ) -> int: ...
    def pieces(
        self, state: Numbers, command: float, command_velocity: float, /
    ) -> list[tuple[float, tuple[float, ...]]] | int: ...

def bounds(
    *bounds: object,
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]] | None: ...
def advance_lags(
    lags: Numbers, motion: Numbers, tau: float, omega: float, /
) -> tuple[float, ...]: ...
@overload
def move(distance: float, bounds: Numbers, start: float, /) -> Motion | int: ...
@overload
def move(
    distance: float, bounds: Numbers, start: float, type: type[_T], limits: object, /
) -> _T | int: ...
@overload
def transfer(start: Numbers | float, end: Numbers | float, bounds: Numbers, /) -> Motion | int: ...
@overload
def transfer(
    start: Sequence[float] | float,
    end: Sequence[float] | float,
    bounds: Numbers,
    type: type[_T],
    limits: object,
    /,
) -> _T | int: ...
@overload
def velocity_transfer(start: Numbers | float, end: Numbers, bounds: Numbers, /) -> Motion | int: ...
@overload
def velocity_transfer(
    start: Numbers | float, end: Numbers, bounds: Numbers, type: type[_T], limits: object, /
) -> _T | int: ...
@overload
def transfer_lasting(
    start: Numbers, end: Numbers, bounds: Numbers, duration: float, /
) -> Motion | int: ...
@overload
def transfer_lasting(
    start: Numbers,
    end: Numbers,
    bounds: Numbers,
    duration: float,
    type: type[_T],
    limits: object,
    /,
) -> _T | int: ...
def possible_durations(
    start: Numbers, end: Numbers, bounds: Numbers, /
) -> tuple[tuple[float, float], ...]: ...
def together(
    transfers: tuple[object, ...], type: type[_T], /
) -> tuple[tuple[_T, ...], tuple[Any, ...]] | int: ...
def transfers(
    order: int,
    starts: FloatArray,
    ends: FloatArray,
    bounds: FloatArray,
    durations: FloatArray,
    inside_after: FloatArray,
    statuses: StatusArray,
    counts: StatusArray,
    /,
) -> None: ...
def transfer_pieces(
    order: int,
    starts: FloatArray,
    ends: FloatArray,
    bounds: FloatArray,
    most: int,
    lengths: FloatArray,
    states: FloatArray,
    end_states: FloatArray,
    /,
) -> None: ...
def balance(matrix: FloatArray, scale: FloatArray, /) -> None: ...
def run_loops(loops: tuple[tuple[Any, ...], ...], /) -> list[tuple[FloatArray, int]]: ...
def fmi2_logger(strays: int, /) -> int: ...
def move_durations(
    order: int,
    distances: FloatArray,
    lower: tuple[FloatArray, ...] | None,
    upper: tuple[FloatArray, ...],
    durations: FloatArray,
    /,
) -> None: ...
def move_pieces(
    order: int,
    distances: FloatArray,
    starts: FloatArray,
    bounds: FloatArray,
    most: int,
    lengths: FloatArray,
    states: FloatArray,
    end_states: FloatArray,
    /,
) -> None: ...
def evaluate_lanes(
    durations: FloatArray,
    lengths: FloatArray,
    states: FloatArray,
    end_states: FloatArray,
    times: FloatArray,
    points: int,
    first: int,
    last: int,
    out: FloatArray,
    /,
) -> None: ...
