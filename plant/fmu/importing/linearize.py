"""`linearize_fmu`: an FMU about its present state as a discrete state space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from ....shaping.checks import positive, whole
from ....shaping.pieces import FloatArray
from ...sampled import zero_order_hold
from .description import FmuError, FmuVariable, candidates
from .io_system import plain_names
from .realization import impulse_response, realize
from .stepping import Fmu

if TYPE_CHECKING:
    import control

Method = Literal["auto", "directional", "impulse"]

_CONTINUOUS = ("Real", "Float64", "Float32")

MAX_HORIZON = 100_000
MAX_ORDER = 200

_AMPLITUDES = 10.0 ** -np.arange(0, 7)


def linearize_fmu(
    fmu: Fmu,
    dt: float | None = None,
    *,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    method: Method = "auto",
    amplitude: float | None = None,
    horizon: int = 2000,
    max_order: int = 20,
    tolerance: float = 1e-6,
) -> control.StateSpace:
    """Return the discrete linear model of an FMU about its present state and inputs.

        x_{k+1} = A·x_k + B·u_k,   y_k = C·x_k

    of the deviations, with u_k held over the step that begins at t_k, and y_k what the FMU shows
    at t_k before that step: the timing of `io_system`. An output that jumps with the input shows
    the jump one step later, by states that remember the input.

    With "impulse" each input is raised, and lowered, for one step, and the FMU brought back
    between the runs; half the difference over the amplitude is the impulse response, and `realize`
    finds the smallest model that has it. With "directional" the FMU's directional derivatives of
    its continuous states and outputs are discretised by `zero_order_hold`: exact, but blind to
    sampling and to a solver inside the FMU. "auto" takes the derivatives where the FMU gives
    them and steps as they say, else the impulse response.

    Parameters
    ----------
    fmu : Fmu
        Comes back as it was.
    dt : float, optional
        Communication step. Default: `fmu.dt`.
    inputs, outputs : sequence of str, optional
        Default: all that are not integers or truth values.
    method : "auto", "directional" or "impulse", optional
    amplitude : float, optional
        Of the impulses. Default: the input's nominal value (1 if it has none), less by up to six
        powers of ten until the response is linear, and not beyond the input's min or max.
    horizon : int, optional
        Steps of each run. A few time constants are better than few samples, but slow modes need
        not die out.
    max_order : int, optional
        States that are enough; a computing delay takes one per sample and input.
    tolerance : float, optional
        By how much the response may change when the amplitude is halved, and the model's response
        differ from it: relative to the largest value up to that step.

    Returns
    -------
    control.StateSpace
        Inputs and outputs named as in `io_system`.

    Raises
    ------
    FmuError
        For unknown names, an FMU that can neither go back nor give derivatives, a response that
        is not linear in the amplitude, leaves the range of a double, or that no model of
        `max_order` states has (inner sampling at another rate than dt, a limit that is met).

    Notes
    -----
    For 1/(J·s²) stepped every millisecond the frequency response is accurate to 1e-8 from 0.01 Hz
    up to half the sampling frequency.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import Inertia
    >>> from jounce.plant.fmu import export_fmu
    >>> from jounce.plant.fmu.exporting.compile import host_platform
    >>> from jounce.plant.fmu.importing.load import load_fmu
    >>> with TemporaryDirectory() as folder:
    ...     here = [host_platform()]
    ...     written = export_fmu(Inertia(2.0), f"{folder}/plant.fmu", platforms=here)
    ...     with load_fmu(written.path) as fmu:
    ...         plant = linearize_fmu(fmu, 0.5)
    >>> plant.A.round(9).tolist(), plant.B.round(9).ravel().tolist()
    ([[1.0, 0.5], [0.0, 1.0]], [0.0625, 0.25])
    """
    dt = _step_size(fmu, dt)
    horizon = whole("horizon", horizon, 4, MAX_HORIZON)
    max_order = whole("max_order", max_order, 1, MAX_ORDER)
    tolerance = positive("tolerance", tolerance)
    columns = _places(fmu, "input", fmu.input_names, inputs)
    rows = _places(fmu, "output", fmu.output_names, outputs)
    if method not in ("auto", "directional", "impulse"):
        raise ValueError(f"method = {method!r}: expected 'auto', 'directional' or 'impulse'")
    derivatives = method != "impulse" and _gives_derivatives(fmu, columns, rows)
    back = fmu.description.capabilities.can_get_and_set_state
    if method == "directional" and not derivatives:
        raise FmuError(
            f"{fmu.description.model_name} gives no directional derivatives of its states (or they "
            "are arrays): use method='impulse'"
        )
    if method == "directional" or (derivatives and not back):
        return _directional(fmu, dt, columns, rows)
    fmu.check_rollback("be linearised by impulse responses")
    measured = [_response(fmu, dt, j, rows, amplitude, horizon, tolerance) for j in columns]
    response = np.stack([found for found, _ in measured], axis=2)
    if derivatives:
        model = _directional(fmu, dt, columns, rows)
        if _distance(impulse_response(model.A, model.B, model.C, horizon), response) <= tolerance:
            return model
    noise = max(change for _, change in measured)
    found = realize(response, min(max_order, horizon // 2 - 1), noise=noise)
    if found.residual > tolerance:
        raise FmuError(
            f"no linear model of at most {max_order} states has the impulse response of "
            f"{fmu.description.model_name}: the best errs by {found.residual:.2g}, asked for "
            f"tolerance = {tolerance:g}. Raise max_order for delays or many modes, or amplitude "
            "where the outputs are large beside their change; shorten the horizon of an unstable "
            "plant; step at the FMU's own sampling time; or accept a larger tolerance"
        )
    states = [f"x{i}" for i in range(1, found.order + 1)]
    return _named(fmu, dt, columns, rows, (found.A, found.B, found.C), states)


def _response(
    fmu: Fmu,
    dt: float,
    j: int,
    rows: list[int],
    amplitude: float | None,
    horizon: int,
    tolerance: float,
) -> tuple[FloatArray, float]:
    """Return the response (horizon, rows) to a unit impulse at input j, if it is linear.

    And by how much it changes when the amplitude is halved.
    """
    variable = _input(fmu, j)
    largest = _room(variable, float(fmu.inputs[j]))
    if amplitude is not None:
        tries = [min(positive("amplitude", amplitude), largest)]
    else:
        tries = [min(abs(variable.nominal or 1.0), largest) * a for a in _AMPLITUDES.tolist()]
    change, moved = np.inf, False
    for size in tries:
        response = _impulse(fmu, dt, j, size, horizon)[:, rows]
        change = _distance(_impulse(fmu, dt, j, 0.5 * size, horizon)[:, rows], response)
        if moved and not response.any():
            break  # a dead zone
        if change <= tolerance:
            return response, change
        moved = moved or bool(response.any())
    raise FmuError(
        f"the response of {fmu.description.model_name} to {fmu.input_names[j]!r} is not linear: "
        f"half an impulse of {size:g} changes it by {change:.2g} of its peak, tolerance = "
        f"{tolerance:g}; give another amplitude, a shorter horizon or a larger tolerance"
    )


def _impulse(fmu: Fmu, dt: float, j: int, size: float, horizon: int) -> FloatArray:
    state, held = fmu.get_state(), fmu.inputs
    runs = []
    try:
        for sign in (1.0, -1.0):
            fmu.set_state(state)
            raised = held.copy()
            raised[j] += sign * size
            outputs = np.empty((horizon, len(fmu.output_names)))
            outputs[0] = fmu.step(raised, dt)
            outputs[1] = fmu.step(held, dt)
            for k in range(2, horizon):
                outputs[k] = fmu.step(None, dt)
            runs.append(outputs)
    finally:
        fmu.set_state(state)
    with np.errstate(over="ignore", invalid="ignore"):
        found: FloatArray = (runs[0] - runs[1]) / (2.0 * size)
    if not np.isfinite(found).all():
        raise FmuError(
            f"the impulse response of {fmu.description.model_name} leaves the range of a double "
            f"within {horizon} steps: shorten the horizon"
        )
    return found


def _distance(found: FloatArray, expected: FloatArray) -> float:
    """Return the largest difference, relative to each channel's largest value so far."""
    peaks = np.maximum.accumulate(np.abs(expected), axis=0)
    floor = np.where(peaks[-1] > 0.0, np.finfo(float).tiny, np.inf)
    scale = np.maximum(peaks, floor)
    with np.errstate(invalid="ignore", over="ignore"):
        ratio = np.abs(found - expected) / np.maximum(scale, 1e-12 * peaks[-1])
    return float(np.nan_to_num(ratio, nan=np.inf).max(initial=0.0))


