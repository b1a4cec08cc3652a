"""Results of a co-simulation: named arrays, and which value each connection carried."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ...shaping.frozen import Frozen
from ...shaping.pieces import FloatArray
from ...shaping.told import Told
from ..exporting.archive import write_atomically
from ..importing.description import FmuError, candidates


@dataclass(frozen=True, eq=False, repr=False)
class CosimulationResult(Told, Frozen):
    """Signals of a co-simulation at its communication points t_0 … t_N.

    Attributes
    ----------
    time : (N + 1,) array
    signals : mapping of str to (N + 1,) array
        By "block.signal", read-only, of doubles or integers of 64 bits. An output at t_k is what
        the block showed there, before the step that begins at t_k. An input at t_k is what the
        block was given for that step (for t_N, where none begins, the last one again).
    outputs : tuple of str
        Which of the signals are outputs.
    order : tuple of str
        The blocks in the order in which they stepped; all at once with "jacobi".
    method : str
        "gauss-seidel" or "jacobi".
    delays : mapping of str to int
        By "source -> target": 1 where the target, in its step from t_k, was given what the source
        showed at t_k; 0 where it was given the result of the source's own step from t_k.
    loops : mapping of str to int
        By loop of blocks: samples of delay beyond those of a sampled loop with a zero-order hold,
        which are the delays around the loop less 1.
    ended : str
        Which FMU ended the simulation, and when; empty where the run went through.
    notes : tuple of str
        Units that were converted, and tables that ended before the run.
    """

    time: FloatArray
    signals: Mapping[str, FloatArray]
    outputs: tuple[str, ...]
    order: tuple[str, ...]
    method: str
    delays: Mapping[str, int]
    loops: Mapping[str, int]
    ended: str = ""
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> FloatArray:
        if name not in self.signals:
            raise FmuError(f"no signal {name!r}{candidates(name, self.signals)}")
        return self.signals[name]

    def __str__(self) -> str:
        span = f"{self.time[0]:g} to {self.time[-1]:g} in {len(self.time) - 1} steps"
        order = " and ".join(self.order) + " at once"
        if self.method == "gauss-seidel":
            order = ", then ".join(self.order)
        return "\n".join(
            [
                f"co-simulation from {span}, {self.method}: {order}",
                *(f"  {text}: delay {delay}" for text, delay in self.delays.items()),
                *(
                    f"  loop {text}: {extra} samples beyond a zero-order hold"
                    for text, extra in self.loops.items()
                ),
                *([f"  {self.ended}"] if self.ended else []),
                *(f"  {note}" for note in self.notes),
            ]
        )

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write time and all signals as columns, floats in full precision; whole or not at all.

        Raises
        ------
        OSError
            Where the file cannot be written. A file that was there has not changed then.
        """
        text = io.StringIO(newline="")
        writer = csv.writer(text)
        writer.writerow(["time", *self.signals])
        columns = [column.tolist() for column in (self.time, *self.signals.values())]
        writer.writerows(map(repr, row) for row in zip(*columns, strict=True))
        try:
            write_atomically(Path(path), text.getvalue().encode())
        except OSError as error:
            # its own error names the temporary file
            raise OSError(error.errno, error.strerror, os.fspath(path)) from error
