"""Frequency responses out of universal files, dataset 58, ascii or binary."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .column_roles import Column

_RESPONSE, _COHERENCE = 4, 6
_PER_COMPLEX = {2: 1, 4: 1, 5: 2, 6: 2}
_HEADER = 11


class Function(NamedTuple):
    """A dataset: its type (4: frequency response, 6: coherence), name and values over Hz."""

    kind: int
    name: str
    frequency_hz: Any
    values: Any


def read_uff(path: Path, which: int | None) -> list[Column]:
    """Return frequency and response of a file's only frequency response, or of number `which`.

    With its coherence, where the file has one of as many lines.
    """
    functions = _functions(path)
    if not functions:
        raise ValueError(
            f"{path}: holds no whole dataset 58: expected a universal file with frequency "
            "responses; export it anew, or save it as CSV"
        )
    responses = [each for each in functions if each.kind == _RESPONSE]
    if not responses:
        raise ValueError(
            f"{path}: no frequency response among {len(functions)} datasets 58: expected function "
            "type 4; export the FRF, not spectra or records"
        )
    if which is None and len(responses) > 1:
        names = "; ".join(f"{i}: {each.name}" for i, each in enumerate(responses[:6], start=1))
        raise ValueError(
            f"{path}: holds {len(responses)} frequency responses ({names}): expected one; "
            "give its number, columns=1"
        )
    if which is not None and not 1 <= which <= len(responses):
        raise ValueError(f"{path}: columns = {which}: expected 1 to {len(responses)}")
    found = responses[(which or 1) - 1]
    columns: list[Column] = [("frequency Hz", found.frequency_hz), ("response", found.values)]
    coherences = [f for f in functions if f.kind == _COHERENCE]
    if len(coherences) == 1 and len(coherences[0].values) == len(found.values):
        columns.append(("coherence", coherences[0].values.real))
    return columns


def _functions(path: Path) -> list[Function]:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    if b"58b" in raw[:200_000]:
        return _binary(path)
    lines = raw.decode("latin-1").splitlines()
    marks = [i for i, line in enumerate(lines) if line.strip() == "-1"]
    ends = [*marks[1::2], len(lines)]  # of a file that was cut off, the last one's
    blocks = [lines[a + 1 : b] for a, b in zip(marks[::2], ends, strict=False)]
    return [_ascii(path, block[1:]) for block in blocks if block and block[0].strip() == "58"]


def _ascii(path: Path, block: list[str]) -> Function:
    """Return a dataset of its eleven header records and the values behind them."""
    try:
        kind = int(block[5][:5])
        ordinate, count, even = (int(word) for word in block[6].split()[:3])
        start, step = (_number(word) for word in block[6].split()[3:5])
        words = " ".join(block[_HEADER:]).split()
        per = _PER_COMPLEX[ordinate] + (not even)
        table = np.array([_number(word) for word in words]).reshape(-1, per)
        if len(table) < count:
            raise ValueError(f"{len(table)} of {count} values")
    except (ValueError, IndexError, KeyError) as error:
        raise ValueError(
            f"{path}: a dataset 58 is not as its header says ({error}): expected a whole file; "
            "export it anew"
        ) from None
    table = table[:count]
    frequency = start + step * np.arange(count) if even else table[:, 0]
    values = table[:, -1] if per - (not even) == 1 else table[:, -2] + 1j * table[:, -1]
    return Function(kind, block[0].strip(), frequency, values)


def _number(word: str) -> float:
    return float(word.replace("D", "E").replace("d", "e"))


def _binary(path: Path) -> list[Function]:
    try:
        import pyuff
    except ImportError:
        raise ValueError(
            f"{path}: is a binary universal file (58b): reading it needs pyuff; run pip install "
            "'jounce[measured]', or export it as ascii"
        ) from None
    try:
        sets = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # pyuff raises nothing narrower
        raise ValueError(
            f"{path}: is no binary universal file that can be read ({error}): expected a whole "
            "one; export it anew, or as ascii"
        ) from None
    sets = sets if isinstance(sets, list) else [sets]
    return [
        Function(int(s["func_type"]), str(s.get("id1", "")).strip(), s["x"], np.asarray(s["data"]))
        for s in sets
        if s.get("type") == 58
    ]
