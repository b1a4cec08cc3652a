"""Which library is taken on which machine."""

import platform
from pathlib import Path

import pytest

from jounce.fmu.importing.description import FmuDescription, FmuError
from jounce.fmu.importing.library import find_library
from jounce.fmu.importing.log import Log


@pytest.mark.parametrize(
    ("system", "machine", "version", "expected"),
    [
        ("Linux", "x86_64", "2.0", "linux64/m.so"),
        ("Linux", "x86_64", "3.0", "x86_64-linux/m.so"),
        ("Linux", "aarch64", "3.0", "aarch64-linux/m.so"),
        ("Windows", "AMD64", "2.0", "win64/m.dll"),
        ("Windows", "AMD64", "3.0.1", "x86_64-windows/m.dll"),
        ("Darwin", "arm64", "2.0", "darwin64/m.dylib"),
        ("Darwin", "arm64", "3.0", "aarch64-darwin/m.dylib"),
        ("Darwin", "x86_64", "3.0", "x86_64-darwin/m.dylib"),
    ],
)
def test_the_folder_of_each_platform(tmp_path, monkeypatch, system, machine, version, expected):
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
    says = FmuDescription(version, "m", "m", ("co-simulation",), "token")
    path = tmp_path / "binaries" / Path(expected)
    with pytest.raises(FmuError, match=f"this machine .{path.parent.name}.*, none at all: ask"):
        find_library(tmp_path, says)
    path.parent.mkdir(parents=True)
    path.touch()
    assert find_library(tmp_path, says) == path


def test_the_log_keeps_the_last_warnings_and_errors():
    log = Log()
    log.add(0, b"logAll", b"chatter")
    assert log.told() == " (and logged nothing)"
    for i in range(1000):
        log.add(3, b"logStatusError", f" problem {i} \n".encode())
    log.add(1, None, b"\xff odd bytes")
    assert len(log.messages) == 20
    assert log.told() == ": " + "; ".join(
        ["problem 996", "problem 997", "problem 998", "problem 999", "� odd bytes"]
    )
    assert log.messages == ()
