"""A scenario file served on a page until that is closed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ...analysis.measured import read_frf
from ..standard_input import file_of
from ..text_files import text_of
from .extra import needed
from .server import Server
from .session import Session
from .state import opened

_HIGHEST_PORT = 65535


def serve_scenario(
    path: Path,
    *,
    frf: Path | None = None,
    kind: str = "plant",
    port: int = 0,
    stay: bool = False,
    started: Callable[[str], None],
) -> None:
    """Serve a scenario file until its last page is closed, or Ctrl-C.

    Parameters
    ----------
    path : Path
    frf : Path, optional
        A measured response, of this kind, as `read_frf` takes them.
    kind : str, optional
    port : int, optional
        Default: any that is free.
    stay : bool, optional
        Whether to go on without a page.
    started : callable
        Is called with the page's address.

    Raises
    ------
    ValueError
        For files that cannot be used and a port that is taken, before anything is served; without
        the extra.
    """
    if not 0 <= port <= _HIGHEST_PORT:
        raise ValueError(f"--port {port}: expected a number from 1 to {_HIGHEST_PORT}, or none")
    for package in ("websockets", "tomlkit"):
        needed(package)
    session = _maker(path, frf, kind)
    session()
    try:
        with suppress(KeyboardInterrupt):
            asyncio.run(Server(session, stay=stay).run(port, started))
    except OSError as error:
        raise ValueError(
            f"--port {port}: cannot be served on ({error.strerror}); give another, or leave it out"
        ) from None


def _maker(path: Path, frf: Path | None, kind: str) -> Callable[[], Session]:
    """Return what opens the scenario, as it is then, for one page."""
    measured, name = None, ""
    if frf is not None:
        with file_of(frf, "a measured response") as file:
            measured, name = read_frf(file, kind=kind), file.name  # type: ignore[arg-type]

    def made() -> Session:
        text = text_of(path, "a scenario file (TOML)")
        return Session(opened(path, measured=measured, name=name), text)

    return made
