"""`cosimulate`: FMUs, linear systems and trajectories stepped together, connected by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from ...shaping.checks import positive
from ...shaping.pieces import FloatArray
from ...shaping.trajectory import Motion
from ..importing.description import FmuError, FmuTerminated, candidates
from ..importing.stepping import Fmu
from .cosimulation_result import CosimulationResult
from .mixing import mix
from .participants import Participant, participant, start_time
from .progress import progress_bar
from .wiring import Connections, Wiring, connect, loops

MAX_VALUES = 2**28
"""Values (signals times steps) that a result may have."""

_ON_GRID = 1e-9
_CHUNKS = 200


def cosimulate(
    blocks: Mapping[str, Any],
    connections: Connections,
    *,
    dt: float,
    duration: float,
    order: Literal["gauss-seidel", "jacobi"] | Sequence[str] = "gauss-seidel",
    progress: bool | None = None,
) -> CosimulationResult:
    """Step several blocks together, their inputs held over each communication step.

    With "gauss-seidel" the blocks step one after another, in the order in which they are given,
    and each is given the latest that the others show: the result of this step from those before
    it, that of the step before from those behind it. With "jacobi" all are given what the others
    showed at the step's start. So a loop [controller, plant] is by "gauss-seidel" exactly the
    sampled loop with a zero-order hold, and by "jacobi" has one sample of delay more. The result
    states the delay of every connection and loop.

    What a block shows after its step from t_k to t_{k+1}:

    - an FMU, its outputs (a sampled controller in an FMU: the tick of t_k);
    - a linear system, C·x_{k+1}; an output with feedthrough C·x_k + D·u_k where the system is
      discrete (the tick of t_k; before the first tick C·x_0), and C·x_{k+1} + D·u_k where it is
      continuous (its input is held: the exact `zero_order_hold`);
    - a trajectory, whatever the order, its values at t_k until t_{k+1}. (A shaper that is an FMU
      shows those of t_{k+1} to the blocks behind it: put it last for those of t_k.)

    Parameters
    ----------
    blocks : mapping of str to Fmu, Trajectory, control.StateSpace or control.TransferFunction
        Or to a plant whose `system()` returns one, such as `Inertia`. Names without dots. FMUs go
        on from their present state and stay where the run ends; linear systems begin at rest. A
        trajectory has the outputs position, velocity, … .
    connections : pairs (source, target), or mapping of source to target or targets
        "block.signal" each. A source may begin with "-" or a gain, as in "57.3*plant.y", or be
        known in advance: a number, a Trajectory (its position), a function of time, or a pair of
        arrays (times, values); then the target is given its value at t_k for the step from t_k.
        A table's values are joined by straight lines, for discrete inputs held; beyond its ends it
        is held. Several sources of one target are added; arrays of the same shape may be named
        whole. Inputs of FMUs that are not connected stay as they are. Where both ends have units
        of one dimension, numbers are converted (rad to deg), by the base units that the FMUs
        declare, else by the units' names; with a gain they are not, for then it is the gain that
        leads from one unit to the other.
    dt : float
        Communication step; discrete systems must have it as theirs.
    duration : float
        A multiple of dt.
    order : "gauss-seidel", "jacobi" or sequence of str, optional
        Names of all the blocks, for "gauss-seidel" in that order.
    progress : bool, optional
        Whether to show a progress bar. Default: on a terminal, where the run takes over a second.

    Returns
    -------
    CosimulationResult
        Where an FMU ends the simulation, as FMI allows, with the rows up to then, and `ended`.

    Raises
    ------
    TypeError
        For a block of another kind.
    FmuError
        A ValueError, for names that nothing has, loose inputs of linear systems, algebraic loops,
        units of different dimension, a duration that is no multiple of dt, FMUs that stand at
        different times, signals that leave the range of a double, and whatever an FMU reports.
        Its `result` is a CosimulationResult of the rows before the error, where there are any.

    References
    ----------
    Kübler and Schiehlen, "Two methods of simulator coupling", Mathematical and Computer Modelling
    of Dynamical Systems 6(2), 2000.

    Examples
    --------
    >>> import control
    >>> integrator = control.tf([1], [1, 0], inputs="u", outputs="y")
    >>> gain = control.tf([0.5], [1.0], 1.0, inputs="e", outputs="u")
    >>> run = cosimulate(
    ...     {"controller": gain, "plant": integrator},
    ...     [(1.0, "controller.e"), ("-plant.y", "controller.e"), ("controller.u", "plant.u")],
    ...     dt=1.0,
    ...     duration=3.0,
    ... )
    >>> run["plant.y"].tolist()
    [0.0, 0.5, 0.75, 0.875]
    >>> dict(run.loops)
    {'controller -> plant -> controller': 0}
    """
    dt = positive("dt", dt)
    _check_names(blocks)
    time = _grid(start_time(blocks.items()), dt, positive("duration", duration))
    method, sequence = _order(order, list(blocks))
    parts = {name: participant(name, block, dt, time) for name, block in blocks.items()}
    if not any(part.outputs for part in parts.values()):
        raise FmuError(
            f"{', '.join(parts)}: no outputs that are numbers: there is nothing to show; load "
            "the FMU with record=[…], the variables to show (on the command line --record)"
        )
    values = len(time) * sum(len(part.outputs) + len(part.inputs) for part in parts.values())
    if values > MAX_VALUES:
        raise FmuError(
            f"{len(time)} communication points of these blocks are {values} values: expected at "
            f"most {MAX_VALUES}; use a larger dt or a shorter duration"
        )
    wiring = connect(parts, connections, time)
    sources = frozenset(n for n, block in blocks.items() if isinstance(block, Motion))
    with progress_bar(progress) as advance, np.errstate(over="ignore", invalid="ignore"):
        run, error = _run(parts, wiring, time, sequence, sources, method == "jacobi", advance)
    delays, extra = _delays(wiring, method, sequence, sources)
    outputs = tuple(f"{name}.{signal}" for name, part in parts.items() for signal in part.outputs)
    result = CosimulationResult(
        time[: len(next(iter(run.values())))],
        MappingProxyType(run),
        outputs,
        tuple(sequence),
        method,
        delays,
        extra,
        ended=next((part.ended for part in parts.values() if part.ended), ""),
        notes=wiring.notes,
    )
    if error is not None:
        error.result = result
        raise error
    return result


def _delays(
    wiring: Wiring, method: str, sequence: list[str], sources: frozenset[str]
) -> tuple[Mapping[str, int], Mapping[str, int]]:
    """Return the delay of each connection, and of each loop beyond that of a hold."""
    place = {name: i for i, name in enumerate(sequence)}
    by_text, by_link = {}, {}
    for source, target, text in wiring.links:
        late = method == "jacobi" or source in sources or place[source] >= place[target]
        by_text[text] = by_link[source, target] = int(late)
    extra = {
        " -> ".join((*loop, loop[0])): sum(by_link[link] for link in _around(loop)) - 1
        for loop in loops(by_link, sequence)
    }
    return MappingProxyType(by_text), MappingProxyType(extra)


def _around(loop: tuple[str, ...]) -> list[tuple[str, str]]:
    return list(zip(loop, (*loop[1:], loop[0]), strict=True))


def _run(
    parts: Mapping[str, Participant],
    wiring: Wiring,
    time: FloatArray,
    sequence: list[str],
    sources: frozenset[str],
    at_once: bool,
    advance: Any,
) -> tuple[dict[str, FloatArray], FmuError | None]:
    """Return the signals of all blocks by name, and the error that broke the run off."""
    wide = {n: [i for i, s in enumerate(p.inputs) if s in p.wide] for n, p in parts.items()}
    exact = any(part.wide for part in parts.values())
    places = _places(parts)
    shown = np.concatenate(
        [part.start() for part in parts.values()], dtype=object if exact else float
    )
    outputs = np.empty((len(time), len(shown)), shown.dtype)
    inputs = wiring.given  # to which is added, step by step, what the blocks show
    turns = [
        (parts[n].step, *_used(wiring.weights[n]), wide[n], places[n], inputs[n])
        for n in sequence
        if n not in sources
    ]
    given = [(parts[n].step, places[n], parts[n].held) for n in sequence if n in sources]
    steps = len(time) - 1
    chunk = max(steps // _CHUNKS, 1)
    outputs[0] = shown
    first = [
        mix(record[0], weights, shown[used], whole) for _, weights, used, whole, _, record in turns
    ]
    watched = np.array([s not in part.recorded for part in parts.values() for s in part.outputs])
    rows, error, checked = 1, None, 0
    try:
        for k in range(steps):
            seen = shown.copy() if at_once else shown
            for step, weights, used, whole, place, record in turns:
                u = record[k] = mix(record[k], weights, seen[used], whole)
                shown[place] = step(u)
            for step, place, nothing in given:
                shown[place] = step(nothing)
            outputs[k + 1] = shown
            rows = k + 2
            ended = any(part.ended for part in parts.values())
            if k % chunk == 0 or k == steps - 1 or ended:
                rows = checked + _finite_rows(outputs[checked:rows, watched])
                if rows < k + 2:
                    connected = bool(wiring.links)
                    raise _not_finite(outputs[rows], parts, time[rows], connected=connected)
                checked = rows
                advance((k + 1) / steps)
            if ended:
                break
    except FmuTerminated:
        pass
    except FmuError as broken:
        error = broken
    if rows == 1:
        for (*_, record), u in zip(turns, first, strict=True):
            record[0] = u
    return _signals(parts, outputs[:rows], {n: i[:rows] for n, i in inputs.items()}), error


def _signals(
    parts: Mapping[str, Participant], outputs: Any, inputs: Mapping[str, Any]
) -> dict[str, FloatArray]:
    """Return the columns of what was recorded by name; the last inputs are those before again."""
    places, rows, signals = _places(parts), len(outputs), {}
    for name, part in parts.items():
        if rows > 1:
            inputs[name][rows - 1] = inputs[name][rows - 2]
        columns = [*outputs[:, places[name]].T, *inputs[name].T]
        for signal, column in zip((*part.outputs, *part.inputs), columns, strict=True):
            column = np.ascontiguousarray(column, dtype=part.wide.get(signal, float))
            column.flags.writeable = False
            signals[f"{name}.{signal}"] = column
    return signals


def _used(weights: FloatArray) -> tuple[FloatArray, Any]:
    """Return the weights of the outputs that count, and which these are: others may be infinite."""
    used = np.flatnonzero(weights.any(axis=0))
    return np.ascontiguousarray(weights[:, used]), used


def _places(parts: Mapping[str, Participant]) -> dict[str, slice]:
    ends = np.cumsum([len(part.outputs) for part in parts.values()]).tolist()
    return {
        name: slice(end - len(part.outputs), end)
        for (name, part), end in zip(parts.items(), ends, strict=True)
    }


def _finite_rows(rows: Any) -> int:
    """Return how many rows there are before the first that is not finite."""
    finite = np.isfinite(rows.astype(float, copy=False)).all(axis=1)
    return len(finite) if finite.all() else int(finite.argmin())


def _not_finite(
    row: Any, parts: Mapping[str, Participant], time: float, *, connected: bool
) -> FmuError:
    signals = [(name, part, own) for name, part in parts.items() for own in part.outputs]
    lost = [
        f"{name}.{own}"
        for (name, part, own), value in zip(signals, row, strict=True)
        if not np.isfinite(float(value)) and own not in part.recorded
    ]
    return FmuError(
        f"{', '.join(lost[:5])} left the range of a double at time {time:g}: "
        + (
            "the loop is unstable; check signs, gains, dt and the delays that the order causes"
            if connected
            else "check its inputs, parameters and dt"
        )
    )


def _check_names(blocks: Mapping[str, Any]) -> None:
    if not blocks:
        raise FmuError("no blocks: expected a mapping of names to FMUs, systems, trajectories")
    for name in blocks:
        if not isinstance(name, str) or not name or "." in name or name.startswith("-"):
            raise FmuError(f"block name {name!r}: expected a name without '.' or a leading '-'")
    fmus = [id(block) for block in blocks.values() if isinstance(block, Fmu)]
    if len(set(fmus)) < len(fmus):
        raise FmuError("one Fmu is two blocks: load the file twice, for two instances")


def _grid(start: float, dt: float, duration: float) -> FloatArray:
    steps = duration / dt
    if not 1.0 - _ON_GRID <= steps <= MAX_VALUES or abs(steps - round(steps)) > _ON_GRID * steps:
        raise FmuError(
            f"duration = {duration!r} is {steps:.10g} steps of dt = {dt!r}: expected a whole "
            f"number, 1 to {MAX_VALUES}; {_remedy(steps, dt)}"
        )
    return np.asarray(start + dt * np.arange(round(steps) + 1))


def _remedy(steps: float, dt: float) -> str:
    if steps > MAX_VALUES:
        return "give a larger dt or a shorter duration"
    return f"such as duration = {max(round(steps), 1) * dt:.10g}"


def _order(order: str | Sequence[str], names: list[str]) -> tuple[str, list[str]]:
    if order in ("gauss-seidel", "jacobi"):
        return str(order), names
    if isinstance(order, str):
        raise FmuError(
            f"order = {order!r}: expected 'gauss-seidel', 'jacobi' or the names of all the blocks"
        )
    for name in order:
        if name not in names:
            raise FmuError(f"order: no block {name!r}{candidates(name, names)}")
    if sorted(order) != sorted(names):
        raise FmuError(f"order = {list(order)}: expected each of {', '.join(names)} once")
    return "gauss-seidel", list(order)
