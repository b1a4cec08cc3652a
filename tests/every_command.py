"""The commands of the command line, as Typer has them."""

from typing import Any

from typer.main import get_command

from jounce.app.command_line import app


def _under(group: Any, words: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, command in group.commands.items():
        below = f"{words}{name}"
        found |= _under(command, f"{below} ") if hasattr(command, "commands") else {below: command}
    return found


_FOUND = _under(get_command(app))
COMMANDS = tuple(_FOUND)


def command_of(name: str) -> Any:
    return _FOUND[name]


def options_of(name: str) -> set[str]:
    words = {option for param in command_of(name).params for option in param.opts}
    return {word for word in words if word.startswith("-")}
