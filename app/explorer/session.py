"""A session: messages of a page to states, states to the parts that the page shows."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ...analysis.margins import LoopMargins, loop_margins
from ...shaping.checks import finite
from .asked import asked_part
from .changes import CHANGES, Change
from .history import History, began, changed, redone, undone
from .loop_view import LoopView, closed_part, curves_part, loop_view, numbers_part
from .move_view import move_part, planned_of, proof_part
from .proposals import proposal_part, proposed
from .responses import response_part, step_part
from .saving import differences, merged, saved, text_with
from .state import State, with_content
from .verdicts import revision_of
from .worst_case import worst_parts

Message = Mapping[str, Any]
Part = dict[str, Any]


class Session:
    """What one page looks at and has changed.

    Parameters
    ----------
    state : State
        As it was opened.
    text : str
        Of the file that it was opened from.

    Notes
    -----
    `receive` is quick, `parts` works: of many messages that wait, all are received, and only the
    last state is shown.
    """

    def __init__(self, state: State, text: str) -> None:
        self._opened, self._text = state, text
        self._saved = state
        self._history = History(state)
        self._revision = revision_of(state, loop_margins(state.loop))
        self._proposal: State | None = None
        self._view = "loop"
        self._told: list[Part] = []
        self._own: dict[str, Callable[[Message], None]] = {
            "start": self._start,
            "view": self._look,
            "undo": lambda _: self._go(undone(self._history)),
            "redo": lambda _: self._go(redone(self._history)),
            "save": self._save,
            "tune": self._tune,
            "take": lambda _: self._take(),
            "drop": lambda _: self._forget(),
        }

    @property
    def state(self) -> State:
        """What is shown."""
        return self._history.present

    def receive(self, message: Message) -> None:
        """Take a message; what is wrong with it is told with the next parts, nothing changes."""
        try:
            self._receive(message)
        except (ValueError, TypeError, KeyError, IndexError, OSError) as error:
            told = f"unknown key {error}" if isinstance(error, KeyError) else str(error)
            self._told.append({"part": "problem", "text": self._without_path(told)})

    def parts(self) -> Iterator[Part]:
        """Yield what is to be shown of the present state, what is quick and asked for most first.

        "ready" comes between that and what may be left out if there is something newer.
        """
        told, self._told = self._told, []
        yield from told
        try:
            yield from self._shown()
        except ValueError as error:
            yield {"part": "problem", "text": self._without_path(str(error))}

    def text(self) -> str:
        """Return the scenario file's text with the present state."""
        return text_with(self._text, self._opened, self.state)

    def _receive(self, message: Message) -> None:
        kind = message.get("kind")
        if kind in self._own:
            self._own[kind](message)
            return
        change: Change | None = CHANGES.get(str(kind))
        if change is None:
            raise ValueError(f"message of kind {kind!r}: expected one of {', '.join(CHANGES)}")
        gesture = str(message.get("gesture", ""))
        start = began(self._history, gesture)
        self._go(changed(self._history, change(start, message), gesture))

    def _go(self, history: History) -> None:
        self._history, self._proposal = history, None

    def _shown(self) -> Iterator[Part]:
        state = self.state
        if self._view == "move":
            yield from self._of_move(state)
            return
        view = loop_view(state)
        revision = self._revision.asked(state.scenario.requirements)
        yield numbers_part(view, revision)
        yield self._status()
        yield curves_part(view, revision)
        yield closed_part(view, revision)
        yield {"part": "ready"}
        yield asked_part(state)
        model = self._model(view)
        yield step_part(state, model)
        yield response_part(state, model)
        yield from worst_parts(state)
        if self._proposal is not None:
            yield proposal_part(state, self._proposal)

    def _of_move(self, state: State) -> Iterator[Part]:
        trajectory = planned_of(state)
        if trajectory is None:
            yield {"part": "problem", "text": "this scenario has no [[moves]] to show"}
            yield self._status()
            return
        yield move_part(state, trajectory)
        yield self._status()
        yield {"part": "ready"}
        yield asked_part(state)
        yield response_part(state, loop_margins(state.loop))
        yield proof_part(state, trajectory)

    def _model(self, view: LoopView) -> LoopMargins:
        margins = view.margins
        return margins if isinstance(margins, LoopMargins) else loop_margins(self.state.loop)

    def _status(self) -> Part:
        state = self.state
        return {
            "part": "status",
            "title": state.scenario.title,
            "file": state.path.name,
            "undo": bool(self._history.past),
            "redo": bool(self._history.future),
            "changed": state.content != self._saved.content,
            "link": json.dumps(differences(self._opened.content, state.content)),
            "view": self._view,
            "source": state.source,
            "data": state.measured_name,
            "moves": [move.name for move in state.scenario.moves],
            "move": state.move,
            "inertia_error": state.inertia_error,
            "delay_error_s": state.delay_error_s,
        }

    def _start(self, message: Message) -> None:
        """Take what a link says besides the file."""
        self._look(message)
        link = message.get("link")
        if not link:
            return
        try:
            told = json.loads(link)
            content = merged(self._opened.content, told)
        except (ValueError, TypeError, AttributeError):
            raise ValueError(
                "the address holds no state of this scenario; shown as it is"
            ) from None
        if content != self.state.content:
            self._go(changed(self._history, with_content(self.state, content)))

    def _look(self, message: Message) -> None:
        view = message.get("view", self._view)
        if view not in ("loop", "move"):
            raise ValueError(f"view = {view!r}: expected 'loop' or 'move'")
        self._view = view

    def _save(self, message: Message) -> None:
        name = message.get("name") or self._opened.path.name
        path = self._opened.path.parent / name
        if path.name != name or path.suffix != ".toml":
            raise ValueError(f"{name!r}: expected the name of a file beside the scenario, *.toml")
        written = saved(self._text, self._opened, self.state, path)
        if path == self._opened.path:
            self._text, self._opened = written, self.state
        self._saved = self.state
        self._told.append({"part": "saved", "file": name, "text": written})

    def _tune(self, message: Message) -> None:
        names = ("max_sensitivity", "max_complementary")
        bounds = (finite(name, message[name]) for name in names)
        self._proposal = proposed(self.state, *bounds)

    def _take(self) -> None:
        if self._proposal is None:
            raise ValueError("nothing was proposed; tune first")
        self._go(changed(self._history, self._proposal))

    def _forget(self) -> None:
        self._proposal = None

    def _without_path(self, text: str) -> str:
        return text.replace(f"{self._opened.path}: ", "")
