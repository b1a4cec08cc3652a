"""Count what comes of the edge grid: transfers between states exactly at their bounds."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests"))

import edge_grid  # noqa: E402  (the tests' own grid)


def table() -> str:
    """Return the counts in Markdown."""
    found, wrong = edge_grid.count(edge_grid.problems())
    rows = [
        ("problems", sum(found.values())),
        *((name, found[name]) for name in edge_grid.OUTCOMES),
    ]
    lines = ["| of the edge grid | count |", "| --- | ---: |"]
    lines += [f"| {name} | {number:,} |" for name, number in rows]
    return "\n".join([*lines, *wrong])


if __name__ == "__main__":
    print(table())