def _gives_derivatives(fmu: Fmu, columns: list[int], rows: list[int]) -> bool:
    says = fmu.description
    if not (says.capabilities.provides_directional_derivatives and says.derivatives):
        return False
    slopes = [says.variable(unknown.name) for unknown in says.derivatives]
    scalars = {variable.name for variable in says.variables if not variable.shape}
    names = [fmu.input_names[j] for j in columns] + [fmu.output_names[i] for i in rows]
    return all(v.derivative_of and not v.shape for v in slopes) and scalars.issuperset(names)


def _directional(fmu: Fmu, dt: float, columns: list[int], rows: list[int]) -> control.StateSpace:
    import control

    says = fmu.description
    slopes = [says.variable(d.name) for d in says.derivatives]
    states = [says.variable(slope.derivative_of) for slope in slopes]
    unknowns = [*slopes, *(says.variable(fmu.output_names[i]) for i in rows)]
    knowns = [*states, *(says.variable(fmu.input_names[j]) for j in columns)]
    jacobian = fmu.directional(unknowns, knowns)
    n = len(states)
    a, b, c, d = jacobian[:n, :n], jacobian[:n, n:], jacobian[n:, :n], jacobian[n:, n:]
    continuous = control.StateSpace(a, b, c, 0.0 * d, remove_useless_states=False)
    held = zero_order_hold(continuous, dt)
    matrices = (held.A, held.B, held.C)
    names = [state.name for state in states]
    if d.any():
        m = len(columns)
        matrices = (
            np.block([[held.A, np.zeros((n, m))], [np.zeros((m, n + m))]]),
            np.vstack([held.B, np.eye(m)]),
            np.hstack([held.C, d]),
        )
        names += [f"{fmu.input_names[j]}_past" for j in columns]
    return _named(fmu, dt, columns, rows, matrices, names)


