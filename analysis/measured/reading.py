"""Reading a measured frequency response from the files that analysers and MATLAB write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from ...shaping.checks import one_of, whole
from .column_roles import (
    FREQUENCY_UNITS,
    Column,
    by_role,
    complex_response,
    deviations,
    hertz,
    role_of,
)
from .matlab_file import read_mat
from .measured_response import KINDS, MOST_LINES, Kind, MeasuredResponse
from .text_table import read_table
from .uff_file import read_uff

Output = Literal["position", "velocity", "acceleration"]

_UFF = (".uff", ".unv", ".uf")
_ORDERS = {"position": 0, "velocity": 1, "acceleration": 2}
_LEFT_OUT = "-"


def read_frf(
    path: str | Path,
    *,
    kind: Kind,
    output: Output = "position",
    columns: Sequence[str] | int | None = None,
    frequency_unit: str | None = None,
    averages: int | None = None,
    dt: float | None = None,
    integrators: int | None = None,
    unstable_poles: int | None = None,
) -> MeasuredResponse:
    """Return a measured frequency response from a file: CSV, UFF 58 or .mat.

    Parameters
    ----------
    path : str or Path
        Text in columns (any of ``, ; tab blank``, decimal comma, preambles), universal file
        dataset 58 (.uff, .unv), or MATLAB (.mat; version 7.3 needs h5py, ``jounce[measured]``).
    kind : "plant", "loop", "sensitivity", "process-sensitivity" or "complementary"
        What it is a response of; it has to be said: margins read off T in place of L are wrong by
        a factor of two.
    output : "position", "velocity" or "acceleration", optional
        Of a plant; what is not a position is integrated, by 1/jω.
    columns : sequence of str, or int, optional
        A name for each column in the place of the file's, such as ("Hz", "dB", "deg", "-"), "-"
        for one to leave out; of a universal file the number of the response. Default: the names
        in the file: frequency (Hz, kHz, rad/s), re and im, or gain (dB, abs) and phase (deg, rad),
        coherence or sigma.
    frequency_unit : str, optional
        "Hz", "kHz", "rad/s", …, where the file names none. Default: Hz, of an omega rad/s.
    averages : int, optional
        Independent averages n behind a coherence γ²: σ = |G|·√((1 − γ²)/(γ²·n)). Without it a
        coherence is left out, and σ is estimated from the scatter of the lines.
    dt, integrators, unstable_poles : optional
        As in `MeasuredResponse`.

    Returns
    -------
    MeasuredResponse

    Raises
    ------
    ValueError
        One line that names file, value and remedy: for what cannot be read, is not named, names
        no unit, repeats, falls, is not finite or is too long.

    Notes
    -----
    A line at 0 Hz is left out.
    """
    one_of("kind", kind, KINDS)
    one_of("output", output, tuple(_ORDERS))
    if frequency_unit is not None:
        one_of("frequency_unit", frequency_unit, tuple(FREQUENCY_UNITS))
    if averages is not None:
        averages = whole("averages", averages, 1, 10**9)
    if output != "position" and kind != "plant":
        raise ValueError(
            f"output = {output!r} with kind = {kind!r}: expected it of a plant alone; leave it out"
        )
    path = Path(path)
    found = by_role(str(path), _columns(path, columns))
    frequency = hertz(str(path), found["frequency"], frequency_unit)
    response = complex_response(str(path), found)
    if len(frequency) != len(response):
        raise ValueError(
            f"{path}: {len(frequency)} frequencies and {len(response)} values: expected as many"
        )
    sigma = deviations(str(path), found, response, averages)
    order = np.flatnonzero(frequency != 0.0)
    factor = (2j * np.pi * frequency[order]) ** -_ORDERS[output]
    with np.errstate(invalid="ignore"):  # what is not finite is told by its line
        positions = response[order] * factor
    try:
        return MeasuredResponse(
            frequency[order],
            positions,
            None if sigma is None else sigma[order] * abs(factor),
            kind=kind,
            dt=dt,
            integrators=integrators,
            unstable_poles=unstable_poles,
        )
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _columns(path: Path, columns: Sequence[str] | int | None) -> list[Column]:
    """Return the columns of a file by name."""
    suffix = path.suffix.lower()
    if suffix in _UFF:
        return read_uff(path, _number_of_response(columns))
    if isinstance(columns, int):
        raise ValueError(f"columns = {columns} of {path}: expected a name for each column")
    if suffix == ".mat":
        return read_mat(path)
    table = read_table(path, MOST_LINES)
    names = _given_names(path, columns, table.values.shape[1]) or table.names
    if not names or not any(map(role_of, names)):
        raise ValueError(
            f"{path}: {table.values.shape[1]} columns without names that are known: expected "
            "names above them; give columns=('Hz', 'dB', 'deg') or what they are"
        )
    pairs = zip(names, table.values.T, strict=True)
    return [(name, values) for name, values in pairs if name != _LEFT_OUT and role_of(name)]


def _number_of_response(columns: Sequence[str] | int | None) -> int | None:
    if columns is None or isinstance(columns, int):
        return columns
    raise ValueError(
        f"columns = {columns!r} of a universal file: expected the number of a response, such as 1"
    )


def _given_names(path: Path, columns: Sequence[str] | None, width: int) -> tuple[str, ...]:
    if columns is None:
        return ()
    names = tuple(columns.split(",") if isinstance(columns, str) else columns)
    names = tuple(str(name).strip() for name in names)
    if len(names) != width:
        raise ValueError(
            f"columns = {', '.join(names)}: {len(names)} names for the {width} columns of {path}: "
            "expected one for each, '-' for those to leave out"
        )
    unknown = [name for name in names if name != _LEFT_OUT and not role_of(name)]
    if unknown:
        raise ValueError(
            f"columns: {unknown[0]!r} is not known: expected frequency (Hz, rad/s), re, im, dB, "
            "abs, deg, rad, coherence, sigma, or '-'"
        )
    return names
