"""The command `jounce completion`: a script with commands and options, for bash, zsh and fish."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

from .cli import Argument, Command, Commands, Parameter, all_commands
from .common_options import AS_JSON, QUIET
from .printing import print_text


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
class _Place:
    """What may stand behind the words that call a command, or commands.

    Attributes
    ----------
    key : str
        The words, after the program's own name, each behind a space.
    help : str
    options : tuple of Parameter
    words : tuple of str
        What may stand there besides options, in the place of files.
    """

    key: str
    help: str
    options: tuple[Parameter, ...]
    words: tuple[str, ...]

    @property
    def all_words(self) -> str:
        names = (name for option in self.options for name in (*option.names, *option.off))
        return " ".join((*self.words, *names, "--help"))


def completion_script(root: Commands, shell: Shell) -> str:
    """Return what a shell has to read so that it completes the commands of a program.

    Files are completed as ever where a file may stand. No Python is run at a press of the key.
    """
    places = [_place(each, len(root.path)) for each in all_commands(root)]
    if shell is Shell.FISH:
        return "".join(_fish(places))
    return (_ZSH if shell is Shell.ZSH else "") + _bash(places)


def _place(of: Command | Commands, start: int) -> _Place:
    told = of.help.partition("\n")[0].translate(_PLAIN)
    if isinstance(of, Commands):
        return _Place(of.path[start:], told, (), tuple(of.inner))
    options = tuple(each for each in of.parameters if each.names)
    words = tuple(word for each in of.parameters if not each.names for word in each.choices)
    return _Place(of.path[start:], told, options, words)


def _takes_value(option: Parameter) -> bool:
    return option.kind is not bool


def _bash(places: list[_Place]) -> str:
    asked = [(p.key, o) for p in places for o in p.options if _takes_value(o)]
    return _BASH.format(
        commands="|".join(f'"{p.key}"' for p in places if p.key),
        groups="|".join(p.key for p in places if p.words),
        valued="|".join(f'"{key} {n}"' for key, o in asked if not o.choices for n in o.names),
        choices="\n".join(_bash_choices(key, o) for key, o in asked if o.choices),
        words="\n".join(f'        "{p.key}") words="{p.all_words}" ;;' for p in places),
    )


def _bash_choices(key: str, option: Parameter) -> str:
    found = "|".join(f'"{key} {name}"' for name in option.names)
    words = " ".join(option.choices)
    return f'        {found}) COMPREPLY=($(compgen -W "{words}" -- "$word")); return ;;'


def _fish(places: list[_Place]) -> Iterator[str]:
    yield _FISH.format(commands=" ".join(f"'{p.key}'" for p in places if p.key))
    told = {p.key: p.help for p in places}
    for p in places:
        here = f"complete -c jounce -n \"__jounce_in '{p.key}'\""
        for word in p.words:
            yield f"{here} -f -a {word} -d '{told.get(f'{p.key} {word}', '')}'\n"
        for option in p.options:
            text = option.told.help.partition(". ")[0].translate(_PLAIN)
            yield f"{here} {_fish_option(option)} -d '{text}'\n"
        yield f"{here} -l help -d 'Show this message and exit.'\n"


def _fish_option(option: Parameter) -> str:
    names = (*option.names, *option.off)
    words = [f"-l {n[2:]}" if n.startswith("--") else f"-s {n[1:]}" for n in names]
    if option.choices:
        words.append(f"-x -a '{' '.join(option.choices)}'")
    elif _takes_value(option):
        words.append("-r")
    return " ".join(words)


def completion_command(
    shell: Annotated[Shell, Argument(help="bash, zsh or fish.")],
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Print what a shell needs to complete commands and options.

    bash: eval "$(jounce completion bash)" in ~/.bashrc.

    zsh: eval "$(jounce completion zsh)" in ~/.zshrc.

    fish: jounce completion fish > ~/.config/fish/completions/jounce.fish
    """
    from .command_line import app

    script = completion_script(app, shell)
    if as_json:
        from .json_output import print_json

        print_json({"shell": shell.value, "script": script})
        return
    print_text(script)
