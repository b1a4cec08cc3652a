"""What turns a page's messages into parts: all that wait are taken, the newest state is shown."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from .session import Session

Message = Mapping[str, Any]
Send = Callable[[dict[str, Any]], Awaitable[None]]

_PAUSE = 0.12
"""Seconds without a message after which what takes longer is worked out: a hand at rest."""


class Mailbox:
    """Messages that wait for a session; nothing queues.

    Parameters
    ----------
    session : Session
    send : callable
        Takes a part to the page.
    """

    def __init__(self, session: Session, send: Send) -> None:
        self._session, self._send = session, send
        self._waiting: list[Message] = []
        self._come = asyncio.Event()

    def put(self, message: Message) -> None:
        """Let a message wait."""
        self._waiting.append(message)
        self._come.set()

    async def run(self) -> None:
        """Answer messages for ever, each part worked out in a thread."""
        while True:
            await self._come.wait()
            last = await asyncio.to_thread(self._receive_all)
            await self._show(last)

    def _receive_all(self) -> Message:
        """Take all that waits; return the last message."""
        waiting, self._waiting = self._waiting, []
        self._come.clear()
        for message in waiting:
            self._session.receive(message)
        return waiting[-1]

    async def _show(self, last: Message) -> None:
        """Send parts until all are sent, or there is something newer once the quick ones are."""
        parts, ready = self._session.parts(), False
        while (part := await asyncio.to_thread(_next, parts)) is not None:
            await self._send(part | {"id": last.get("id")})
            if part["part"] == "ready":
                ready = True
                await self._rest()
            if ready and self._waiting:
                return
        await self._send({"part": "done", "id": last.get("id")})

    async def _rest(self) -> None:
        """Wait until the hand seems to rest, or a message comes."""
        with suppress(TimeoutError):
            await asyncio.wait_for(self._come.wait(), _PAUSE)


def _next(parts: Iterator[dict[str, Any]]) -> dict[str, Any] | None:
    return next(parts, None)
