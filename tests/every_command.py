"""The commands of the command line."""

from jounce.app.cli import Command, all_commands
from jounce.app.command_line import app

_FOUND = {
    each.path.removeprefix("jounce "): each
    for each in all_commands(app)
    if isinstance(each, Command)
}
COMMANDS = tuple(_FOUND)


def command_of(name: str) -> Command:
    return _FOUND[name]


def options_of(name: str) -> set[str]:
    return {option for each in command_of(name).parameters for option in each.names}
