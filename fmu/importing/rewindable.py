"""What goes back in an FMU need of it: that it steps, keeps a snapshot and returns to it."""

from __future__ import annotations

from types import TracebackType
from typing import Any, Protocol, Self

from ...shaping.pieces import FloatArray
from .description import FmuDescription


class Rewindable(Protocol):
    """An FMU as `io_system` uses it, such as an `Fmu`; a state is what `get_state` gives."""

    description: FmuDescription
    dt: float

    @property
    def input_names(self) -> tuple[str, ...]:
        """The inputs that `step` takes."""

    @property
    def output_names(self) -> tuple[str, ...]:
        """The outputs that `step` returns."""

    @property
    def inputs(self) -> FloatArray:
        """The present inputs."""

    @property
    def outputs(self) -> FloatArray:
        """The present outputs."""

    def step(self, inputs: Any = None, dt: float | None = None) -> FloatArray:
        """Step, and return the outputs."""

    def twin(self) -> Self:
        """Return a second instance at its start."""

    def __enter__(self) -> Self:
        """Return itself."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close it."""

    def get_state(self) -> Any:
        """Return a snapshot."""

    def set_state(self, state: Any) -> None:
        """Go back to a snapshot."""

    def check_rollback(self, purpose: str) -> None:
        """Refuse an FMU that cannot go back."""
