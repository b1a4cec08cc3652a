"""What an FMU answers and says: the status of a call, and the messages of its logger."""

from __future__ import annotations

from collections import deque

WARNING = 1
"""The highest status with which a call has done what it was asked for."""
DISCARD = 2
ERROR = 3
FATAL = 4
TERMINATED = 100
"""Ours, not FMI's: the FMU asks for the end of the simulation."""
GONE = 101
"""Ours: the process of an isolated FMU has ended."""

STATUS = {
    DISCARD: "discarded the call",
    ERROR: "reported an error",
    FATAL: "reported a fatal error",
    5: "has not finished (it steps asynchronously, which is not supported)",
    TERMINATED: "asked for the end of the simulation",
}

_KEPT_MESSAGES = 20
_KEPT_OF_EVERYTHING = 10_000
_MESSAGES_IN_ERROR = 5


class Log:
    """The last messages of an FMU's logger: warnings and errors, or everything."""

    def __init__(self, *, everything: bool = False) -> None:
        self._everything = everything
        most = _KEPT_OF_EVERYTHING if everything else _KEPT_MESSAGES
        self._messages: deque[str] = deque(maxlen=most)

    def add(self, status: int, category: bytes | None, message: bytes | None) -> None:
        """Keep a message as the logger callback receives it."""
        texts = [(part or b"").decode(errors="replace").strip() for part in (category, message)]
        if (
            self._everything
            or status > 0
            or texts[0].lower().endswith(("error", "fatal", "warning"))
        ):
            self._messages.append(texts[1])

    def told(self) -> str:
        """Return the end of an error message, and forget what was said."""
        messages = list(self._messages)[-_MESSAGES_IN_ERROR:]
        self._messages.clear()
        return f": {'; '.join(messages)}" if messages else " (and logged nothing)"

    @property
    def messages(self) -> tuple[str, ...]:
        """What is kept and not yet told."""
        return tuple(self._messages)
