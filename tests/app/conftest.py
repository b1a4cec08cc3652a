"""The command line run within a test."""

import sys

import pytest

from jounce.app import command_line


@pytest.fixture
def run(monkeypatch, capsys):
    """Run main() in this process; give status, what it printed, and its lines of errors."""

    def call(*arguments: object) -> tuple[int, str, list[str]]:
        monkeypatch.setattr(sys, "argv", ["jounce", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            command_line.main()
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return int(end.value.code or 0), out, err.splitlines()

    return call
