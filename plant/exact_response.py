"""Exact response of any python-control LTI system to a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..shaping import Trajectory
from ..shaping.checks import positive
from ..shaping.derivatives import derivative_number
from ..shaping.pieces import FloatArray
from ..shaping.propagate import check_fed, grid, inputs_on_grid, product, propagate
from ..shaping.real_numbers import real_array, shown
from ..shaping.trajectory import Motion, as_trajectory
from .linear_system import static_gain
from .models import StateModel

if TYPE_CHECKING:
    import control


_LARGE = 2**19  # doubles in 4 MiB


def respond(
    system: control.StateSpace | control.TransferFunction,
    trajectory: Motion,
    dt: float,
    *,
    derivatives: Sequence[int | str] = (0,),
    duration: float | None = None,
    initial_state: ArrayLike | None = None,
) -> control.TimeResponseData:
    """Return the exact response of a linear system to a trajectory.

    The trajectory is a polynomial on each piece, so the system driven by it is one larger
    linear system: no integration error and no interpolation between samples, whatever dt.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        Continuous, or discrete with this dt (or dt=True). k inputs.
    trajectory : Trajectory
        After its end it coasts.
    dt : float
        Spacing of the time grid. For a continuous system it does not change the values.
    derivatives : sequence of k int or str, optional
        Which derivative of the trajectory feeds input i, by number or name.
    duration : float, optional
        Length of the grid, which begins at the trajectory's start and ends at the last multiple
        of dt within it. Default: the trajectory's duration.
    initial_state : (n,) array, optional
        State at the start. Default: zero.

    Returns
    -------
    control.TimeResponseData
        With `time`, `outputs`, `states`, `inputs`.

    Raises
    ------
    TypeError
        For a system that is not LTI.
    ValueError
        For a number of derivatives other than of inputs, a derivative above the trajectory's
        order (a train of impulses), an improper transfer function, another sampling time than
        dt, or a dt or duration that is not positive.

    Notes
    -----
    Agrees with `control.forced_response`, where that is exact, to 1e-10 of the peak. Memory:
    8·(states + inputs + outputs) bytes per sample.

    Examples
    --------
    >>> import control
    >>> from jounce.shaping import Limits, min_time_move
    >>> lag = control.tf([1], [1, 1], inputs="r", outputs="y")
    >>> move = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0))
    >>> response = respond(lag, move, 0.01, duration=10.0)
    >>> round(float(response.outputs[-1]), 3)
    1.0
    """
    import control

    plant = state_space(system)
    numbers = [derivative_number(d) for d in derivatives]
    if len(numbers) != plant.ninputs:
        raise ValueError(
            f"{len(numbers)} derivatives for a system with {plant.ninputs} inputs "
            f"({', '.join(plant.input_labels)}): give one derivative of the trajectory per input"
        )
    trajectory = as_trajectory(trajectory)
    check_fed(trajectory, numbers)
    dt = positive("dt", dt)
    _check_timebase(plant, dt)
    time, states, inputs, outputs = respond_on_grid(
        plant, numbers, trajectory, dt, duration, _initial_state(plant, initial_state)
    )
    return control.TimeResponseData(
        time,
        outputs,
        states,
        inputs,
        issiso=plant.issiso(),
        output_labels=plant.output_labels,
        input_labels=plant.input_labels,
        state_labels=plant.state_labels,
        title="Exact response to a trajectory",
    )


def respond_on_grid(
    plant: control.StateSpace | StateModel,
    numbers: Sequence[int],
    trajectory: Trajectory,
    dt: float,
    duration: float | None,
    initial: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return time (N,), states, inputs and outputs (…, N) of the exact response.

    All are rows of one array, see `_block`.
    """
    length = trajectory.duration if duration is None else positive("duration", duration)
    time = grid(trajectory.start_time, length, dt)
    n, k = plant.nstates, max(numbers, default=-1) + 1
    rows = _block(n + k + plant.noutputs + 1, time.size)
    states, derivatives, outputs = rows[:n], rows[n : n + k], rows[n + k : -1]
    rows[-1] = time
    inputs_on_grid(trajectory, rows[-1], dt, derivatives)
    discrete = plant.isdtime()
    with np.errstate(over="ignore", invalid="ignore"):
        propagate(
            *(plant.A, plant.B, numbers, trajectory, dt, time.size, initial),
            discrete=discrete,
            out=states,
        )
    if not np.isfinite(states[:, -1]).all():
        raise ValueError(
            f"the response leaves the range of a double within {shown(length)}: the "
            "system is unstable; "
            "shorten the duration"
        )
    mixing = np.zeros((plant.noutputs, n + k))
    mixing[:, :n] = plant.C
    for i, d in enumerate(numbers):
        mixing[:, n + d] += plant.D[:, i]
    product(mixing, rows[: n + k], outputs)
    in_order = list(numbers) == list(range(k))
    return rows[-1], states, derivatives if in_order else derivatives[list(numbers)], outputs