def _named(
    fmu: Fmu,
    dt: float,
    columns: list[int],
    rows: list[int],
    matrices: tuple[FloatArray, ...],
    states: list[str],
) -> control.StateSpace:
    import control

    inputs, outputs = plain_names(fmu.input_names), plain_names(fmu.output_names)
    return control.ss(
        *(*matrices, np.zeros((len(rows), len(columns))), dt),
        inputs=[inputs[j] for j in columns],
        outputs=[outputs[i] for i in rows],
        states=plain_names(states),
        name=plain_names([fmu.description.model_name])[0],
        remove_useless_states=False,
    )


def _step_size(fmu: Fmu, dt: float | None) -> float:
    if dt is None and fmu.dt is None:
        raise FmuError(f"{fmu.description.model_name} suggests no step size: give a dt")
    return positive("dt", fmu.dt if dt is None else dt)  # type: ignore[arg-type]


def _places(
    fmu: Fmu, causality: str, known: Sequence[str], chosen: Sequence[str] | None
) -> list[int]:
    """Return which of the inputs or outputs are chosen: by default all that are not discrete."""
    variables = {
        label: variable
        for variable in fmu.description.of_causality(causality)
        for label in variable.labels
    }
    names = chosen
    if names is None:
        names = [name for name in known if variables[name].type in _CONTINUOUS]
    if not names:
        raise FmuError(f"no {causality} to linearise: expected at least one")
    for name in names:
        if name not in known:
            raise FmuError(f"no {causality} {name!r}{candidates(name, known)}")
        if variables[name].type not in _CONTINUOUS:
            raise FmuError(
                f"{causality} {name!r} is of type {variables[name].type}, which has no "
                "derivatives: leave it out"
            )
    return [known.index(name) for name in names]


def _input(fmu: Fmu, j: int) -> FmuVariable:
    inputs = fmu.description.of_causality("input")
    return next(variable for variable in inputs if fmu.input_names[j] in variable.labels)


def _room(variable: FmuVariable, present: float) -> float:
    """Return how far an input may go both ways; FmuError where it is at a bound already."""
    above = np.inf if variable.max is None else variable.max - present
    below = np.inf if variable.min is None else present - variable.min
    room = float(min(above, below))
    if not room > 0.0:
        raise FmuError(
            f"{variable.name!r} = {present!r} is at a bound ({variable.min} to {variable.max}): "
            "step the FMU with an input between them first"
        )
    return room
