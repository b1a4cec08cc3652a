"""What runs of FMUs print and write."""

import csv
from pathlib import Path

import numpy as np

DT = 0.125
ENDS = (("u", "input"), ("y", "output"))


def columns(path):
    with Path(path).open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def rows(out):
    return {row[0]: row[1:] for row in map(str.split, out.splitlines()) if row}
