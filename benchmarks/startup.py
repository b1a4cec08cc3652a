"""CPU time of whole processes: the import of the shapers, and a survey with its pictures.

Run: python benchmarks/startup.py
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from timing import table

TELESCOPE = Path(__file__).parent.parent / "examples" / "telescope.toml"
RUNS = 5


def cpu_seconds(command: list[str]) -> float:
    """Return user and system time of one run of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: command, least and median CPU seconds."""
    python = sys.executable
    with tempfile.TemporaryDirectory() as folder:
        main = "from jounce.app.command_line import main; main()"
        survey = [python, "-c", main, "survey", str(TELESCOPE), "--output", folder]
        commands = {
            "`python -c 'import numpy'`": [python, "-c", "import numpy"],
            "`python -c 'import jounce.shaping'`": [python, "-c", "import jounce.shaping"],
            "`python -c 'import control'`": [python, "-c", "import control"],
            "`jounce survey examples/telescope.toml`": survey,
        }
        taken = {name: [cpu_seconds(c) for _ in range(RUNS)] for name, c in commands.items()}
    return [(name, f"{min(t):.2f} s", f"{median(t):.2f} s") for name, t in taken.items()]


HEADER = ("command", "least CPU", "median CPU")

if __name__ == "__main__":
    print(table(HEADER, rows()))
