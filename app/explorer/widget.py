"""The explorer in a notebook: the same page as a widget, the same session behind it."""

from __future__ import annotations

import asyncio
from os import PathLike
from pathlib import Path
from threading import Thread
from typing import Any

from ...analysis.measured import MeasuredResponse, as_measured
from ..scenario import Scenario
from ..text_files import text_of
from .extra import needed
from .mailbox import Mailbox
from .nouns import Unit, content_of
from .session import Session
from .state import State, opened, started
from .wire import packed

_STATIC = Path(__file__).parent / "static"
_NAME = Path("explored.toml")


class Explorer:
    """What `explore` gives a notebook: shown as its last expression, it is the page.

    Parameters
    ----------
    session : Session

    Attributes
    ----------
    session : Session
    widget : anywidget.AnyWidget
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.widget = _widget()
        self._mailbox = Mailbox(session, self._send)
        self._own: asyncio.AbstractEventLoop | None = None
        self.widget.on_msg(lambda _, message, __: self.receive(message))

    @property
    def loop(self) -> Any:
        """The loop as it has been shaped, a ServoLoop."""
        return self.session.state.loop

    @property
    def scenario(self) -> Scenario:
        """The scenario as it has been changed."""
        return self.session.state.scenario

    def text(self) -> str:
        """Return the scenario file's text as it has been changed."""
        return self.session.text()

    def receive(self, message: dict[str, Any]) -> None:
        """Take a message of the page, which is answered while the notebook does other things.

        The thread that answers is its own: notebooks take messages in loops that they leave.
        """
        if self._own is None:
            self._own = asyncio.new_event_loop()
            Thread(target=self._answer, daemon=True).start()
        self._own.call_soon_threadsafe(self._mailbox.put, message)

    def _answer(self) -> None:
        assert self._own is not None
        self._own.run_until_complete(self._mailbox.run())

    async def _send(self, part: dict[str, Any]) -> None:
        plain, buffers = packed(part)
        self.widget.send(plain, buffers)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)


def explore(
    what: Any,
    *,
    unit: Unit = "rad",
    frf: MeasuredResponse | None = None,
) -> Explorer:
    """Open a loop, a move or a scenario in the notebook, to be shaped there.

    Parameters
    ----------
    what : ServoLoop, analysis.Move, Scenario, str or Path
        A scenario is read from its file again. Of a loop or a move numbers are in N m and rad, or
        N and m, and s.
    unit : "rad" or "m", optional
        What positions of a loop or a move are in.
    frf : MeasuredResponse or control.FrequencyResponseData, optional
        Of the plant, or the loop; margins are then of that. python-control's is of the plant.

    Returns
    -------
    Explorer
        As it is being changed: its `loop`, its `scenario`, the `text()` of the file.

    Raises
    ------
    TypeError, ValueError
        For what is none of these, or cannot be written as a scenario; without the extra: it names
        the command that installs it.
    """
    for package in ("anywidget", "tomlkit"):
        needed(package)
    measured = None if frf is None else as_measured(frf, plant=True)
    state, text = _opened(what, unit, measured)
    session = Session(state, text)
    if not hasattr(what, "controller"):
        session.receive({"kind": "view", "view": "loop" if state.path != _NAME else "move"})
    return Explorer(session)


def _opened(what: Any, unit: Unit, frf: MeasuredResponse | None) -> tuple[State, str]:
    if isinstance(what, Scenario):
        what = what.path
    if isinstance(what, str | PathLike):
        path = Path(what)
        state = opened(path, measured=frf, name="" if frf is None else "data")
        return state, text_of(path, "a scenario file (TOML)")
    content = content_of(what, unit)
    state = started(_NAME, content, frf, "" if frf is None else "data")
    text: str = needed("tomlkit").dumps(state.content)
    return state, text


def _widget() -> Any:
    """Return a widget of explorer.js, made by anywidget."""
    anywidget, traitlets = needed("anywidget"), needed("traitlets")
    own = {
        "_esm": _STATIC / "explorer.js",
        "_css": _STATIC / "style.css",
        "link": traitlets.Unicode("").tag(sync=True),
        "notebook": traitlets.Bool(True).tag(sync=True),
        "__module__": __name__,
    }
    return type("ExplorerWidget", (anywidget.AnyWidget,), own)()
