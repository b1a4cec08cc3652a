"""Exact sampled-data models: a plant behind a zero-order hold and a computing delay."""

from __future__ import annotations

from math import ceil, log2
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shaping.checks import finite, positive
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import shown
from .balance import balanced
from .exact_response import state_space
from .linear_system import linear_system
from .models import StateModel

if TYPE_CHECKING:
    import control


MAX_DELAY = 1000
"""Samples that a computing delay may take: each one is a state per input."""

_ON_SAMPLE = 1e-13  # a delay this near to a whole number of samples, relative to it, is whole
_TAYLOR_TERMS = 18  # for a norm of at most 1/2: the remainder is 1e-23


def zero_order_hold(
    system: control.StateSpace | control.TransferFunction, dt: float, *, delay: float = 0.0
) -> control.StateSpace:
    """Return the exact discrete model of a continuous plant behind a hold and a delay.

    The input u_k takes effect at t_k + τ and is held until u_{k+1} does. With τ = m·dt + θ,
    0 ≤ θ < dt, the states at the samples obey

        x_{k+1} = Φ·x_k + Γ_1·u_{k−m−1} + Γ_0·u_{k−m},   Φ = e^(A·dt),
        Γ_0 = ∫_0^{dt−θ} e^(As) ds·B,   Γ_1 = e^(A(dt−θ))·∫_0^θ e^(As) ds·B,

    whatever A; for θ = 0, Γ_1 = 0.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        Continuous, with any number of inputs and outputs.
    dt : float
        Sampling time, positive.
    delay : float, optional
        τ ≥ 0, of any length up to `MAX_DELAY` samples.

    Returns
    -------
    control.StateSpace
        With the system's signal names and, behind its states, those of the delay:
        <input>_past_1, <input>_past_2, … are the input 1, 2, … samples before. A direct
        feedthrough passes on what is held just after the sample, as in `control.sample_system`.

    Raises
    ------
    TypeError
        For a system that is not LTI.
    ValueError
        For a system that is discrete already or improper, coefficients that are not finite, a
        delay that is negative or too long, a dt that is not positive, or a response that leaves
        the range of a double within dt.

    Notes
    -----
    Where e^(A·dt) is of the order of 1, its entries are accurate to 1e-13·max(1, ‖A‖·dt) of the
    largest, ‖A‖ after balancing the units of the states.

    References
    ----------
    Åström and Wittenmark, "Computer-Controlled Systems": sampling a system with a time delay.

    Examples
    --------
    >>> from jounce.plant import Inertia
    >>> held = zero_order_hold(Inertia(1.0).system(), 1.0, delay=0.5)
    >>> held.A.tolist()
    [[1.0, 1.0, 0.375], [0.0, 1.0, 0.5], [0.0, 0.0, 0.0]]
    >>> held.B.ravel().tolist()
    [0.125, 0.5, 1.0]
    """
    plant = _continuous(system)
    held = held_model(StateModel.of(plant), dt, delay)
    past = (held.nstates - plant.nstates) // max(plant.ninputs, 1)
    return linear_system(
        (held.A, held.B, held.C, held.D),
        held.dt,
        inputs=plant.input_labels,
        outputs=plant.output_labels,
        states=plant.state_labels
        + [f"{name}_past_{i}" for i in range(1, past + 1) for name in plant.input_labels],
        name=system.name,
    )


def held_model(plant: StateModel, dt: float, delay: float) -> StateModel:
    """Return the numbers of `zero_order_hold`."""
    dt = positive("dt", dt)
    whole, rest = _in_samples(delay, dt)
    matrices = _held(plant, dt, whole, rest)
    if not all(np.isfinite(matrix).all() for matrix in matrices):
        raise ValueError(
            f"within dt = {shown(dt)} the response leaves the range of a double: use a smaller dt"
        )
    a, b, c, d = matrices
    return StateModel(a, b, c, d, dt)


