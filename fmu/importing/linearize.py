"""`linearize_fmu`: an FMU about its present state as a discrete state space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...plant.linear_system import linear_system
from ...plant.sampled import zero_order_hold
from ...shaping.checks import positive, whole
from ...shaping.pieces import FloatArray
from .agreement import CONTINUOUS, answers_alike
from .description import FmuError, candidates
from .io_system import plain_names
from .realization import impulse_response, realize
from .responses import Origin, check_time_invariance, difference, unit_response
from .stepping import Fmu

if TYPE_CHECKING:
    import control

Method = Literal["auto", "directional", "impulse"]

MAX_HORIZON = 100_000
MAX_ORDER = 200


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
    between the runs; half the difference over the amplitude is the impulse response. It
    must foretell what impulses at every step do together; `realize` finds the smallest model that
    has it. With "directional" the FMU's directional derivatives of
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
        Default: all that are not integers or truth values, recorded variables among the outputs.
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
        is zero, not linear in the amplitude, not the same from every step (inner sampling that
        dt is no multiple of), leaves the range of a double, or that no model of `max_order`
        states has (a limit that is met).

    Notes
    -----
    A second instance of the FMU shows whether it answers the same while a snapshot of it is kept.
    Where it does not, each run begins with a new instance in place of a snapshot, from the start.

    For 1/(J·s²) stepped every millisecond the frequency response is accurate to 1e-8 from 0.01 Hz
    up to half the sampling frequency.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import Inertia
    >>> from jounce.fmu import export_fmu
    >>> from jounce.fmu.exporting.compile import host_platform
    >>> from jounce.fmu.importing.load import load_fmu
    >>> with TemporaryDirectory() as folder:
    ...     here = [host_platform()]
    ...     written = export_fmu(Inertia(2.0), f"{folder}/plant.fmu", platforms=here)
    ...     with load_fmu(written.path) as fmu:
    ...         plant = linearize_fmu(fmu, 0.5)
    >>> plant.A.round(9).tolist(), plant.B.round(9).ravel().tolist()
    ([[1.0, 0.5], [0.0, 1.0]], [0.0625, 0.25])
    """
    if not isinstance(fmu, Fmu):
        raise TypeError(f"fmu = {fmu!r}: expected an Fmu; open the file with load_fmu first")
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
    with _origin(fmu, dt, horizon) as origin:
        measured = [
            unit_response(origin, dt, j, rows, amplitude, horizon, tolerance) for j in columns
        ]
        for j, one in zip(columns, measured, strict=True):
            check_time_invariance(origin, dt, j, rows, one, tolerance)
    response = np.stack([found.values for found in measured], axis=2)
    if not response.any():
        sizes = ", ".join(f"{found.size:g}" for found in measured)
        raise FmuError(
            f"the outputs of {fmu.description.model_name} do not react to an impulse of {sizes}: "
            "give a larger amplitude, or step the FMU to a point where its inputs act"
        )
    if derivatives:
        model = _directional(fmu, dt, columns, rows)
        if difference(impulse_response(model.A, model.B, model.C, horizon), response) <= tolerance:
            return model
    noise = max(found.change for found in measured)
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


@contextmanager
def _origin(fmu: Fmu, dt: float, horizon: int) -> Iterator[Origin]:
    """Yield the FMU's present point, with a way back on which it answers as it does without."""
    if answers_alike(fmu, dt, horizon):
        origin = Origin(fmu)
        try:
            yield origin
        finally:
            origin.back()
        return
    if not fmu.at_start:
        raise FmuError(
            f"{fmu.description.model_name} answers otherwise while a snapshot of it is kept "
            "(noSetFMUStatePriorToCurrentPoint false) than it does without, so it can be "
            "linearised at its start only: call linearize_fmu just after load_fmu or reset, with "
            "start values or parameters for the point that is meant"
        )
    with fmu.twin() as twin:
        yield Origin(twin, by_restart=True)


def _gives_derivatives(fmu: Fmu, columns: list[int], rows: list[int]) -> bool:
    says = fmu.description
    if not (says.capabilities.provides_directional_derivatives and says.derivatives):
        return False
    slopes = [says.variable(unknown.name) for unknown in says.derivatives]
    shown = says.of_causality("input", "output")
    scalars = {variable.name for variable in shown if not variable.shape}
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
    inputs, outputs = plain_names(fmu.input_names), plain_names(fmu.output_names)
    return linear_system(
        (*matrices, np.zeros((len(rows), len(columns)))),
        dt,
        inputs=[inputs[j] for j in columns],
        outputs=[outputs[i] for i in rows],
        states=plain_names(states),
        name=plain_names([fmu.description.model_name])[0],
    )


def _step_size(fmu: Fmu, dt: float | None) -> float:
    return positive("dt", fmu.dt if dt is None else dt)


def _places(
    fmu: Fmu, causality: str, known: Sequence[str], chosen: Sequence[str] | None
) -> list[int]:
    """Return which of the inputs or outputs are chosen: by default all that are not discrete."""
    variables = {label: fmu.description.variable(label) for label in known}
    names = chosen
    if names is None:
        names = [name for name in known if variables[name].type in CONTINUOUS]
    if not names:
        raise FmuError(f"no {causality} to linearise: expected at least one")
    for name in names:
        if name not in known:
            raise FmuError(f"no {causality} {name!r}{candidates(name, known)}")
        if variables[name].type not in CONTINUOUS:
            raise FmuError(
                f"{causality} {name!r} is of type {variables[name].type}, which has no "
                "derivatives: leave it out"
            )
    return [known.index(name) for name in names]
