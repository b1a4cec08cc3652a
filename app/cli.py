"""Commands that are functions: argparse reads what their annotated parameters declare.

A command's module is imported when the command is asked for.
"""

from __future__ import annotations

from argparse import ArgumentTypeError, BooleanOptionalAction
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from inspect import signature
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from .cli_parser import Parser

_HELP = "Show this message and exit."
_VERSION = "Print the version and exit."
_KINDS = {str: "TEXT", int: "INTEGER", Path: "PATH", bool: ""}


def _whole_number(word: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise ArgumentTypeError(f"{word!r}: expected a whole number, such as 2") from None


def _path(word: str) -> Path:
    if not word.strip():  # as of a variable of the shell that is not set
        raise ArgumentTypeError(f"{word!r}: expected the path of a file or folder")
    return Path(word)


_READ: dict[Any, Callable[[str], Any]] = {int: _whole_number, Path: _path}


@dataclass(frozen=True)
class Argument:
    """What a parameter is that is given by its place; in ``Annotated[Path, Argument(help=…)]``."""

    help: str
    metavar: str | None = None
    names: tuple[str, ...] = ()
    callback: Callable[[Any], object] | None = None


class Option(Argument):
    """What a parameter is that is given by a name, such as ``--output``.

    Without names it has that of the parameter; a bool then has ``--no-…``, too. `callback` is told
    the value before the command runs.
    """

    def __init__(self, *names: str, help: str, **more: Any) -> None:
        super().__init__(help, names=names, **more)


@dataclass(frozen=True)
class Parameter:
    """A parameter of a function: its options, those that turn it off, the kind of its values."""

    name: str
    names: tuple[str, ...]
    off: tuple[str, ...]
    kind: Any
    many: bool
    required: bool
    default: Any
    told: Argument

    @property
    def choices(self) -> dict[str, Any]:
        """What each word stands for; none where it may be any."""
        members = getattr(self.kind, "__members__", {})  # of an enumeration
        return {str(each.value): each for each in members.values()}

    @property
    def metavar(self) -> str:
        """The word that stands for its value."""
        of_place = "" if self.names else self.name.upper() + "…" * self.many
        return self.told.metavar or of_place or "|".join(self.choices) or _KINDS[self.kind]

    def add_to(self, group: Any) -> None:
        """Declare it to argparse; what is not given is left to the function's own default."""
        how: dict[str, Any] = {"help": f"{self.told.help}{self._note()}".replace("%", "%%")}
        if self.kind is bool:
            how["action"] = BooleanOptionalAction if self.off else "store_true"
        else:
            choices = self.choices
            read = _READ.get(self.kind, self.kind)
            how["type"] = (lambda word: choices.get(word, word)) if choices else read
            how["choices"] = list(choices) or None
        if not self.names:
            group.add_argument(
                self.name, nargs="+*"[not self.required] if self.many else None, **how
            )
            return
        if self.kind is not bool:
            how |= {"metavar": self.metavar, "action": "append" if self.many else "store"}
        group.add_argument(*self.names, dest=self.name, required=self.required, **how)

    def _note(self) -> str:
        shown = isinstance(self.default, str | int) and self.default not in ("", False, True)
        return " [required]" * self.required + f" [default: {self.default}]" * shown


def _parameters_of(function: Callable[..., None]) -> Iterator[Parameter]:
    """Yield what ``name: Annotated[kind | None, told]`` declares, of a list or of one value."""
    hints = get_type_hints(function, include_extras=True)
    for name, each in signature(function).parameters.items():
        kind, told = get_args(hints[name])
        kind = get_args(kind)[0] if NoneType in get_args(kind) else kind
        many = get_origin(kind) is list
        kind = get_args(kind)[0] if many else kind
        word = name.replace("_", "-")
        bare = isinstance(told, Option) and not told.names
        names = (f"--{word}",) if bare else told.names
        off = (f"--no-{word}",) if bare and kind is bool else ()
        required = each.default is each.empty
        default = None if required else each.default
        yield Parameter(name, names, off, kind, many, required, default, told)


@dataclass(frozen=True)
class Command:
    """A function as a command, by the words that call it.

    `place` is where the function stands: ``"module:function"``, of this package.
    """

    path: str
    place: str

    @property
    def function(self) -> Callable[..., None]:
        """The function, its module imported."""
        module, _, name = self.place.partition(":")
        found: Callable[..., None] = getattr(import_module(f".{module}", __package__), name)
        return found

    @property
    def help(self) -> str:
        """What it does, in paragraphs."""
        return self.function.__doc__ or ""

    @property
    def parameters(self) -> list[Parameter]:
        """Its parameters, in the function's order."""
        return list(_parameters_of(self.function))

    def __call__(self, words: Sequence[str]) -> None:
        """Run it with the words behind its name."""
        parameters = self.parameters
        places = [each for each in parameters if not each.names]
        usage = (each.metavar if each.required else f"[{each.metavar}]" for each in places)
        parser = Parser(self.path, " ".join(usage), self.help)
        groups = [parser.add_argument_group(title) for title in ("Arguments", "Options")]
        for each in parameters:
            each.add_to(groups[bool(each.names)])
        groups[1].add_argument("--help", action="help", help=_HELP)
        parser.check_names(words)
        values = vars(parser.parse_intermixed_args(words))
        for each in parameters:
            if each.told.callback is not None:
                each.told.callback(values.get(each.name, each.default))
        self.function(**values)


@dataclass(frozen=True)
class Commands:
    """Commands under one word, `path`; called alone they print their help.

    `places` has by name the `place` of a command, or other commands. `version` prints it, for
    ``--version``.
    """

    path: str
    help: str
    places: Mapping[str, str | Commands]
    version: Callable[[], None] | None = None

    @property
    def inner(self) -> dict[str, Command | Commands]:
        """The commands by name."""
        return {
            name: Command(f"{self.path} {name}", each) if isinstance(each, str) else each
            for name, each in self.places.items()
        }

    def __call__(self, words: Sequence[str]) -> None:
        """Run the command that the first word names with the others, which it alone parses."""
        chosen = self.inner.get(next(iter(words), ""))
        if chosen is not None:
            chosen(words[1:])
        else:
            self._call_alone(words)

    def _call_alone(self, words: Sequence[str]) -> None:
        """Do what the options say, or refuse the words."""
        parser = Parser(self.path, "COMMAND …", self.help)
        commands = parser.add_subparsers(title="Commands", metavar="COMMAND", dest="command")
        for name, each in self.inner.items():
            commands.add_parser(name, help=each.help.partition("\n")[0])
        options = parser.add_argument_group("Options")
        if self.version is not None:
            options.add_argument("--version", action="store_true", help=_VERSION)
        options.add_argument("--help", action="help", help=_HELP)
        if not words:
            parser.print_help()
            raise SystemExit(2)
        parser.check_names(words[:1])
        parser.parse_args(words[:1])
        if self.version is not None:
            self.version()


def all_commands(commands: Commands) -> Iterator[Command | Commands]:
    """Yield commands and all below them."""
    yield commands
    for each in commands.inner.values():
        yield from all_commands(each) if isinstance(each, Commands) else [each]
