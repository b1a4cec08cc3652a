"""Try a wheel in a clean environment in which no compiler is found. Usage: try_wheel.py WHEEL."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path
from tempfile import TemporaryDirectory

TRIAL = """
from jounce.shaping import Limits, min_time_transfer
move = min_time_transfer((0.0, 1.0, 0.0), (2.0,), Limits(1.0, 1.0, 1.0))
assert abs(float(move(move.duration)) - 2.0) < 1e-12, move
print("planned", move)
"""


def main(wheel: str) -> None:
    """Install the wheel and all that it needs, and plan a motion."""
    with TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = Path(folder) / "bin" / "python"
        bare = {**os.environ, "PATH": str(python.parent)}
        bare.pop("CC", None)
        install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        for call in ([*install, "--only-binary=:all:", wheel], ["-c", TRIAL]):
            subprocess.run([python, *call], env=bare, cwd=folder, check=True)


if __name__ == "__main__":
    main(str(Path(sys.argv[1]).resolve()))
