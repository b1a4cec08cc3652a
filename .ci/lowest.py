"""Print the lowest releases that pyproject.toml admits, as constraints for pip."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))

for requirement in [
    *PROJECT["project"]["dependencies"],
    *PROJECT["project"]["optional-dependencies"]["dev"],
]:
    name, bounded, rest = requirement.partition(">=")
    if not bounded:
        raise SystemExit(f"{requirement!r} in pyproject.toml: expected a lowest release, name>=1.2")
    print(f"{name.partition('[')[0]}=={rest}")  # constraints have no extras
