"""The help of a command: its usage, what it does, its arguments and options."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from shutil import get_terminal_size
from textwrap import fill, wrap

from .cli_parameters import Parameter

_WIDEST, _NARROWEST = 100, 40
_INDENT = 26


def command_help(path: str, told: str, parameters: Sequence[Parameter]) -> str:
    """Return the help of one command, as wide as the terminal."""
    places = [each for each in parameters if not each.names]
    named = [each for each in parameters if each.names]
    words = (each.metavar if each.required else f"[{each.metavar}]" for each in places)
    return _text(
        " ".join((path, "[OPTIONS]", *words)),
        told,
        Arguments=[(each.metavar, _told(each)) for each in places],
        Options=[*((_names(each), _told(each)) for each in named), _HELP],
    )


def commands_help(path: str, told: str, inner: Mapping[str, str], *, version: bool) -> str:
    """Return the help of several commands under one word: the first line of each one's own."""
    rows = [(name, each.partition("\n")[0]) for name, each in inner.items()]
    return _text(
        f"{path} [OPTIONS] COMMAND …", told, Commands=rows, Options=[*[_VERSION] * version, _HELP]
    )


def _text(usage: str, told: str, **tables: Sequence[tuple[str, str]]) -> str:
    width = max(_NARROWEST, min(get_terminal_size().columns, _WIDEST))
    paragraphs = (" ".join(each.split()) for each in told.split("\n\n"))
    filled = "\n\n".join(fill(each, width) for each in paragraphs if each)
    shown = (f"\n{title}:\n{_table(rows, width)}" for title, rows in tables.items() if rows)
    return f"Usage: {usage}\n\n{filled}\n{''.join(shown)}"


_VERSION = ("--version", "Print the version and exit.")
_HELP = ("--help", "Show this message and exit.")


def _names(option: Parameter) -> str:
    return " ".join(filter(None, (", ".join((*option.names, *option.off)), option.metavar)))


def _told(parameter: Parameter) -> str:
    shown = parameter.default if isinstance(parameter.default, int | str) else ""
    notes = ["required"] * parameter.required
    if shown not in ("", False, True):
        notes.append(f"default: {shown}")
    return " ".join((parameter.told.help, *(f"[{note}]" for note in notes)))


def _table(rows: Iterable[tuple[str, str]], width: int) -> str:
    return "".join(f"{line}\n" for name, told in rows for line in _row(name, told, width))


def _row(name: str, told: str, width: int) -> Iterator[str]:
    """Yield a name and what is told of it, beside it or, where it is long, below."""
    lines = wrap(told, width - _INDENT)
    if len(name) > _INDENT - 4:
        yield f"  {name}"
        name = ""
    for line in lines or [""]:
        yield f"  {name:{_INDENT - 2}}{line}"
        name = ""
