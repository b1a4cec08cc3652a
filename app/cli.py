"""Commands that are functions: their annotated parameters are arguments and options.

Written here since no package does so without imports that cost more than many a command.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from .cli_parameters import (
    Argument,
    Option,
    Parameter,
    UsageError,
    end_of_options,
    near_word,
    parameters_of,
    values_of,
)

__all__ = ["Argument", "Command", "Commands", "Exit", "Option", "Parameter", "all_commands"]


class Exit(Exception):
    """The end of a command with a status."""

    def __init__(self, status: int = 0) -> None:
        super().__init__(status)
        self.status = status


@dataclass(frozen=True)
class Command:
    """A function as a command, by the words that call it."""

    path: str
    function: Callable[..., None]

    @property
    def help(self) -> str:
        """What it does, in paragraphs."""
        return self.function.__doc__ or ""

    @property
    def parameters(self) -> list[Parameter]:
        """Its parameters, in the function's order."""
        return parameters_of(self.function)

    def __call__(self, words: Sequence[str]) -> None:
        """Run it with the words behind its name."""
        if "--help" in words[: end_of_options(words)]:
            from .cli_help import command_help

            print(command_help(self.path, self.help, self.parameters), end="")
            return
        try:
            values = values_of(self.parameters, words)
        except UsageError as error:
            raise UsageError(f"{error}; see {self.path} --help") from None
        self.function(**values)


@dataclass(frozen=True)
class Commands:
    """Several commands under one word; called with no word they print their help.

    Parameters
    ----------
    help : str
    path : str
        The words that call them.
    version : callable, optional
        Prints the version, for ``--version``.
    """

    help: str
    path: str
    version: Callable[[], None] | None = None
    inner: dict[str, Command | Commands] = field(default_factory=dict)

    def command(self, name: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
        """Return a decorator that makes a function a command of this name."""

        def added(function: Callable[..., None]) -> Callable[..., None]:
            self.inner[name] = Command(f"{self.path} {name}", function)
            return function

        return added

    def add(self, commands: Commands) -> None:
        """Add commands under the last word of their own path."""
        self.inner[commands.path.rpartition(" ")[2]] = commands

    def __call__(self, words: Sequence[str]) -> None:
        """Run the command that the first word names with the others."""
        if not words or words[0] == "--help":
            from .cli_help import commands_help

            told = {name: each.help for name, each in self.inner.items()}
            with_version = self.version is not None
            print(commands_help(self.path, self.help, told, version=with_version), end="")
            raise Exit(0 if words else 2)
        if words[0] == "--version" and self.version is not None:
            self.version()
            return
        chosen = self.inner.get(words[0])
        if chosen is None:
            known = ["--help", *["--version"] * (self.version is not None), *self.inner]
            what = "option" if words[0].startswith("-") else "command"
            near = near_word(words[0].partition("=")[0], known)
            raise UsageError(f"no such {what} {words[0]!r}{near}; see {self.path} --help")
        chosen(words[1:])


def all_commands(commands: Commands) -> Iterator[Command | Commands]:
    """Yield commands and all below them."""
    yield commands
    for each in commands.inner.values():
        if isinstance(each, Commands):
            yield from all_commands(each)
        else:
            yield each
