"""Logs in CSV files: times and positions of an axis, by name or number of the column."""

from __future__ import annotations

import csv
from array import array
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator, Sequence
from itertools import islice
from math import isinf, isnan, nan
from operator import index
from pathlib import Path
from statistics import mode
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray

_DELIMITERS = (";", "\t", ",", " ")
_FIRST_BYTES = 4096
_HEAD = 50  # lines in which delimiter, header and first row of numbers are looked for


def read_log(
    path: str | Path, time: int | str = 0, position: int | str = 1
) -> tuple[FloatArray, FloatArray]:
    r"""Read times and positions from a CSV file.

    Columns may be parted by commas, semicolons, tabs or blanks; with anything but commas,
    numbers may have decimal commas. Lines that begin with # are left out, and so are rows
    in which the time or the position is empty or NaN. Rows of text may come first.

    Parameters
    ----------
    path : str or Path
    time, position : int or str, optional
        Columns: numbers from 0 on, negative ones from the last, or names in the header.

    Returns
    -------
    times, positions : (N,) array
        As in the file, in its units.

    Raises
    ------
    ValueError
        For a column that is not there or whose name the header holds twice, for a cell that is
        no finite number, naming its line, and for a file in UTF-16.
    TypeError
        For a column that is neither a name nor a whole number.
    OSError
        Where the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "axis.csv")
    ...     _ = path.write_text("t [s];x [mm];state\n0,0;1,5;run\n0,1;1,7;run\n")
    ...     read_log(path, position="x [mm]")
    (array([0. , 0.1]), array([1.5, 1.7]))
    """
    file = Path(path)
    wanted = _wanted("time", time), _wanted("position", position)
    _refuse_utf_16(file)
    head = [line for _, line in islice(_lines(file), _HEAD)]
    delimiter = _sniffed(head)
    rows = [_cells(line, delimiter) for line in head]
    start, columns = _columns(file, rows, wanted)
    start += _text_rows(rows[start:], columns, delimiter)
    times, positions = array("d"), array("d")
    for number, line in islice(_lines(file), start, None):
        cells = _cells(line, delimiter)
        pair = [_reading(file, number, cells, column, delimiter) for column in columns]
        if not any(map(isnan, pair)):
            times.append(pair[0])
            positions.append(pair[1])
    if not times:
        raise ValueError(f"{file}: no row has numbers in columns {columns[0]} and {columns[1]}")
    return np.array(times), np.array(positions)


def _wanted(name: str, column: int | str) -> int | str:
    try:
        return column if isinstance(column, str) else index(column)
    except TypeError:
        raise TypeError(
            f"{name} = {column!r}: expected the number of a column, from 0 on, or its name"
        ) from None


def _refuse_utf_16(file: Path) -> None:
    with file.open("rb") as stream:
        start = stream.read(_FIRST_BYTES)
    if start.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) or b"\0" in start:
        raise ValueError(f"{file} is in UTF-16, or no text: save it as UTF-8")


def _lines(file: Path) -> Iterator[tuple[int, str]]:
    """Yield number and text of the lines that hold something."""
    with file.open(encoding="utf-8-sig", errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            text = line.rstrip("\r\n")
            if text.strip() and not text.lstrip().startswith("#"):
                yield number, text


def _cells(line: str, delimiter: str) -> list[str]:
    if '"' in line:
        [cells] = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
    else:
        cells = line.split() if delimiter == " " else line.split(delimiter)
    return [cell.strip() for cell in cells]


def _number(cell: str, delimiter: str) -> float | None:
    """Return a cell as a number, NaN if it is empty, None if it is text."""
    try:
        return float((cell if delimiter == "," else cell.replace(",", ".")) or nan)
    except ValueError:
        return None


def _sniffed(lines: Sequence[str]) -> str:
    """Return the delimiter that leaves most lines with two numbers, and least text beside them."""

    def fitness(delimiter: str) -> tuple[int, float, int]:
        rows = [_cells(line, delimiter) for line in lines]
        counts = [sum(_number(cell, delimiter) is not None for cell in row) for row in rows]
        cells = sum(map(len, rows))
        return sum(count > 1 for count in counts), sum(counts) / max(cells, 1), cells

    return max(_DELIMITERS, key=fitness)


def _columns(
    file: Path, rows: Sequence[list[str]], wanted: tuple[int | str, int | str]
) -> tuple[int, tuple[int, int]]:
    """Return where the rows below the header begin, and the columns of time and position."""
    if not rows:
        raise ValueError(f"{file} has no rows: expected a time and a position in each")
    names = [column for column in wanted if isinstance(column, str)]
    headers = [i for i, row in enumerate(rows) if all(name in row for name in names)]
    if not headers:
        found = ", ".join(map(repr, rows[0]))
        raise ValueError(f"{file}: no column {' or '.join(map(repr, names))}: found {found}")
    header, width = rows[headers[0]], mode(map(len, rows))
    for name in names:
        if header.count(name) > 1:
            where = ", ".join(str(i) for i, cell in enumerate(header) if cell == name)
            raise ValueError(f"{file}: columns {where} are all named {name!r}: give a number")
    numbers = [header.index(c) if isinstance(c, str) else c for c in wanted]
    for number in numbers:
        if not -width <= number < width:
            raise ValueError(f"{file}: no column {number}: rows have {width}, counted from 0")
    time, position = (number % width for number in numbers)
    if time == position:
        raise ValueError(f"{file}: time and position are both column {time}")
    return headers[0] + bool(names), (time, position)


def _text_rows(rows: Sequence[list[str]], columns: tuple[int, int], delimiter: str) -> int:
    """Return how many rows come first in which neither cell is a number."""
    for count, row in enumerate(rows):
        cells = [row[column] for column in columns if column < len(row)]
        if any(_number(cell, delimiter) is not None for cell in cells):
            return count
    return len(rows)


def _reading(file: Path, number: int, cells: Sequence[str], column: int, delimiter: str) -> float:
    if column >= len(cells):
        count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
        raise ValueError(f"{file}, line {number}: {count}, so no column {column}; counted from 0")
    value = _number(cells[column], delimiter)
    if value is None:
        raise ValueError(f"{file}, line {number}: {cells[column]!r} is not a number")
    if isinf(value):
        raise ValueError(f"{file}, line {number}: {cells[column]!r} is not a finite number")
    return value
