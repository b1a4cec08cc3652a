"""Where an FMU stands: its time, whether it may be called there, and what its errors say."""

from __future__ import annotations

import weakref
from typing import NoReturn

from ...shaping.checks import positive
from .description import FmuDescription, FmuError, FmuTerminated
from .library import Session
from .log import DISCARD, FATAL, GONE, STATUS, WARNING, Log

Clock = tuple[float, int, float]
"""A time as a start, a number of steps, and their length, so that rounding does not add up."""

_STEP_TOLERANCE = 1e-9
_REACHED = 1e-6  # of a step: what may be missing of one that was finished


class Standing:
    """The communication point of an FMU, and what FMI allows there.

    Attributes
    ----------
    time : float
    clock : Clock
    at_start : bool
        Whether nothing has been done since the initialisation.
    refusal : FmuError or None
        What calls are answered with, since FMI does not allow them.
    """

    def __init__(
        self,
        description: FmuDescription,
        session: Session,
        log: Log,
        *,
        close: weakref.finalize[..., None],
    ) -> None:
        self._name = description.model_name
        self._can = description.capabilities
        self._session = session
        self._log = log
        self._close = close
        self._doubt = ""
        self.time = 0.0
        self.clock: Clock = (0.0, 0, 0.0)
        self.at_start = False
        self.refusal: FmuError | None = None

    def go_to(self, clock: Clock) -> None:
        """Stand at a time, and take steps from there."""
        base, count, length = self.clock = clock
        self.time = base + count * length

    def recover(self, clock: Clock, *, at_start: bool = False) -> None:
        """Go to a time in a state that is sound, whatever there was before."""
        self.go_to(clock)
        self.refusal, self._doubt, self.at_start = None, "", at_start
        self._session.stepping = True

    def clock_after(self, length: float) -> Clock:
        """Return the clock after one more step."""
        base, count, last = self.clock
        return (base, count + 1, length) if length == last else (self.time, 1, length)

    def checked_length(self, dt: float) -> float:
        """Return the length of a step; FmuError where the FMU takes steps of another only."""
        length = positive("dt", dt)
        last = self.clock[2] or length
        if not self._can.can_handle_variable_step and abs(length - last) > _STEP_TOLERANCE * last:
            raise FmuError(
                f"dt = {dt!r}: {self._name} takes steps of one length only, here "
                f"{last!r}; reset it to begin with another"
            )
        return length

    @property
    def is_open(self) -> bool:
        """Whether it has not been closed."""
        return self._close.alive

    @property
    def terminated(self) -> bool:
        """Whether the FMU has ended the simulation."""
        return self.is_open and isinstance(self.refusal, FmuTerminated)

    def check_open(self) -> None:
        """Refuse calls on an FMU that is closed."""
        if not self.is_open:
            self.check_ready()

    def check_ready(self, *, reading: bool = False) -> None:
        """Refuse calls that FMI does not allow now; after the end an FMU may still be read."""
        if self.refusal is not None and not (reading and self.terminated):
            raise self.refusal.with_traceback(None)

    def check(self, status: int, what: str) -> None:
        """Raise what the FMU reported where it could not do `what`."""
        if status > WARNING:
            self.fail(status, what, stopped=status != DISCARD)

    def fail(self, status: int, what: str, *, stopped: bool) -> NoReturn:
        """Raise what the FMU reported, and refuse what FMI does not allow after it."""
        if status == GONE:
            instance = self._session.instance
            ending = "" if instance is None else instance.ending
            raise self._lost(f"{self._name} {ending} when it was to {what}{self._said()}")
        told = self._log.told()
        if self._doubt and "call sequence" in told.lower():
            told = ""  # which is no news after an error
        message = (
            f"{self._name} could not {what}: it "
            f"{STATUS.get(status, f'returned status {status}')}{told}{self._doubt}"
        )
        self._doubt = f"; this came after an error at time {self.time:g}: call reset() first"
        if status == FATAL:
            raise self._lost(message)
        if stopped:
            self._session.stepping = False
            self.stop(f"after the error at time {self.time:g}")
        raise FmuError(message)

    def stop(self, since: str) -> None:
        """Refuse calls until it is reset, or goes back to a snapshot."""
        self.refusal = FmuError(
            f"{self._name} takes no calls {since}: call reset() first"
            + (", or set_state with an earlier snapshot" if self._can.can_get_and_set_state else "")
        )

    def end(self, reached: float, until: float, length: float) -> FmuTerminated:
        """Return the error that tells of an FMU that has ended the simulation."""
        whole = abs(until - reached) <= _REACHED * length
        self.time = until if whole else reached
        self.clock = (self.time, 0, length)
        error = FmuTerminated(
            f"{self._name} asked for the end of the simulation: at time "
            f"{self.time!r}{self._said()}; call reset() to begin again"
        )
        error.time, error.reached = self.time, whole
        self.refusal = error
        return error

    def close(self) -> None:
        """Undo all that the FMU is made of, and refuse every call."""
        if self.is_open:
            self._close()
            self.refusal = FmuError(f"{self._name} is closed: load it again")

    def _lost(self, message: str) -> FmuError:
        """Close an FMU that must not be called any more, and return the error that says so."""
        self._session.fatal = True
        self.close()
        self.refusal = FmuError(f"{self._name} is closed ({message}): load it again")
        return FmuError(f"{message}: load it again")

    def _said(self) -> str:
        return self._log.told() if self._log.messages else ""
