"""The exact inverse of an axis: what makes its load follow a command exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..shaping.checks import whole as whole_number
from ..shaping.pieces import MAX_ORDER, FloatArray
from .axis import Axis, as_axis
from .cascade import CascadedPI
from .commands import command_order
from .controller import as_controller
from .feedforward import Feedforward

_NOTHING = 1e-9  # of the largest term, in the axis's own unit of time


def inverse_feedforward(plant: Any, command: Any = None, *, controller: Any = None) -> Feedforward:
    """Return the feedforward that makes the load of an axis follow the command exactly.

    With the load's position flat, g_load(s) = N_0/D(s), N_0 constant,

        torque = D(d/dt)·r/N_0,   y_motor = N_motor(d/dt)·r/N_0,

    which has derivatives up to twice the number of masses. Of one mode, with B and B_L the viscous
    friction of motor and load, λ the load's share, k its spring and ω the free-free frequency,

        y_motor = r + (B_L·ṙ + λ·J·r̈)/k,
        torque = (B + B_L)·ṙ + (J + B·B_L/k)·r̈ + ((1 − λ)·B_L + λ·B)·J/k·r⃛ + J/ω²·r⁗.

    Viscous friction and springs are in it; Coulomb friction is fed forward by its sign. A current
    loop's lag adds a derivative.

    Parameters
    ----------
    plant : Inertia, FlexibleInertia or Axis
    command : Trajectory, Transfer, Ramp, Sine or a sum of them, optional
        What is to be followed. Derivatives above its order, trains of impulses, are left out:
        `requirement(command)` of what is returned says what the command lacks.
    controller : PID, CascadedPI or Controller, optional
        A cascade takes its velocity from the motor and from ṙ, so that its reference differs from
        a PID's, the default.

    Returns
    -------
    Feedforward
        Its `order` is that which the command needs: with order n of the trajectory equal to it
        the torque is bounded, with one more it is continuous.

    Raises
    ------
    ValueError
        For an axis whose load is not flat: damping inside the structure gives the inverse poles,
        modes of which some are left out may give unstable ones. `low_frequency_feedforward` takes
        those.

    Notes
    -----
    In a continuous loop the load follows to rounding. Hold and delay of a digital controller leave
    an error of about torque′·(delay + sample_time/2), most of which `lead` takes back. A PID on
    two encoders has no exact reference: its velocity is the motor's, its position the load's.

    Examples
    --------
    >>> from jounce.plant import FlexibleInertia
    >>> inverse = inverse_feedforward(FlexibleInertia(2.0, 20.0, 0.0, load_fraction=0.6))
    >>> [(k, round(gain, 9)) for k, gain in inverse.torque.items()]
    [(2, 2.0), (4, 0.000126651)]
    """
    axis = as_axis(plant)
    whole, load, motor = _polynomials(axis)
    if len(load) > 1:
        raise _not_flat(load)
    return _feedforward(axis, whole / load[0], motor / load[0], command, controller)


def low_frequency_feedforward(
    plant: Any, command: Any = None, *, order: int = 4, controller: Any = None
) -> Feedforward:
    """Return the inverse's expansion about frequency 0, up to a derivative of the command.

        torque = B·ṙ + J·r̈ + … + s·r⁗,   y_motor = r + q·r̈ + …

    from the quotients of the axis's polynomials, s = −J·Σ a_i·b_i/ω_i², q = Σ (a_i² − a_i·b_i)/ω_i²
    without friction. It takes damped modes, and models of which higher modes are left out. The
    load's error is about the first derivative that is left out: of a mode damped by ζ and order 4
    2ζ/ω³ times the fifth, without damping 1/ω⁴ times the sixth. Measured on a 20 Hz mode of 40 %
    of the inertia, 0.5 rad in 0.441 s, snap bounded, in a 4 Hz loop, the load's peak error: 4e-16
    rad undamped, 3.6e-6, 7.0e-6 and 3.1e-5 rad at 0.5, 1 and 5 % damping; 1.9e-3 rad at order 2.

    Parameters
    ----------
    plant : Inertia, FlexibleInertia or Axis
    command : Trajectory, Transfer, Ramp, Sine or a sum of them, optional
        Derivatives above its order are left out, as in `inverse_feedforward`.
    order : int, optional
        Highest derivative for the torque, 2 to 40; the motor's position is taken as far as the
        rate of its reference needs no higher one.
    controller : PID, CascadedPI or Controller, optional
        As in `inverse_feedforward`.
    """
    axis, order = as_axis(plant), whole_number("order", order, 2, MAX_ORDER)
    whole, load, motor = _polynomials(axis)
    torque, ahead = _quotient(whole, load, order + 1), _quotient(motor, load, order)
    return _feedforward(axis, torque, ahead, command, controller)


def _not_flat(load: FloatArray) -> ValueError:
    """Return the error for a load whose inverse has poles."""
    poles = np.roots(load[::-1])
    worst = poles[np.argmax(poles.real)]
    if worst.real > 0.0:
        told = (
            f"the inverse of this axis is unstable, with a pole at {worst.real:.4g} rad/s: modes "
            "are left out of it, or load and motor move against each other"
        )
    else:
        told = (
            f"the inverse of this axis has poles, the slowest at {worst.real:.4g} rad/s: damping "
            "between the masses, or modes that are no chain of masses. Leave out the damping"
        )
    return ValueError(f"{told}; use low_frequency_feedforward(axis), exact up to snap")


def _feedforward(
    axis: Axis, torque: FloatArray, motor: FloatArray, command: Any, controller: Any
) -> Feedforward:
    """Return feedforward of a torque and a motor's position, in derivatives of the load's."""
    reference = _reference(axis, motor, controller)
    reference[0] = 0.0  # the command itself
    friction = axis.friction.coulomb if axis.friction else 0.0
    found = Feedforward(_terms(torque), position=_terms(reference), friction=friction)
    return found if command is None else found.within(command_order(command))


def _reference(axis: Axis, motor: FloatArray, controller: Any) -> FloatArray:
    """Return what e is taken from, so that a controller has nothing to do.

    For a PID the measured position y; for a cascade, which asks for ε = k_v·e + f_v·ṙ − v = 0,
    y + (v − f_v·ṙ)/k_v.
    """
    size = len(motor) + 1
    moved = np.pad(motor, (0, size - len(motor)))
    still = np.eye(size)[0]
    seen = moved if axis.sensor == "motor" else still
    law = None if controller is None else as_controller(controller).law
    if not isinstance(law, CascadedPI):
        return np.array(seen)
    rate = np.roll(still if axis.sensor == "load" else moved, 1)
    rate[1] -= law.velocity_feedforward
    return np.array(seen + rate / law.position_gain)


def _terms(gains: FloatArray) -> dict[int, float]:
    return {k: float(gain) for k, gain in enumerate(gains) if gain}


def _polynomials(axis: Axis) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return D, N_load and N_motor, lowest power first, the lag's factor in D."""
    from dataclasses import replace

    from .axis_transfer import transfer_polynomials

    load, whole = transfer_polynomials(replace(axis, sensor="load"))
    motor, _ = transfer_polynomials(replace(axis, sensor="motor"))
    return whole[::-1], load[::-1], motor[::-1]


def _quotient(above: FloatArray, below: FloatArray, count: int) -> FloatArray:
    """Return the first coefficients of a power series above/below, those of rounding 0."""
    series = np.zeros(count)
    for k in range(count):
        known = sum(below[j] * series[k - j] for j in range(1, min(k, len(below) - 1) + 1))
        size = abs(above[k]) if k < len(above) else 0.0
        value = (above[k] if k < len(above) else 0.0) - known
        series[k] = value / below[0] if abs(value) > _NOTHING * (size + abs(known)) else 0.0
    return series
