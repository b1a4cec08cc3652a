"""What to tell of a command line that does not fit: one line, as of any other bad input."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from collections.abc import Iterable

# Typer has click's errors under no public name of its own but this one's bases.
USAGE_ERRORS: tuple[type[Exception], ...] = (typer.BadParameter.__mro__[2],)


def usage_message(error: Exception) -> str:
    """Return the line to tell of one of `USAGE_ERRORS`; empty where its help was printed."""
    context = getattr(error, "ctx", None)
    option = str(getattr(error, "option_name", None))
    if context is not None and hasattr(error, "possibilities") and option.startswith("--"):
        return unknown_option(option, context)
    format_message = getattr(error, "format_message", lambda: str(error))
    told = " ".join(format_message().split()).replace("Value error, ", "").rstrip(".")
    place = f"; see {context.command_path} --help" if context is not None else ""
    return f"{told[:1].lower()}{told[1:]}{place}" if told else ""


def unknown_option(word: str, context: typer.Context) -> str:
    """Return what to tell of an option that a command does not have, or that stands after --."""
    name = word.partition("=")[0]
    known = [text for param in context.command.params for text in param.opts]
    if name in known:
        return f"{name} behind --, after which nothing is an option: write it before --"
    near = near_option(name, known)
    hint = f"did you mean {near}? " if near else ""
    return f"unknown option {name}: {hint}See {context.command_path} --help"


def near_option(word: str, known: Iterable[str]) -> str | None:
    """Return the option that a word begins, or else the one most like it."""
    options = [option for option in known if option.startswith("--")]
    begun = [option for option in options if len(word) > 2 and option.startswith(word)]
    return next(iter(begun or get_close_matches(word, options, n=1)), None)
