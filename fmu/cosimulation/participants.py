"""What takes part in a co-simulation: FMUs, linear systems and trajectories, stepped alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from inspect import signature
from typing import Any, Protocol

import numpy as np

from ...plant.exact_response import state_space
from ...plant.sampled import zero_order_hold
from ...shaping import Trajectory
from ...shaping.derivatives import derivative_name
from ...shaping.pieces import FloatArray
from ...shaping.trajectory import Motion, as_trajectory
from ..importing.description import FmuDescription, FmuError, FmuTerminated, FmuUnit
from ..importing.ports import WIDE
from ..importing.stepping import Fmu
from .conversion import NO_UNIT, unit_of

_SAME_DT = 1e-9


class Participant(Protocol):
    """A block of a co-simulation.

    `held` are the inputs where nothing is connected, nan where something must be; `through`
    (outputs, inputs) is True where an output of a step passes an input on within no time; `steps`
    is True for inputs that change in steps only; `recorded` are outputs that only are looked at,
    which may be infinite; `units` are those of the signals that have one; `wide` the types of
    those that are integers of 64 bits. `ended` says when and why the block has ended the
    simulation, if it has.
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    held: FloatArray
    through: Any
    steps: tuple[bool, ...]
    recorded: frozenset[str]
    units: Mapping[str, FmuUnit]
    wide: Mapping[str, Any]
    ended: str

    def start(self) -> FloatArray:
        """Return the outputs before the first step."""

    def step(self, inputs: FloatArray) -> FloatArray:
        """Go on by dt with the inputs held, and return the outputs to show from then on."""


def participant(name: str, block: Any, dt: float, time: FloatArray) -> Participant:
    """Return a block as a participant; TypeError for what cannot be one."""
    import control

    if isinstance(block, Fmu):
        return _FmuBlock(name, block, dt)
    if isinstance(block, Motion):
        return _Source(as_trajectory(block), time)
    linear = control.StateSpace | control.TransferFunction
    system = block if isinstance(block, linear) else _own_system(block)
    if isinstance(system, linear):
        return _Linear(name, system, dt)
    raise TypeError(
        f"block {name!r} is a {type(block).__name__}: expected an Fmu (load_fmu), a Trajectory, a "
        "python-control StateSpace or TransferFunction, or a plant whose .system() returns one; "
        "make it one of these, as by pid.sampled(dt), or export_fmu it and load_fmu the file"
    )


def _own_system(block: Any) -> Any:
    """Return what .system() gives where it needs no arguments, else None."""
    make = getattr(block, "system", None)
    if isinstance(block, type) or not callable(make):
        return None
    needed = signature(make).parameters.values()
    if any(
        p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in needed
    ):
        return None
    return make()


def start_time(blocks: Iterable[tuple[str, Any]]) -> float:
    """Return the time at which all the FMUs stand, or 0 without any."""
    times = {name: block.time for name, block in blocks if isinstance(block, Fmu)}
    if len(set(times.values())) > 1:
        told = ", ".join(f"{name} at {time:g}" for name, time in times.items())
        raise FmuError(f"the FMUs do not stand at the same time ({told}): reset them first")
    return next(iter(times.values()), 0.0)


def units_of(
    description: FmuDescription, labels: Iterable[str] | None = None
) -> dict[str, FmuUnit]:
    """Return the units of what has one in an FMU, by label; default: of all its variables."""
    if labels is None:
        labels = [label for variable in description.variables for label in variable.labels]
    variables = {label: description.variable(label) for label in labels}
    names = {variable.unit for variable in variables.values()}.difference(NO_UNIT)
    known = {name: unit_of(name, description.units) for name in names}
    return {
        label: replace(known[v.unit], offset=0.0) if v.relative else known[v.unit]
        for label, v in variables.items()
        if v.unit in known
    }


