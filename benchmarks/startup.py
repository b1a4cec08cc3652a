"""CPU time of whole processes beside an import: commands, and a picture after matplotlib's import.

Each command stands beside the import that it is held against, all taken in turn in one run; the
ratio is that of the least times. Modules are compiled once, as an installation's are.

Run: python benchmarks/startup.py
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from timing import table

EXAMPLES = Path(__file__).parent.parent / "examples"
MAIN = "from jounce.app.command_line import main; main()"
RUNS = 5
DRAWN = """
import matplotlib.figure, matplotlib.backends.backend_agg, sys
from time import process_time
from jounce.shaping import Limits, min_time_move
move = min_time_move(60.0, Limits(velocity=2000.0, acceleration=720.0, jerk=7200.0))
before = process_time()
move.plot().savefig(sys.argv[1])
print(process_time() - before)
"""
COMPILED_ONCE = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
MOVE = ("60 arcsec", "--velocity", "1 deg/s", "--acceleration", "1 deg/s^2", "--jerk", "9 deg/s^3")


def cpu_seconds(command: list[str]) -> float:
    """Return user and system time of one run of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=COMPILED_ONCE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def commands(folder: str) -> dict[str, tuple[list[str], str]]:
    """Return command lines by name, each with what it is held against."""
    python = sys.executable
    jounce = [python, "-c", MAIN]
    found = {
        f"import {name}": ([python, "-c", f"import {name}"], "")
        for name in ("numpy", "control", "jounce.shaping")
    }
    found["import jounce.shaping"] = (found["import jounce.shaping"][0], "import numpy")
    found["jounce plan"] = ([*jounce, "plan", *MOVE], "import numpy")
    check = [*jounce, "check", str(EXAMPLES / "telescope.toml")]
    found["jounce check telescope"] = (check, "import control")
    for name in ("telescope", "telescope_azimuth"):
        survey = [*jounce, "survey", str(EXAMPLES / f"{name}.toml")]
        found[f"jounce survey {name}"] = (survey, "import control")
        drawn = [*survey, "--output", folder]
        found[f"jounce survey {name} --output"] = (drawn, "import control")
    return found


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: command, least CPU seconds, their ratio to an import."""
    with tempfile.TemporaryDirectory() as folder:
        lines = commands(folder)
        taken: dict[str, list[float]] = {name: [] for name in lines}
        for _ in range(RUNS):
            for name, (line, _) in lines.items():
                taken[name].append(cpu_seconds(line))
        drawn = min(_drawing(folder) for _ in range(RUNS))
    least = {name: min(times) for name, times in taken.items()}
    told = [
        (f"`{name}`", f"{least[name]:.2f} s", _beside(least, name, against))
        for name, (_, against) in lines.items()
    ]
    return [*told, ("`move.plot()` to a PNG, matplotlib imported before", f"{drawn:.2f} s", "")]


def _beside(least: dict[str, float], name: str, against: str) -> str:
    return f"{least[name] / least[against]:.2f} × `{against}`" if against else ""


def _drawing(folder: str) -> float:
    """Return the CPU time of the first picture of a process."""
    command = [sys.executable, "-c", DRAWN, str(Path(folder) / "move.png")]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=COMPILED_ONCE)
    return float(done.stdout)


HEADER = ("process", "least CPU", "ratio")

if __name__ == "__main__":
    print(table(HEADER, rows()))
