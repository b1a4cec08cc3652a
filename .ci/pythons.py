"""Print a Python of this machine: `pythons.py oldest` that jounce is for, or `pythons.py newest`.

Looked for on the path and among pyenv's; without the oldest nothing is printed.
"""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ASK = "import ensurepip, sys; print(*sys.version_info[:2], sys.version_info.releaselevel)"
PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
OLDEST = tuple(map(int, PROJECT["project"]["requires-python"].removeprefix(">=").split(".")))


def found() -> dict[tuple[int, ...], str]:
    """Return a path for each minor version that has been released and can make environments."""
    folders = [*os.get_exec_path(), *Path("~/.pyenv/versions").expanduser().glob("*/bin")]
    named = (path for folder in folders for path in Path(folder).glob("python3.*"))
    paths = [sys.executable, *(path for path in named if re.fullmatch(r"python3\.\d+", path.name))]
    pythons: dict[tuple[int, ...], str] = {}
    for path in paths:
        asked = subprocess.run([path, "-c", ASK], capture_output=True, text=True, check=False)
        if asked.returncode == 0 and asked.stdout.endswith("final\n"):
            major, minor, _ = asked.stdout.split()
            pythons.setdefault((int(major), int(minor)), str(path))
    return {version: path for version, path in pythons.items() if version >= OLDEST}


if __name__ == "__main__":
    here = found()
    print(here.get(OLDEST, "") if sys.argv[1:] == ["oldest"] else here[max(here)])