class _FmuBlock:
    def __init__(self, name: str, fmu: Fmu, dt: float) -> None:
        self.inputs, self.outputs = fmu.input_names, fmu.output_names
        self.held = fmu.inputs
        self.through = np.zeros((len(self.outputs), len(self.inputs)), dtype=bool)
        stepped = {
            label
            for v in fmu.description.of_causality("input")
            for label in v.labels
            if v.variability != "continuous"
        }
        self.steps = tuple(label in stepped for label in self.inputs)
        self.recorded = frozenset(fmu.recorded_names)
        self.units: Mapping[str, FmuUnit] = units_of(fmu.description, fmu.units)
        kinds = {n: fmu.description.variable(n).type for n in (*self.inputs, *self.outputs)}
        self.wide: Mapping[str, Any] = {n: WIDE[k] for n, k in kinds.items() if k in WIDE}
        self.ended = ""
        self._name = name
        self._fmu = fmu
        self._dt = dt

    def start(self) -> FloatArray:
        return self._fmu.outputs

    def step(self, inputs: FloatArray) -> FloatArray:
        before = self._fmu.time
        try:
            return self._fmu.step(inputs, self._dt)
        except FmuTerminated as end:
            self.ended = f"{self._name} ended the simulation at time {end.time:.12g}"
            if not end.reached or end.time == before:
                raise
            return end.outputs


class _Linear:
    """x_{k+1} = A·x_k + B·u_k; what is shown from t_{k+1} on depends on the kind of output.

    Without feedthrough, C·x_{k+1}. With it, the result C·x_k + D·u_k of the tick at t_k where
    the system is discrete, and C·x_{k+1} + D·u_k where it is continuous and its input held.
    """

    def __init__(self, name: str, system: Any, dt: float) -> None:
        sampled = system.isdtime(strict=True)
        if sampled and system.dt is not True and abs(system.dt - dt) > _SAME_DT * dt:
            raise FmuError(
                f"block {name!r} is sampled every {system.dt!r}, not every dt = {dt!r}: use its "
                "dt, or make it anew for this one"
            )
        held = state_space(system) if sampled else zero_order_hold(system, dt)
        self.inputs, self.outputs = tuple(held.input_labels), tuple(held.output_labels)
        if both := set(self.inputs) & set(self.outputs):
            raise FmuError(
                f"block {name!r}: {', '.join(sorted(both))} is an input and an output; rename one "
                "(system.set_outputs)"
            )
        self.held = np.full(len(self.inputs), np.nan)
        self.through = held.D != 0.0
        self.steps = (False,) * len(self.inputs)
        self.recorded: frozenset[str] = frozenset()
        self.units: Mapping[str, FmuUnit] = {}
        self.wide: Mapping[str, Any] = {}
        self.ended = ""
        self._a, self._b, self._c, self._d = held.A, held.B, held.C, held.D
        late = self.through.any(axis=1) & bool(sampled)
        self._before = held.C * late[:, None]
        self._after = held.C * ~late[:, None]
        self._x = np.zeros(held.nstates)

    def start(self) -> FloatArray:
        found: FloatArray = self._c @ self._x
        return found

    def step(self, inputs: FloatArray) -> FloatArray:
        shown = self._before @ self._x + self._d @ inputs
        self._x = self._a @ self._x + self._b @ inputs
        found: FloatArray = shown + self._after @ self._x
        return found


class _Source:
    """A trajectory: at every communication point its own value at that time."""

    def __init__(self, trajectory: Trajectory, time: FloatArray) -> None:
        self.inputs: tuple[str, ...] = ()
        self.outputs = tuple(derivative_name(k) for k in range(trajectory.order + 1))
        self.held = np.zeros(0)
        self.through = np.zeros((len(self.outputs), 0), dtype=bool)
        self.steps: tuple[bool, ...] = ()
        self.recorded: frozenset[str] = frozenset()
        self.units: Mapping[str, FmuUnit] = {}
        self.wide: Mapping[str, Any] = {}
        self.ended = ""
        self.values = np.array([trajectory(time, k) for k in range(trajectory.order + 1)]).T
        self._next = 0

    def start(self) -> FloatArray:
        return np.asarray(self.values[0])

    def step(self, inputs: FloatArray) -> FloatArray:  # noqa: ARG002
        self._next += 1
        return np.asarray(self.values[self._next])
