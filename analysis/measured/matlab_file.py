"""Frequency responses out of .mat files: version 5 by scipy, 7.3 by h5py."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .column_roles import Column, role_of

_HDF = b"\x89HDF"
_COMPLEX = ("response", "responsedata", "frf", "h", "g", "l", "resp", "s", "t", "data")


def read_mat(path: Path) -> list[Column]:
    """Return the vectors of a file, or of the one structure in it, as columns by name.

    A complex vector is the response; names such as Frequency, ResponseData, coherence are known.

    Raises
    ------
    ValueError
        For a file that holds MATLAB objects (frd, idfrd), records in time, or no response.
    """
    content = _flat(_loaded(path))
    vectors = {name: np.ravel(value) for name, value in content.items() if _is_vector(value)}
    if {"u", "y"} <= set(vectors) and not any(np.iscomplexobj(v) for v in vectors.values()):
        raise ValueError(
            f"{path}: holds records in time (u, y), no frequency response: expected one; make it "
            "with estimate_frf(excitation, u, y, dt)"
        )
    units = content.get("Units", content.get("FrequencyUnit", ""))
    columns = [_column(name, value, str(units)) for name, value in vectors.items()]
    if not any(name == "response" for name, _ in columns) and not columns:
        raise ValueError(
            f"{path}: holds no vectors: expected frequency and response; MATLAB's frd and idfrd "
            "cannot be read: save struct('Frequency', …, 'ResponseData', …)"
        )
    return columns


def _column(name: str, value: Any, units: str) -> Column:
    if np.iscomplexobj(value) or name.lower() in _COMPLEX:
        return "response", value
    if role_of(name) == "frequency":
        unit = "rad/s" if name.lower() in ("w", "omega") else units
        return f"{name} {unit}".strip(), value
    return name, value


def _is_vector(value: Any) -> bool:
    array = np.asarray(value)
    return array.dtype.kind in "iufc" and array.size > 1 and array.size == max(array.shape)


def _flat(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the variables, those of structures among them."""
    flat: dict[str, Any] = {}
    for name, value in content.items():
        if isinstance(value, Mapping):
            flat |= _flat(value)
        elif not name.startswith("__"):
            flat[name] = value
    return flat


def _loaded(path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    try:
        with path.open("rb") as file:
            start = file.read(520)
        if start.startswith(_HDF) or start[512:].startswith(_HDF):
            return _of_hdf(path)
        content: Mapping[str, Any] = loadmat(path, simplify_cells=True)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror}); check the path") from None
    except (ValueError, TypeError, NotImplementedError, KeyError) as error:
        if isinstance(error, ValueError) and str(error).startswith(str(path)):
            raise
        raise ValueError(
            f"{path}: is no .mat file that can be read ({error}); save it anew"
        ) from None
    return content


def _of_hdf(path: Path) -> Mapping[str, Any]:
    try:
        import h5py
    except ImportError:
        raise ValueError(
            f"{path}: is a .mat file of version 7.3 (HDF5): reading it needs h5py; run pip install "
            "'jounce[measured]', or save it with -v7"
        ) from None
    found: dict[str, Any] = {}

    def take(name: str, node: Any) -> None:
        if not isinstance(node, h5py.Dataset) or name.startswith("#"):
            return
        value = node[()]
        if value.dtype.names == ("real", "imag"):
            value = value["real"] + 1j * value["imag"]
        elif node.attrs.get("MATLAB_class") == b"char":
            value = "".join(map(chr, np.ravel(value)))
        found[name.rsplit("/", 1)[-1]] = value

    with h5py.File(path, "r") as file:
        file.visititems(take)
    return found
