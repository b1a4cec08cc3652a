"""The FMUs of an SSP file, connected as it says: run, fed from outside, its outputs shown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from types import MappingProxyType, TracebackType
from typing import Literal, Self

import numpy as np

from ....shaping.checks import positive
from ..importing.description import FmuError, candidates
from ..importing.stepping import Fmu
from .cosimulate import cosimulate
from .cosimulation_result import CosimulationResult
from .over_time import Source, scaled

_NEARLY = 1e-9


@dataclass(frozen=True, eq=False)
class SspSystem:
    """The FMUs of an SSP file, initialised, with what connects them; a context manager.

    Attributes
    ----------
    name : str
    blocks : mapping of str to Fmu
        In the order of the file; those of a system within the system are "system/component".
    connections : tuple of (source, target)
        Between them, as `cosimulate` takes them.
    inputs : mapping of str to tuple of (target, gain, offset)
        What each input of the system as a whole feeds.
    outputs : mapping of str to (source, gain, offset)
        What each output of the system as a whole shows.
    dt : float or None
        Least step that one of the FMUs suggests.
    stop_time : float or None
        Of the default experiment.
    notes : tuple of str
        Parameters of the file that nothing takes.
    """

    name: str
    blocks: Mapping[str, Fmu]
    connections: tuple[tuple[Source, str], ...]
    inputs: Mapping[str, tuple[tuple[str, float, float], ...]]
    outputs: Mapping[str, tuple[str, float, float]]
    dt: float | None
    stop_time: float | None
    notes: tuple[str, ...]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close all the FMUs."""
        with ExitStack() as stack:
            for fmu in self.blocks.values():
                stack.callback(fmu.close)

    def run(
        self,
        duration: float | None = None,
        *,
        dt: float | None = None,
        inputs: Mapping[str, Source] | None = None,
        order: Literal["gauss-seidel", "jacobi"] | Sequence[str] = "gauss-seidel",
        progress: bool | None = None,
    ) -> CosimulationResult:
        """Return `cosimulate` of the system, with its outputs as further signals.

        Parameters
        ----------
        duration, dt : float, optional
            Default: to the stop time of the default experiment, in the steps that the FMUs
            suggest.
        inputs : mapping of str to source, optional
            By name of an input of the system, or by "component.input" that nothing feeds:
            numbers, trajectories, functions of time, tables, as sources of `cosimulate`.
        order, progress
            As in `cosimulate`; SSP itself says nothing of an order.
        """
        dt = self.dt if dt is None else positive("dt", dt)
        if dt is None:
            raise FmuError(f"{self.name} suggests no step size: give dt")
        if duration is None:
            duration = self._lasting(dt)
        links = [*self.connections, *self._fed(inputs or {})]
        found = cosimulate(
            self.blocks, links, dt=dt, duration=duration, order=order, progress=progress
        )
        return self._with_outputs(found)

    def _lasting(self, dt: float) -> float:
        start = next(iter(self.blocks.values())).time
        if self.stop_time is None or not self.stop_time > start:
            raise FmuError(f"{self.name} suggests no stop time: give a duration")
        return max(math.ceil((self.stop_time - start) / dt * (1.0 - _NEARLY)), 1) * dt

    def _fed(self, inputs: Mapping[str, Source]) -> list[tuple[Source, str]]:
        taken = {target for _, target in self.connections}
        found: list[tuple[Source, str]] = []
        for name, source in inputs.items():
            if name in taken:
                raise FmuError(f"input {name!r} is connected within {self.name}; leave it out")
            known = [f"{own}.{u}" for own, fmu in self.blocks.items() for u in fmu.input_names]
            if name in self.inputs:
                found += [(scaled(source, *by), target) for target, *by in self.inputs[name]]
            elif name in known:
                found.append((source, name))
            else:
                free = [*self.inputs, *(each for each in known if each not in taken)]
                raise FmuError(f"{self.name} has no input {name!r}{candidates(name, free)}")
        return found

    def _with_outputs(self, found: CosimulationResult) -> CosimulationResult:
        shown = {}
        for name, (source, gain, offset) in self.outputs.items():
            shown[name] = np.asarray(gain * found[source] + offset)
            shown[name].flags.writeable = False
        return replace(
            found,
            signals=MappingProxyType({**shown, **found.signals}),
            outputs=(*shown, *found.outputs),
            notes=(*self.notes, *found.notes),
        )
