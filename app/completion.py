"""Shell completion: a script with all commands, options and choices, for bash, zsh and fish."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import EnumType, StrEnum
from inspect import unwrap
from typing import Any, get_type_hints


class Shell(StrEnum):
    """Shells that a script is written for."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"


_PLAIN = str.maketrans({"'": "’"} | dict.fromkeys('"`$\\', ""))

_BASH = """\
_jounce() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
    local command="" i words=""
    for ((i = 1; i < COMP_CWORD; i++)); do
        case "$command ${{COMP_WORDS[i]}}" in
            {commands}) command="$command ${{COMP_WORDS[i]}}" ;;
        esac
    done
    COMPREPLY=()
    case "$command $before" in
{choices}
        {valued}) return ;;
    esac
    case "$command" in
{words}
    esac
    if [[ $word == -* || -z $command || "|{groups}|" == *"|$command|"* ]]; then
        COMPREPLY=($(compgen -W "$words" -- "$word"))
    fi
}}
complete -o default -F _jounce jounce
"""
_FISH = """\
function __jounce_in
    set -l command ""
    for word in (commandline -opc)[2..-1]
        switch "$command $word"
            case {commands}
                set command "$command $word"
        end
    end
    test "$command" = "$argv[1]"
end
"""
_ZSH = """\
#compdef jounce
autoload -U +X compinit && compinit
autoload -U +X bashcompinit && bashcompinit
"""


@dataclass(frozen=True)
class _Option:
    names: tuple[str, ...]
    help: str
    takes_value: bool
    choices: tuple[str, ...]


@dataclass(frozen=True)
class _Command:
    """A command by the words that call it, after the program's own name.

    What may stand behind it is `below` (of a group) or `values` (in the place of files).
    """

    words: tuple[str, ...]
    help: str
    options: tuple[_Option, ...]
    below: tuple[str, ...]
    values: tuple[str, ...]

    @property
    def key(self) -> str:
        return "".join(f" {word}" for word in self.words)


def completion_script(root: Any, shell: Shell) -> str:
    """Return what a shell has to read so that it completes the commands of a program.

    Files are completed as ever where a file may stand. No Python is run at a press of the key.

    Parameters
    ----------
    root : click.Group
        As `typer.main.get_command` gives it.
    shell : Shell
    """
    commands = list(_commands(root, ()))
    if shell is Shell.FISH:
        return "".join(_fish(commands))
    return (_ZSH if shell is Shell.ZSH else "") + _bash(commands)


def _commands(command: Any, words: tuple[str, ...]) -> Iterator[_Command]:
    below = getattr(command, "commands", {})
    hints = get_type_hints(unwrap(command.callback)) if command.callback else {}
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [_option(each, hints) for each in command.params if each not in arguments]
    values = [value for each in arguments for value in _choices(hints.get(each.name))]
    told = str(command.help or "").partition("\n")[0].translate(_PLAIN)
    yield _Command(words, told, (*options, _HELP), tuple(below), tuple(values))
    for name, each in below.items():
        yield from _commands(each, (*words, name))


def _option(param: Any, hints: Mapping[str, Any]) -> _Option:
    names = (*param.opts, *param.secondary_opts)
    told = str(param.help or "").partition(". ")[0].translate(_PLAIN)
    return _Option(names, told, not param.is_flag, _choices(hints.get(param.name)))


_HELP = _Option(("--help",), "Show this message and exit.", False, ())


def _choices(kind: Any) -> tuple[str, ...]:
    members: Iterable[Any] = kind if isinstance(kind, EnumType) else ()
    return tuple(str(each.value) for each in members)


def _bash(commands: list[_Command]) -> str:
    asked = [(c, option) for c in commands for option in c.options if option.takes_value]
    return _BASH.format(
        commands="|".join(f'"{c.key}"' for c in commands if c.words),
        groups="|".join(c.key for c in commands if c.below or c.values),
        valued="|".join(f'"{c.key} {n}"' for c, o in asked if not o.choices for n in o.names),
        choices="\n".join(_bash_choices(c, o) for c, o in asked if o.choices),
        words="\n".join(f'        "{c.key}") words="{" ".join(_words(c))}" ;;' for c in commands),
    )


def _bash_choices(command: _Command, option: _Option) -> str:
    places = "|".join(f'"{command.key} {name}"' for name in option.names)
    words = " ".join(option.choices)
    return f'        {places}) COMPREPLY=($(compgen -W "{words}" -- "$word")); return ;;'


def _words(command: _Command) -> list[str]:
    names = (name for option in command.options for name in option.names)
    return [*command.below, *command.values, *names]


def _fish(commands: list[_Command]) -> Iterator[str]:
    yield _FISH.format(commands=" ".join(f"'{c.key}'" for c in commands if c.words))
    for c in commands:
        here = f"complete -c jounce -n \"__jounce_in '{c.key}'\""
        for name in c.below:
            told = next(b.help for b in commands if b.words == (*c.words, name))
            yield f"{here} -f -a {name} -d '{told}'\n"
        if c.values:
            yield f"{here} -f -a '{' '.join(c.values)}'\n"
        for option in c.options:
            yield f"{here} {_fish_option(option)} -d '{option.help}'\n"


def _fish_option(option: _Option) -> str:
    words = [f"-l {n[2:]}" if n.startswith("--") else f"-s {n[1:]}" for n in option.names]
    if option.choices:
        words.append(f"-x -a '{' '.join(option.choices)}'")
    elif option.takes_value:
        words.append("-r")
    return " ".join(words)
