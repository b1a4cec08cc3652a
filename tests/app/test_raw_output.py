"""Nothing but results on standard output, whatever writes there: Python or a C library."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
TELESCOPE = str(EXAMPLES / "telescope.toml")
ORDER_5 = ("--velocity", "2 deg/s", "--acceleration", "1 deg/s^2", "--jerk", "2 deg/s^3",
           "--snap", "8 deg/s^4", "--crackle", "40 deg/s^5")  # fmt: skip
COMMANDS = {
    "help": ("--help",),
    "version": ("--version",),
    "help of plan": ("plan", "--help"),
    "order 2": ("plan", "60 arcsec", "--acceleration", "0.2 deg/s^2"),
    "order 5": ("plan", "0.5 deg", *ORDER_5, "--csv", "move.csv", "--plot", "move.png"),
    "proof": ("plan", "0.5 deg", *ORDER_5, "--certify"),
    "survey": ("survey", TELESCOPE, "--output", "out"),
    "check": ("check", TELESCOPE, "--all", "--junit", "check.xml"),
    "export": ("fmu", "export", TELESCOPE, "--block", "plant", "--output", "plant.fmu"),
    "inspect": ("fmu", "inspect", "plant.fmu"),
    "run": ("fmu", "run", "plant.fmu", "--duration", "0.1", "--step", "0.01", "--csv", "run.csv"),
}
# Python's own output goes to a file for each command: what is left on descriptor 1 is not ours.
ALL_IN_ONE_PROCESS = f"""
import os, sys
from jounce.app.command_line import main
for number, arguments in enumerate({list(COMMANDS.values())!r}):
    os.write(1, f"{{number}}\\n".encode())
    sys.argv = ["jounce", *arguments]
    with open(f"{{number}}.txt", "w", encoding="utf-8") as sys.stdout:
        try:
            main()
        except SystemExit as end:
            assert not end.code, arguments
    sys.stdout = sys.__stdout__
"""


def raw(folder, code, *arguments):
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=folder, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Return the folder of all commands, and what they left on descriptor 1 itself."""
    folder = tmp_path_factory.mktemp("ran")
    return folder, raw(folder, ALL_IN_ONE_PROCESS).decode().splitlines()


def test_no_library_writes_to_standard_output(ran):
    assert ran[1] == [str(number) for number in range(len(COMMANDS))]


@pytest.mark.parametrize(
    ("command", "begin"),
    [
        ("version", "jounce "),
        ("order 2", "Move of order 2"),
        ("order 5", "Move of order 5"),
        ("proof", "Move of order 5"),
        ("survey", "Telescope axis"),
        ("export", "Wrote plant.fmu"),
    ],
)
def test_output_begins_with_the_result(ran, command, begin):
    text = (ran[0] / f"{list(COMMANDS).index(command)}.txt").read_text(encoding="utf-8")
    assert text.lstrip().startswith(begin)


def test_a_command_by_itself_prints_the_same(ran, tmp_path):
    code = "from jounce.app.command_line import main; main()"
    text = (ran[0] / f"{list(COMMANDS).index('proof')}.txt").read_bytes()
    assert raw(tmp_path, code, *COMMANDS["proof"]) == text