def loop_behind(
    plant: control.StateSpace, controller: control.StateSpace, delay: float
) -> control.StateSpace:
    """Return the sampled loop, broken at the plant's input, of a discrete controller.

    Parameters
    ----------
    plant : control.StateSpace
        Continuous, u → at least as many outputs as the controller has inputs; the first of them,
        with the sign turned, are what the controller is given.
    controller : control.StateSpace
        Discrete.
    delay : float
        As in `zero_order_hold`.
    """
    import control

    seen = controller.ninputs
    measured = control.ss(
        *(plant.A, plant.B, plant.C[:seen], plant.D[:seen]),
        inputs=plant.input_labels,
        states=plant.state_labels,
    )
    held = zero_order_hold(measured, controller.dt, delay=delay)
    loop = StateModel.of(controller).behind(StateModel.of(held))
    return control.ss(
        *(loop.A, loop.B, loop.C, loop.D, controller.dt),
        inputs=plant.input_labels,
        outputs=controller.output_labels,
        states=held.state_labels + controller.state_labels,
        name="sampled_loop",
    )


def _continuous(system: Any) -> control.StateSpace:
    plant = state_space(
        system,
        improper="a held input jumps, and its derivative is a train of impulses; add the lag that "
        "makes the system proper",
    )
    if plant.isdtime(strict=True):
        raise ValueError(
            f"the system is sampled already, with dt = {shown(plant.dt)}: expected a continuous one"
        )
    return plant


def _in_samples(delay: float, dt: float) -> tuple[int, float]:
    """Return m and θ of delay = m·dt + θ, 0 ≤ θ < dt."""
    delay = finite("delay", delay)
    if delay < 0.0:
        raise ValueError(f"delay = {shown(delay)}: expected a number ≥ 0")
    if delay > MAX_DELAY * dt:
        raise ValueError(
            f"delay = {shown(delay)} is {delay / dt:.4g} samples of dt = {shown(dt)}: expected at "
            f"most {MAX_DELAY}; use a larger dt"
        )
    samples = delay / dt
    whole = round(samples)
    if abs(samples - whole) <= _ON_SAMPLE * max(whole, 1):
        return whole, 0.0
    return int(samples), (samples - int(samples)) * dt


def _held(plant: StateModel, dt: float, whole: int, rest: float) -> tuple[FloatArray, ...]:
    """Return A, B, C and D of the held and delayed plant.

    They are cut out of the matrices that act on [x; u_k; u_{k−1}; …].
    """
    n, k = plant.nstates, plant.ninputs
    past = whole + (rest > 0.0)
    following = np.zeros((n + past * k, n + (past + 1) * k))
    seen = np.zeros((plant.noutputs, n + (past + 1) * k))

    def inputs_before(samples: int) -> slice:
        return slice(n + samples * k, n + (samples + 1) * k)

    with np.errstate(over="ignore", invalid="ignore"):
        change, integral = exponential_less_one(plant.A, dt - rest)
        following[:n, inputs_before(whole)] = integral @ plant.B
        if rest:
            first_change, first_integral = exponential_less_one(plant.A, rest)
            gained = first_integral @ plant.B
            following[:n, inputs_before(whole + 1)] = gained + change @ gained
            change = first_change + change + change @ first_change
    following[:n, :n] = np.eye(n) + change
    following[n:, n : n + past * k] = np.eye(past * k)
    seen[:, :n] = plant.C
    seen[:, inputs_before(past)] = plant.D
    now = inputs_before(0)
    return (
        np.delete(following, now, axis=1),
        following[:, now],
        np.delete(seen, now, axis=1),
        seen[:, now],
    )


def exponential_less_one(a: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
    """Return e^(A·t) − 1 and ∫_0^t e^(As) ds, by the Taylor series of a fraction of t, doubled.

    Both in one pass and without B, so that no unit of the inputs costs squarings.
    """
    matrix, scale = balanced(a)
    norm = float(np.abs(matrix).sum(axis=0).max(initial=0.0)) * time
    doublings = max(ceil(log2(norm)) + 1, 0) if 0.0 < norm < np.inf else 0
    step = time * 0.5**doublings
    small, one = matrix * step, np.eye(len(a))
    total = one
    for k in range(_TAYLOR_TERMS + 1, 1, -1):
        total = one + small @ total / k
    change, integral = small @ total, step * total
    for _ in range(doublings):
        integral = 2.0 * integral + change @ integral
        change = 2.0 * change + change @ change
    return change * scale[:, None] / scale, integral * scale[:, None] / scale
