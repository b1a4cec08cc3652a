"""What a sweep has found, on disk as it grows: a Zarr folder, which a sweep goes on with."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray

NEEDS = "a sweep needs xarray, zarr and dask: pip install 'jounce[sweep]'"


class Store:
    """A dataset of all points that is filled in batches; what is done is known at any moment.

    A batch is written figures first and its marks of being done last, so that a sweep that is
    killed repeats at most the batches that were under way, and loses none.

    Parameters
    ----------
    dataset : xarray.Dataset
        Parameters, figures full of nan, `failure` and `done`, over the dimension `point`.
    path : Path or None
        A folder `….zarr`, or a file `….nc` beside which a folder grows; None keeps it in memory.
    chunk : int
        Points in one batch.
    """

    def __init__(self, dataset: xarray.Dataset, path: Path | None, chunk: int) -> None:
        self.dataset = dataset
        self.path = path
        self._folder = None if path is None else _growing(path)
        if self._folder is not None:
            if self._folder.exists():
                self.dataset = _continued(dataset, self._folder)
            else:
                self._create(chunk)

    def _create(self, chunk: int) -> None:
        encoding: Any = {
            name: {"chunks": (chunk,)}
            for name, variable in self.dataset.variables.items()
            if variable.dims == ("point",)
        }
        assert self._folder is not None
        try:
            self._folder.parent.mkdir(parents=True, exist_ok=True)
            self.dataset.to_zarr(self._folder, mode="w-", zarr_format=2, encoding=encoding)
        except OSError as error:
            told = error.strerror or error
            raise ValueError(
                f"{self.path}: cannot be written ({told}); name a folder that can be"
            ) from None

    def missing(self) -> list[int]:
        """Return the numbers of the points that are still to do."""
        return [int(i) for i in np.flatnonzero(~self.dataset["done"].values)]

    def write(self, first: int, rows: Sequence[tuple[Sequence[float], str]]) -> None:
        """Keep what was found at consecutive points; OSError, in one line, on a full disk."""
        where = slice(first, first + len(rows))
        for k, name in enumerate(self.dataset.attrs["figures"]):
            self.dataset[name].values[where] = [values[k] for values, _ in rows]
        self.dataset["failure"].values[where] = [message for _, message in rows]
        self._flush(where, [*self.dataset.attrs["figures"], "failure"])
        self.dataset["done"].values[where] = True
        self._flush(where, ["done"])

    def _flush(self, where: slice, names: Sequence[str]) -> None:
        if self._folder is not None:
            part = self.dataset[list(names)].isel(point=where)
            part = part.drop_vars(list(part.coords))
            with self._told():
                part.to_zarr(self._folder, region={"point": where}, zarr_format=2)

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Say what to do where a disk fills; h5py tells it as RuntimeError, too."""
        try:
            yield
        except (OSError, RuntimeError) as error:
            told = getattr(error, "strerror", None) or str(error).partition("\n")[0]
            raise OSError(
                f"{self.path}: cannot be written any more ({told}); what is done is kept in "
                f"{self._folder}: make room, and go on with the same call"
            ) from None

    def finish(self) -> None:
        """Turn the folder that grew into the file that was asked for."""
        if self.path is not None and self._folder != self.path:
            part = self.path.with_name(self.path.name + ".part")
            try:
                with self._told():
                    self.dataset.to_netcdf(part, engine="h5netcdf")
            except OSError:
                part.unlink(missing_ok=True)
                raise
            part.replace(self.path)
            shutil.rmtree(self._folder)  # type: ignore[arg-type]


def _growing(path: Path) -> Path:
    if path.suffix == ".zarr":
        return path
    if path.suffix == ".nc":
        return path if path.exists() else path.with_name(path.name + ".growing")
    raise ValueError(f"{path}: expected a name that ends in .zarr or .nc")


def _continued(asked: xarray.Dataset, folder: Path) -> xarray.Dataset:
    """Return what a folder holds already, which must be of the same sweep."""
    found = read(folder, "name another folder")
    if found.attrs.get("sweep") != asked.attrs["sweep"]:
        raise ValueError(
            f"{folder}: holds another sweep, {_difference(found, asked)}; name another folder, or "
            "remove this one"
        )
    return found


def read(path: Path, remedy: str) -> xarray.Dataset:
    """Return what a folder or a file holds; ValueError for what is no sweep, or damaged."""
    import xarray

    try:
        if path.suffix == ".nc":
            return xarray.open_dataset(path, engine="h5netcdf").load()
        found: xarray.Dataset = xarray.open_zarr(path, chunks=None).load()
        return found
    except (OSError, ValueError, KeyError, RuntimeError) as error:  # blosc tells it as RuntimeError
        told = str(error).partition("\n")[0] if path.exists() else "there is none"
        raise ValueError(f"{path}: is no sweep ({told}); {remedy}") from None


def _difference(found: xarray.Dataset, asked: xarray.Dataset) -> str:
    try:
        was, now = (json.loads(each.attrs["sweep"]) for each in (found, asked))
    except (KeyError, ValueError):
        return "or none"
    return "of other " + ", ".join(name for name in now if was.get(name) != now[name])
