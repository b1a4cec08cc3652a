"""An argparse parser for commands: errors in one line, values that begin with -, plain help."""

from __future__ import annotations

from argparse import SUPPRESS, Action, ArgumentParser, HelpFormatter
from collections.abc import Generator, Iterable, Sequence
from shutil import get_terminal_size
from typing import Any, NoReturn

_WIDEST, _NARROWEST = 100, 40
_COLUMN = 26


class Parser(ArgumentParser):
    """A parser of what stands behind the words of a command; what is not given is left out."""

    def __init__(self, prog: str, usage: str = "", description: str = "") -> None:
        super().__init__(
            prog,
            f"%(prog)s [OPTIONS] {usage}",
            description,
            formatter_class=_Help,
            argument_default=SUPPRESS,
            add_help=False,
            allow_abbrev=False,
        )

    def check_names(self, words: Sequence[str]) -> None:
        """Refuse options that there are not, and those behind ``--``."""
        end = words.index("--") if "--" in words else len(words)
        known = self._option_string_actions
        for name in map(_name, words[:end]):
            if name.startswith("--") and name not in known:
                self.error(f"unknown option {name}{_near(name, known)}")
        for word in words[end + 1 :]:
            if word in known:
                self.error(
                    f"{word} behind --, after which nothing is an option: write it before --"
                )

    def error(self, message: str) -> NoReturn:
        """Raise ValueError, in one line."""
        raise ValueError(f"{' '.join(message.split())}; see {self.prog} --help")

    def _parse_optional(self, arg_string: str) -> Any:
        """Take a word for an option only where its name is one: -2mm is a value."""
        named = _name(arg_string) in self._option_string_actions
        return super()._parse_optional(arg_string) if named else None


def _name(word: str) -> str:
    """Return the option's name in ``--name=value`` and ``-nvalue``, if it is one."""
    return word.partition("=")[0] if word.startswith("--") else word[:2]


def _near(name: str, known: Iterable[str]) -> str:
    """Return the question whether an option is meant that begins so, or that is most like it."""
    from difflib import get_close_matches

    begun = [each for each in known if each.startswith(name)]
    near = next(iter(begun or get_close_matches(name, known, n=1)), None)
    return f": did you mean {near}?" if near else ""


class _Help(HelpFormatter):
    """Help in paragraphs, as wide as the terminal within reason."""

    def __init__(self, prog: str) -> None:
        width = max(_NARROWEST, min(get_terminal_size().columns, _WIDEST))
        super().__init__(prog, max_help_position=_COLUMN, width=width)

    def add_usage(self, usage: Any, actions: Any, groups: Any, prefix: Any = None) -> None:
        """Begin with a capital letter, as the headings do."""
        super().add_usage(usage, actions, groups, "Usage: " if prefix is None else prefix)

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.strip().split("\n\n")
        return "\n\n".join(super(_Help, self)._fill_text(p, width, indent) for p in paragraphs)

    def _format_action(self, action: Action) -> str:
        """Leave out the line that says no more than that commands follow."""
        told = super()._format_action(action)
        return told.partition("\n")[2] if action.dest == "command" else told

    def _iter_indented_subactions(self, action: Action) -> Generator[Action, None, None]:
        """Yield the commands, which are not indented below that line."""
        yield from getattr(action, "_get_subactions", list)()

    def _format_action_invocation(self, action: Action) -> str:
        """Return all names of an option before its value, which stands there once."""
        metavar = action.metavar if isinstance(action.metavar, str) else ""
        if not action.option_strings:
            return metavar or action.dest.upper()
        return " ".join((", ".join(action.option_strings), metavar)).rstrip()
