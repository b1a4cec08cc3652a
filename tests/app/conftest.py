"""The command line run within a test, and a scenario written for one."""

import sys
from collections.abc import Callable
from pathlib import Path

import compiled_once
import pytest

from jounce.app import command_line

binaries_compiled_once = compiled_once.binaries_compiled_once


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


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    """Write the text of a scenario; give its file."""

    def write_text(text: str) -> Path:
        path = tmp_path / "case.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write_text


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"