def _block(rows: int, count: int) -> FloatArray:
    """Return an empty array (rows, count), if possible in large pages.

    numpy asks the system for large pages from 4 MiB on; what is not touched of them costs
    nothing. Asking for small pages one by one would take longer than all the arithmetic.
    """
    size = rows * count
    if size * 16 < _LARGE:
        return np.empty((rows, count))
    return np.empty(max(size, _LARGE))[:size].reshape(rows, count)


def refuse_data(system: Any) -> None:
    """Refuse frequency responses, measured ones or python-control's: TypeError."""
    if hasattr(system, "frdata") or (
        hasattr(system, "frequency_hz") and hasattr(system, "response")
    ):
        raise TypeError(
            f"a {type(system).__name__} has values at its lines alone: expected a model, which has "
            "a response in time; give analysis.fit_axis(frf).axis, or take the data to "
            "analysis.loop_margins(frf, controller=…)"
        )


def _check_finite(*parts: Any) -> None:
    for number in np.concatenate([np.ravel(part) for part in parts]).tolist():
        if not isfinite(number):
            raise ValueError(f"system with {number} in it: expected finite numbers")


def state_space(
    system: Any,
    *,
    improper: str = "feed it a derivative of the trajectory instead (derivatives=…), one power of "
    "s less for each",
) -> control.StateSpace:
    """Return an LTI system in state space, its signal names kept.

    `improper` is the remedy for a transfer function with more zeros than poles.
    """
    import control

    if isinstance(system, control.StateSpace):
        _check_finite(system.A, system.B, system.C, system.D)
        return system
    refuse_data(system)
    if not isinstance(system, control.TransferFunction):
        raise TypeError(
            f"got {type(system).__name__}: expected a python-control StateSpace or "
            "TransferFunction; linearise a nonlinear system first (control.linearize)"
        )
    _check_finite(*np.ravel(system.num_array), *np.ravel(system.den_array))
    degrees = [
        tuple(len(np.trim_zeros(part, "f")) - 1 for part in fraction)
        for fraction in zip(np.ravel(system.num_array), np.ravel(system.den_array), strict=True)
    ]
    if any(above > below for above, below in degrees):
        raise ValueError(f"improper transfer function: {improper}")
    if any(below for _, below in degrees):
        return control.ss(system)
    return static_gain(
        system(1.0, squeeze=False).real,
        system.dt,
        inputs=system.input_labels,
        outputs=system.output_labels,
        name=system.name,
    )


def _check_timebase(plant: control.StateSpace, dt: float) -> None:
    if plant.isdtime(strict=True) and plant.dt is not True and abs(plant.dt - dt) > 1e-9 * dt:
        raise ValueError(
            f"dt = {shown(dt)}: the system is sampled every {shown(plant.dt)}; use that dt"
        )


def _initial_state(plant: control.StateSpace, initial: ArrayLike | None) -> Any:
    if initial is None:
        return np.zeros(plant.nstates)
    state = real_array("initial_state", initial)
    if state.shape != (plant.nstates,) or not np.isfinite(state).all():
        raise ValueError(
            f"initial_state {shown(initial)}: expected {plant.nstates} finite numbers, "
            f"for {', '.join(plant.state_labels)}"
        )
    return state
