"""Inputs of FMUs over time from a CSV file: the first column is time, the others are inputs."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .text_files import text_of

if TYPE_CHECKING:
    from ..fmu.importing.description import FmuUnit
    from ..shaping.pieces import FloatArray

_UNIT = re.compile(r"(.*\S)\s*\[([^\[\]]*)\]")
_TIME = re.compile(r"t|time|t_s|time_s", re.IGNORECASE)
_WHOLE = re.compile(r"[+-]?[0-9]{1,20}")  # what integers of 64 bits may have
_EXACT = 2**53  # whole numbers up to this are doubles, too
_TRUTH = {"true": 1.0, "false": 0.0}


def read_inputs(
    path: Path, units: Mapping[str, FmuUnit | None]
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return times in s and values of each input that a CSV file names.

    The header names the columns, which commas, semicolons or tabs part (with semicolons or tabs,
    numbers may have decimal commas). A name may be followed by its unit in brackets, as in
    "time [ms], angle [deg]"; values are converted to the unit of the input. Empty lines and those
    that begin with # are left out.

    Parameters
    ----------
    path : Path
    units : mapping of str to FmuUnit or None
        The unit of each input that there is, None where it has none.

    Raises
    ------
    ValueError
        For a file that cannot be read or is no such table, naming line and column; for an input
        that is not there, units that do not fit, and times that decrease.
    """
    lines = list(_lines(path))
    if not lines:
        raise ValueError(f"{path}: no lines; expected a header such as 'time,u' and rows below it")
    delimiter = next((mark for mark in ";\t" if mark in lines[0][1]), ",")
    rows = [(number, _cells(line, delimiter)) for number, line in lines]
    names, scales = _header(path, rows[0], units)
    table = [_row(path, names, row, delimiter) for row in rows[1:]]
    if not table:
        raise ValueError(f"{path}: no rows below the header; expected a time and values in each")
    pairs = zip(zip(*table, strict=True), scales, strict=True)
    columns = [_converted(_column(values), *scale) for values, scale in pairs]
    times = columns[0].astype(float)
    _check_times(path, times, [number for number, _ in rows[1:]])
    return {name: (times, column) for name, column in zip(names[1:], columns[1:], strict=True)}


def value_at(table: tuple[FloatArray, FloatArray], time: float, *, steps: bool) -> float:
    """Return what a table says at one time: of its last row up to then, or between two."""
    times, values = table
    before = max(int(np.searchsorted(times, time, side="right")) - 1, 0)
    if steps or times[before] >= time or before + 1 == len(times):
        found: float = values.tolist()[before]
        return found
    between = slice(before, before + 2)
    return float(np.interp(time, times[between], values[between].astype(float)))


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number and text of the lines that hold something."""
    text = text_of(path, "a CSV file of inputs")
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line


def _cells(line: str, delimiter: str) -> list[str]:
    [cells] = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
    return [cell.strip() for cell in cells]


def _header(
    path: Path, header: tuple[int, list[str]], units: Mapping[str, FmuUnit | None]
) -> tuple[list[str], list[tuple[float, float]]]:
    """Return the name of each column, and gain and offset of its unit."""
    from ..fmu.cosimulation.conversion import conversion, unit_of
    from ..fmu.importing.description import candidates

    number, cells = header
    names, scales = list[str](), list[tuple[float, float]]()
    for i, cell in enumerate(cells):
        place = f"{path}, line {number}, column {i + 1}"
        split = _UNIT.fullmatch(cell)
        name, said = (cell, "") if cell in units or not split else (split[1], split[2].strip())
        if i == 0:
            _check_time(place, cell, name, units)
        elif name not in units:
            raise ValueError(f"{place}: no input {name!r}{candidates(name, units)}")
        if name in names:
            raise ValueError(f"{place}: a second column {name!r}; leave one out")
        own = units.get(name) if i else unit_of("s")
        scale = conversion(unit_of(said), own or unit_of(""))
        if scale is None:
            wanted = own.name if own else "no unit"
            raise ValueError(f"{place}: {name} is in {wanted}, into which {said} does not convert")
        names.append(name)
        scales.append(scale)
    if len(names) == 1:
        raise ValueError(f"{path}, line {number}: no inputs beside the time; name them as columns")
    return names, scales


def _check_time(place: str, cell: str, name: str, units: Mapping[str, FmuUnit | None]) -> None:
    if not _TIME.fullmatch(name) or name in units:
        inputs = ",".join(list(units)[:3]) or "u"
        raise ValueError(
            f"{place} is {cell!r}: expected a header that begins with time, such as 'time,{inputs}'"
        )


def _column(values: Sequence[float]) -> FloatArray:
    """Return numbers as an array, of objects where a double would round one of them."""
    wide = any(isinstance(value, int) and abs(value) > _EXACT for value in values)
    return np.array(values, object if wide else None)


def _converted(values: FloatArray, gain: float, offset: float) -> FloatArray:
    """Return a column in the input's unit; whole numbers of 64 bits as they are, without one."""
    return values if (gain, offset) == (1.0, 0.0) else gain * values + offset


def _row(path: Path, names: list[str], row: tuple[int, list[str]], delimiter: str) -> list[float]:
    number, cells = row
    if len(cells) != len(names):
        raise ValueError(f"{path}, line {number}: {len(cells)} cells; expected {len(names)}")
    return [
        _number(cell, delimiter, f"{path}, line {number}, column {name!r}")
        for name, cell in zip(names, cells, strict=True)
    ]


def _number(cell: str, delimiter: str, place: str) -> float:
    text = cell if delimiter == "," else cell.replace(",", ".")
    if _WHOLE.fullmatch(text):
        return int(text)  # which may have more digits than a double
    try:
        value = _TRUTH[text.lower()] if text.lower() in _TRUTH else float(text)
    except ValueError:
        raise ValueError(f"{place}: {cell!r} is not a number") from None
    if not isfinite(value):
        raise ValueError(f"{place}: {cell!r} is not a finite number")
    return value


def _check_times(path: Path, times: FloatArray, numbers: list[int]) -> None:
    for before, after, number in zip(times[:-1], times[1:], numbers[1:], strict=True):
        if after < before:
            raise ValueError(
                f"{path}, line {number}: time {after:g} comes after {before:g}; sort the rows"
            )
