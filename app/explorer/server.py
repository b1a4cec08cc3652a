"""The explorer's server: on this machine alone, behind a token, gone with its last page."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from typing import Any

from .extra import needed
from .mailbox import Mailbox
from .session import Session
from .wire import framed

HOST = "127.0.0.1"
STATIC = Path(__file__).parent / "static"

_FILES = {
    "": ("page.html", "text/html; charset=utf-8"),
    "explorer.js": ("explorer.js", "text/javascript; charset=utf-8"),
    "socket.js": ("socket.js", "text/javascript; charset=utf-8"),
    "style.css": ("style.css", "text/css; charset=utf-8"),
}
_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; "
    "style-src 'self' 'unsafe-inline'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
_MOST_BYTES = 64_000_000
_GRACE = 2.0
"""Seconds without a page after which the server ends: a page that is loaded anew comes back."""


class Server:
    """Pages of one scenario, each with a session of its own.

    Parameters
    ----------
    session : callable
        Makes a session for a page.
    stay : bool
        Whether to go on when the last page is closed.
    """

    def __init__(self, session: Callable[[], Session], *, stay: bool = False) -> None:
        self._session, self._stay = session, stay
        self._token = secrets.token_urlsafe(24)
        self._pages, self._port = 0, 0
        self._end = asyncio.Event()
        self._leaving: asyncio.Task[None] | None = None

    @property
    def address(self) -> str:
        """Where a browser finds the page; whoever has it may use it."""
        return f"http://{HOST}:{self._port}/{self._token}/"

    async def run(self, port: int = 0, started: Callable[[str], None] = lambda _: None) -> None:
        """Serve until the last page is gone, or `end`.

        Parameters
        ----------
        port : int, optional
            Default: any that is free.
        started : callable, optional
            Is called with the address.

        Raises
        ------
        OSError
            For a port that is taken.
        """
        serve = needed("websockets.asyncio.server").serve
        options: dict[str, Any] = {"process_request": self._request, "max_size": _MOST_BYTES}
        async with serve(self._page, HOST, port, compression=None, **options) as listening:
            self._port = listening.sockets[0].getsockname()[1]
            started(self.address)
            await self._end.wait()

    def end(self) -> None:
        """Let `run` return."""
        self._end.set()

    def _request(self, connection: Any, request: Any) -> Any:
        """Answer what is no WebSocket, and refuse strangers; None lets a WebSocket through."""
        if not self._is_ours(request.headers):
            return self._answer(connection, HTTPStatus.FORBIDDEN, b"refused: not from this page\n")
        token, _, name = request.path.partition("?")[0].lstrip("/").partition("/")
        if not secrets.compare_digest(token.encode(), self._token.encode()):
            return self._answer(connection, HTTPStatus.FORBIDDEN, b"refused: wrong token\n")
        if name == "socket":
            return None
        if name not in _FILES:
            return self._answer(connection, HTTPStatus.NOT_FOUND, b"not found\n")
        file, kind = _FILES[name]
        return self._answer(connection, HTTPStatus.OK, (STATIC / file).read_bytes(), kind)

    def _is_ours(self, headers: Any) -> bool:
        """Whether a request was made to this server by name, and from its own pages if from any."""
        hosts = {f"{name}:{self._port}" for name in (HOST, "localhost")}
        origin = headers.get("Origin")
        return headers.get("Host") in hosts and (
            origin is None or origin in {f"http://{host}" for host in hosts}
        )

    def _answer(
        self, connection: Any, status: HTTPStatus, body: bytes, kind: str = "text/plain"
    ) -> Any:
        response = connection.respond(status, "")
        response.body = body
        del response.headers["Content-Type"], response.headers["Content-Length"]
        response.headers["Content-Type"] = kind
        response.headers["Content-Length"] = str(len(body))
        for name, value in _HEADERS.items():
            response.headers[name] = value
        return response

    async def _page(self, connection: Any) -> None:
        """Talk with a page until it goes."""
        closed = needed("websockets").exceptions.ConnectionClosed
        self._came()
        try:
            try:
                session = await asyncio.to_thread(self._session)
            except (ValueError, OSError) as error:
                await _sent(connection, {"part": "problem", "text": str(error)}, closed)
                return
            mailbox = Mailbox(session, lambda part: _sent(connection, part, closed))
            answering = asyncio.create_task(mailbox.run())
            try:
                with suppress(closed):
                    async for text in connection:
                        mailbox.put(_read(text))
            finally:
                answering.cancel()
        finally:
            self._went()

    def _came(self) -> None:
        self._pages += 1
        if self._leaving is not None:
            self._leaving.cancel()

    def _went(self) -> None:
        self._pages -= 1
        if not (self._pages or self._stay):
            self._leaving = asyncio.create_task(self._leave())

    async def _leave(self) -> None:
        await asyncio.sleep(_GRACE)
        self.end()


async def _sent(connection: Any, part: dict[str, Any], closed: type[Exception]) -> None:
    with suppress(closed):
        await connection.send(framed(part))


def _read(text: Any) -> dict[str, Any]:
    """Return a page's message; one without meaning says so later."""
    try:
        message = json.loads(text)
    except ValueError:
        message = None
    return message if isinstance(message, dict) else {"kind": "unreadable"}
