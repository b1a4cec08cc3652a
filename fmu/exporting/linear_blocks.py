"""Any python-control linear system as a block, continuous or discrete in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...plant.balance import balanced
from .blocks import Block, Variable
from .loop_blocks import HELD
from .motion_blocks import SAMPLING
from .units import rate

if TYPE_CHECKING:
    import control

MAX_STATES = 200
"""Most states of a linear system that is exported."""

_TICKS = 1000

Dependencies = list[dict[str, str]]


def linear_block(system: control.StateSpace, name: str, unit_of: Mapping[str, str]) -> Block:
    """Return a linear system as a block, of continuous time or with a fixed sample time."""
    _check(system, unit_of)
    if system.isdtime(strict=True):
        return _discrete(system, name, unit_of)
    return _continuous(system, name, unit_of)


def _check(system: control.StateSpace, unit_of: Mapping[str, str]) -> None:
    if system.nstates > MAX_STATES:
        raise ValueError(
            f"a system of {system.nstates} states: expected at most {MAX_STATES}; reduce it first"
        )
    if not all(np.isfinite(part).all() for part in (system.A, system.B, system.C, system.D)):
        raise ValueError("the system has a coefficient that is not finite")
    known = [*system.input_labels, *system.output_labels, *system.state_labels]
    unknown = sorted(set(unit_of) - set(known))
    if unknown:
        raise ValueError(f"unit of {', '.join(unknown)}: expected names of {', '.join(known)}")
    if system.dt is True:
        raise ValueError(
            "a discrete system without a sampling time (dt = True): give it one, as in "
            "control.ss(A, B, C, D, dt)"
        )


def _continuous(system: control.StateSpace, name: str, unit_of: Mapping[str, str]) -> Block:
    matrix, scale = balanced(system.A)
    fastest = float(np.abs(system.poles()).max(initial=0.0))
    step = 10.0 ** float(np.floor(np.log10(0.1 / fastest))) if fastest > 0.0 else 1e-3
    return Block(
        name,
        f"Linear system of continuous time, {system.nstates} states",
        (
            *_inputs(system, unit_of, "held during each step"),
            *_outputs(system, unit_of, _depending(system, system.C, system.D)),
            *_states(system, unit_of, "continuous"),
            *_rates(system, unit_of),
        ),
        "continuous",
        constants=_sizes(system),
        tables={
            "rate_by_state": table_rows(matrix),
            "rate_by_input": table_rows(system.B / scale[:, None]),
            "output_by_state": table_rows(system.C),
            "output_by_input": table_rows(system.D),
            "scale": table_rows(scale),
        },
        work=1 + system.nstates * (4 * system.nstates + system.ninputs + 1),
        partials=True,
        stop_time=_TICKS * step,
        step=step,
        notes=(
            "Exact, by matrix exponential, for inputs that are held during each communication "
            "step. The exponential is kept as long as the length of the step stays the same.",
        ),
    )


def _discrete(system: control.StateSpace, name: str, unit_of: Mapping[str, str]) -> Block:
    dt = float(system.dt)
    known = dict.fromkeys(
        [*system.input_labels, *(_state_name(label) for label in system.state_labels)], "constant"
    )
    depending = [{own: known[own] for own in on} for on in _depending(system, system.C, system.D)]
    return Block(
        name,
        f"Discrete linear system, {system.nstates} states",
        (
            *_inputs(system, unit_of, "taken over at every sample"),
            *_outputs(system, unit_of, depending, held=True),
            *_states(system, unit_of, "discrete"),
            Variable("sample_time", "Sample time", "local", "constant", "exact", dt, "s"),
        ),
        "discrete",
        constants=_sizes(system) | {"SAMPLE_TIME": repr(dt)},
        tables={
            "row_by_state": table_rows(np.vstack([system.A, system.C])),
            "row_by_input": table_rows(np.vstack([system.B, system.D])),
        },
        memory=system.nstates,
        sample_time=dt,
        stop_time=_TICKS * dt,
        step=dt,
        notes=(SAMPLING, HELD),
    )


def _inputs(system: control.StateSpace, unit_of: Mapping[str, str], how: str) -> list[Variable]:
    return [
        Variable(label, f"Input {label}, {how}", "input", unit=unit_of.get(label, "1"))
        for label in system.input_labels
    ]


def _outputs(
    system: control.StateSpace,
    unit_of: Mapping[str, str],
    depending: Dependencies,
    *,
    held: bool = False,
) -> list[Variable]:
    return [
        Variable(
            label,
            f"Output {label}",
            "output",
            "discrete" if held else "continuous",
            "calculated",
            unit=unit_of.get(label, "1"),
            dependencies={} if held else on,
            initial_dependencies=on,
        )
        for label, on in zip(system.output_labels, depending, strict=True)
    ]


def _states(
    system: control.StateSpace, unit_of: Mapping[str, str], variability: str
) -> list[Variable]:
    return [
        Variable(
            _state_name(label),
            f"State {label}",
            "local",
            variability,
            "exact",
            unit=unit_of.get(label, "1"),
            state=variability == "continuous",
        )
        for label in system.state_labels
    ]


def _rates(system: control.StateSpace, unit_of: Mapping[str, str]) -> list[Variable]:
    return [
        Variable(
            f"der({_state_name(label)})",
            f"Derivative of state {label}",
            "local",
            initial="calculated",
            unit=rate(unit_of.get(label, "1"), 1),
            derivative_of=_state_name(label),
            dependencies=on,
            initial_dependencies=on,
        )
        for label, on in zip(
            system.state_labels, _depending(system, system.A, system.B), strict=True
        )
    ]


def _state_name(label: str) -> str:
    """Return a name that differs from that of an output of the same label."""
    return f"state.{label}"


def _depending(
    system: control.StateSpace, by_state: ArrayLike, by_input: ArrayLike
) -> Dependencies:
    """Return the states and inputs on which each row depends."""
    known = [*(_state_name(label) for label in system.state_labels), *system.input_labels]
    feeds = np.hstack([np.asarray(by_state), np.asarray(by_input)])
    return [{known[j]: "constant" for j in np.flatnonzero(row)} for row in feeds]


def _sizes(system: control.StateSpace) -> dict[str, str]:
    """Return the numbers of signals, and where the values of each kind begin."""
    n, m, p = system.nstates, system.ninputs, system.noutputs
    sizes = {"N_STATES": n, "N_INPUTS": m, "N_OUTPUTS": p}
    sizes |= {"V_INPUT": 0, "V_OUTPUT": m, "V_STATE": m + p, "V_DERIVATIVE": m + p + n}
    return {name: str(size) for name, size in sizes.items()}


def table_rows(values: ArrayLike) -> list[object]:
    """Return an array as lists; C has none that are empty."""
    array = np.asarray(values, dtype=float)
    least = tuple(max(size, 1) for size in array.shape)
    return list(
        np.pad(array, [(0, b - a) for a, b in zip(array.shape, least, strict=True)]).tolist()
    )
