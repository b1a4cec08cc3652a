"""Numbers in columns out of a text file, whatever separates them and stands above them."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .rational_fits import Real

_NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eEdD][+-]?\d+)?|[+-]?(nan|inf|infinity)", re.I)
_COMMENT = re.compile(r"^\s*(#|%|//|!|;(?=\s))+\s*")
_LEAST_ROWS = 2
_MOST_BYTES = 200_000_000


class TextTable(NamedTuple):
    """Columns of numbers, (N, M), and the M names above them, none where there are none."""

    values: Real
    names: tuple[str, ...]


def read_table(path: Path, most_rows: int) -> TextTable:
    """Return the longest block of rows of numbers in a file, and the names above it.

    Blanks, tabs, commas and semicolons separate; with the others a comma may stand for the
    decimal point. Lines of other text may stand before and after, not within.

    Raises
    ------
    ValueError
        Where no such block is found, rows have unequal length, or are too many.
    """
    lines = _text(path).splitlines()
    if len(lines) > most_rows + 10_000:
        raise ValueError(
            f"{path}: {len(lines)} lines: expected {most_rows} at the most; average neighbouring "
            "lines, or leave out what lies far above the crossover"
        )
    split = _splitter(lines)
    rows = [split(line) for line in lines]
    numeric = [len(row) > 1 and all(map(_NUMBER.fullmatch, row)) for row in rows]
    start, stop = _block(path, lines, rows, numeric)
    values = [[_number(word) for word in row] for row in rows[start:stop]]
    return TextTable(np.array(values), _names(lines[:start], split, len(rows[start])))


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ValueError(f"{path}: is larger than {_MOST_BYTES // 10**6} MB; cut it")
        raw = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    for encoding in ("utf-8-sig", "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "latin-1"):
        try:
            return raw.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise ValueError(f"{path}: is no text; expected CSV, UFF 58 or .mat")


def _splitter(lines: list[str]) -> Callable[[str], list[str]]:
    """Return how to cut a line into words: by what gives most rows of numbers."""
    ways = [_by(";"), _by("\t"), _by_blanks, _by(",")]
    sample = lines if len(lines) < 400 else lines[:200] + lines[-200:]

    def score(way: Callable[[str], list[str]]) -> int:
        rows = [way(line) for line in sample]
        return sum(len(row) > 1 and all(map(_NUMBER.fullmatch, row)) for row in rows)

    return max(ways, key=score)


def _by(separator: str) -> Callable[[str], list[str]]:
    def cut(line: str) -> list[str]:
        words = [word.strip().strip('"') for word in _bare(line).rstrip().split(separator)]
        return words[:-1] if len(words) > 2 and not words[-1] else words

    return cut


def _by_blanks(line: str) -> list[str]:
    return _bare(line).split()


def _bare(line: str) -> str:
    return _COMMENT.sub("", line)


def _number(word: str) -> float:
    return float(word.replace(",", ".").replace("d", "e").replace("D", "E"))


def _block(
    path: Path, lines: list[str], rows: list[list[str]], numeric: list[bool]
) -> tuple[int, int]:
    """Return the first row of numbers and the one behind the last."""
    edges = [i for i, (a, b) in enumerate(pairwise([False, *numeric, False])) if a != b]
    blocks = [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= _LEAST_ROWS]
    if not blocks:
        only = sum(numeric)
        found = "one row of numbers" if only == 1 else "no rows of numbers"
        raise ValueError(
            f"{path}: {found}: expected lines of a frequency response in columns that blanks, "
            "tabs, commas or semicolons separate"
        )
    start, stop = max(blocks, key=lambda block: block[1] - block[0])
    width = len(rows[start])
    if any(len(rows[a]) == width for a in edges[::2] if a != start):
        gap = stop if any(a >= stop for a in edges[::2]) else start - 1
        raise ValueError(
            f"{path}: line {gap + 1} {lines[gap].strip()[:40]!r} is not a row of {width} numbers "
            "as those around it: expected them without gaps; mend it or leave it out"
        )
    widths = [len(row) for row in rows[start:stop]]
    odd = next((i for i, width in enumerate(widths) if width != widths[0]), None)
    if odd is not None:
        raise ValueError(
            f"{path}: line {start + odd + 1} has {widths[odd]} numbers, line {start + 1} has "
            f"{widths[0]}: expected as many in each; mend it or leave it out"
        )
    return start, stop


def _names(above: list[str], split: Callable[[str], list[str]], width: int) -> tuple[str, ...]:
    """Return the names in the last line of text that has as many as there are columns."""
    for line in reversed(above[-30:]):
        for words in (split(line), re.split(r"\s{2,}|\t", _bare(line).strip()), _with_units(line)):
            if len(words) == width and not any(map(_NUMBER.fullmatch, words)) and all(words):
                return tuple(words)
    return ()


def _with_units(line: str) -> list[str]:
    """Return names in a line of blanks, each with the unit in brackets behind it."""
    return re.findall(r"[^\s\[\]()]+(?:\s*[\[(][^\])]*[\])])?", _bare(line))
