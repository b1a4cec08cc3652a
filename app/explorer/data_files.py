"""Measured responses that come as a file's bytes, dropped onto a page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...analysis.measured import MeasuredResponse, read_frf


def read_bytes(name: str, content: bytes, said: Mapping[str, Any]) -> MeasuredResponse:
    """Return the response in a file's bytes.

    Parameters
    ----------
    name : str
        Of the file; how it is read goes by its suffix.
    content : bytes
    said : mapping
        `kind_of` is its kind; output, columns, frequency_unit, averages, dt, integrators and
        unstable_poles are as `read_frf` takes them.

    Raises
    ------
    ValueError
        For a file that cannot be used, in one line that names it.
    """
    known = ("output", "columns", "frequency_unit", "averages", "dt", "integrators")
    options = {key: said[key] for key in (*known, "unstable_poles") if said.get(key) is not None}
    with TemporaryDirectory() as folder:
        path = Path(folder) / Path(name).name
        path.write_bytes(content)
        try:
            return read_frf(path, kind=said.get("kind_of", "plant"), **options)
        except (ValueError, TypeError, OSError) as error:
            raise ValueError(str(error).replace(str(path), path.name)) from None
