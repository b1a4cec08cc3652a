"""Messages between two processes of one Python: numbers, texts, bytes and tuples of them."""

from __future__ import annotations

import marshal
import os
import struct
from threading import Lock
from typing import Any

LOGGED, DONE, REFUSED = range(3)
"""Kinds of answers: what an FMU logged, in between; what a call returned; its FmuError."""

_LENGTH = struct.Struct("<Q")
_CHUNK = 2**16


class Channel:
    """A pair of pipes, by their descriptors; what is sent at one end is received at the other."""

    def __init__(self, source: int, target: int) -> None:
        self._source = source
        self._target = target
        self._held = b""
        self._sending = Lock()  # an FMU may log from a thread of its own

    def send(self, message: Any) -> None:
        """Send a message; OSError where the other end is closed."""
        data = marshal.dumps(message)
        rest = memoryview(_LENGTH.pack(len(data)) + data)
        with self._sending:
            while rest:
                rest = rest[os.write(self._target, rest) :]

    def receive(self) -> Any:
        """Wait for the next message and return it; EOFError where the other end is closed."""
        size = _LENGTH.size
        self._fill(size)
        end = size + _LENGTH.unpack_from(self._held)[0]
        self._fill(end)
        message = marshal.loads(memoryview(self._held)[size:end])
        self._held = self._held[end:]
        return message

    def _fill(self, count: int) -> None:
        if len(self._held) >= count:
            return
        parts, have = [self._held], len(self._held)
        while have < count:
            part = os.read(self._source, max(_CHUNK, count - have))
            if not part:
                raise EOFError
            parts.append(part)
            have += len(part)
        self._held = b"".join(parts)
