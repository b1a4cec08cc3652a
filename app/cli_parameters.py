"""A function's annotated parameters as arguments and options of a command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from enum import EnumType
from inspect import Parameter as Declared
from inspect import signature
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints


class UsageError(ValueError):
    """A command line that does not fit; one line that says so."""


class Argument:
    """What a parameter is that is given by its place; in ``Annotated[Path, Argument(…)]``."""

    def __init__(self, *, help: str, metavar: str | None = None) -> None:
        self.help, self.metavar, self.names, self.callback = help, metavar, (), None


class Option:
    """What a parameter is that is given by a name, such as ``--output``.

    Without names it has that of the parameter; a bool then has ``--no-…``, too. `callback` is told
    the value before the command runs.
    """

    def __init__(
        self,
        *names: str,
        help: str,
        metavar: str | None = None,
        callback: Callable[[Any], object] | None = None,
    ) -> None:
        self.help, self.metavar, self.names, self.callback = help, metavar, names, callback


@dataclass(frozen=True)
class Parameter:
    """A parameter of a command.

    Attributes
    ----------
    name : str
        Of the function's parameter.
    names, off : tuple of str
        Options that give it, and that turn it off; none of an argument.
    kind : type
        bool, str, int, Path or an enumeration.
    many : bool
        Whether it is a list.
    required : bool
    default : object
    told : Argument or Option
    """

    name: str
    names: tuple[str, ...]
    off: tuple[str, ...]
    kind: Any
    many: bool
    required: bool
    default: Any
    told: Argument | Option

    @property
    def choices(self) -> tuple[str, ...]:
        """The words that it may be; none where it may be any."""
        return tuple(str(each.value) for each in self.kind) if self._is_choice else ()

    @property
    def metavar(self) -> str:
        """The word that stands for its value."""
        if self.told.metavar:
            return self.told.metavar
        if not self.names:
            return self.name.upper() + "…" * self.many
        kinds = {str: "TEXT", int: "INTEGER", Path: "PATH", bool: ""}
        return "|".join(self.choices) or kinds[self.kind]

    @property
    def _is_choice(self) -> bool:
        return isinstance(self.kind, EnumType)

    def value(self, text: str) -> Any:
        """Return the value that a text is; UsageError where it is none."""
        name = self.names[0] if self.names else self.metavar
        try:
            return self.kind(text)
        except ValueError:
            expected = ", ".join(map(repr, self.choices)) or "a whole number"
            of = "one of " * self._is_choice
            raise UsageError(f"{name} {text!r}: expected {of}{expected}") from None


def parameters_of(function: Callable[..., None]) -> list[Parameter]:
    """Return the parameters of a function, in its order."""
    hints = get_type_hints(function, include_extras=True)
    return [_parameter(each, hints[each.name]) for each in signature(function).parameters.values()]


def near_word(word: str, known: Sequence[str]) -> str:
    """Return the question whether another word is meant, that begins so or is most like it."""
    begun = [each for each in known if len(word) > 2 and each.startswith(word)]
    near = next(iter(begun or get_close_matches(word, known, n=1)), None)
    return f": did you mean {near}?" if near else ""


def _parameter(declared: Declared, hint: Any) -> Parameter:
    """Return the parameter of an ``Annotated[kind | None, told]``, of a list or of one value."""
    kind, told = get_args(hint)
    if NoneType in get_args(kind):
        kind = get_args(kind)[0]
    many = get_origin(kind) is list
    kind = get_args(kind)[0] if many else kind
    word = declared.name.replace("_", "-")
    bare = isinstance(told, Option) and not told.names
    names = (f"--{word}",) if bare else told.names
    off = (f"--no-{word}",) if bare and kind is bool else ()
    required = declared.default is Declared.empty
    default = None if required else declared.default
    return Parameter(declared.name, names, off, kind, many, required, default, told)


def values_of(parameters: Sequence[Parameter], words: Sequence[str]) -> dict[str, Any]:
    """Return the values of all parameters, by the function's names."""
    given, places = _options(parameters, words)
    values = {each.name: each.default for each in parameters} | given
    for each in parameters:
        if not each.names:
            taken = places if each.many else places[:1]
            places = places[len(taken) :]
            if taken:
                found = [each.value(word) for word in taken]
                values[each.name] = found if each.many else found[0]
        if each.required and values[each.name] is None:
            what = f"option {each.names[0]}" if each.names else f"argument {each.name!r}"
            raise UsageError(f"missing {what}")
    if places:
        raise UsageError(f"unexpected {places[0]!r}")
    for each in parameters:
        if each.told.callback is not None:
            each.told.callback(values[each.name])
    return values


def _options(
    parameters: Sequence[Parameter], words: Sequence[str]
) -> tuple[dict[str, Any], list[str]]:
    """Return the values of the options that words give, and the words that are none."""
    known = {name: each for each in parameters for name in (*each.names, *each.off)}
    given, places = dict[str, Any](), list[str]()
    end = end_of_options(words)
    left = iter(words[:end])
    for word in left:
        name, value = _parted(word, known)
        option = known.get(name)
        if option is None:
            if name.startswith("--"):
                near = near_word(name, [each for each in known if each.startswith("--")])
                raise UsageError(f"unknown option {name}{near}")
            places.append(word)
        elif option.kind is bool:
            if value is not None:
                raise UsageError(f"{name} takes no value, and {value!r} is given")
            given[option.name] = name not in option.off
        else:
            text = next(left, None) if value is None else value
            if text is None or (value is None and text in known):
                raise UsageError(f"option {name} requires an argument")
            found = option.value(text)
            given[option.name] = [*given.get(option.name, []), found] if option.many else found
    for word in words[end + 1 :]:
        if word in known:
            raise UsageError(
                f"{word} behind --, after which nothing is an option: write it before --"
            )
    return given, [*places, *words[end + 1 :]]


def _parted(word: str, known: dict[str, Parameter]) -> tuple[str, str | None]:
    """Return the name of an option and its value, in ``--name=value`` and ``-nvalue``."""
    if word.startswith("--"):
        name, sign, value = word.partition("=")
        return name, value if sign else None
    if word not in known and word[:2] in known:
        return word[:2], word[2:]
    return word, None


def end_of_options(words: Sequence[str]) -> int:
    """Return where ``--`` is, behind which nothing is an option; else how many words there are."""
    return list(words).index("--") if "--" in words else len(words)
