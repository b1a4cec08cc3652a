"""The exact inverse of an axis: what makes its load follow a command exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..shaping.derivatives import derivative_name
from ..shaping.pieces import FloatArray
from ..shaping.trajectory import Trajectory
from .axis import Axis, as_axis
from .feedforward import Feedforward

_NOTHING = 1e-9  # of the largest term, in the axis's own unit of time


def inverse_feedforward(plant: Any, command: Trajectory | None = None) -> Feedforward:
    """Return the feedforward that makes the load of an axis follow the command exactly.

    With the load's position flat, g_load(s) = N_0/D(s), N_0 constant,

        torque = D(d/dt)·r/N_0,   y_motor = N_motor(d/dt)·r/N_0,

    which has derivatives up to twice the number of masses. Viscous friction and springs are in
    it; Coulomb friction is fed forward by its sign. A current loop's lag adds a derivative.

    Parameters
    ----------
    plant : Inertia, FlexibleInertia or Axis
    command : Trajectory, optional
        To be checked: it must be of the feedforward's order at least.

    Returns
    -------
    Feedforward
        Its `order` is that which the command needs: with order n of the trajectory equal to it
        the torque is bounded, with one more it is continuous.

    Raises
    ------
    ValueError
        For an axis whose load is not flat (damping inside the structure, or modes that are no
        chain: the inverse has poles then, and modes of which some are left out give zeros in the
        right half-plane), or a command of too low an order.

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
        raise ValueError(
            "the load is not flat, its inverse has poles: damping between the masses, or modes "
            "that are no chain of masses. Use the model without structural damping, or "
            "low_frequency_feedforward(axis), exact to the fourth derivative"
        )
    torque = {k: float(c) for k, c in enumerate(whole / load[0]) if c}
    ahead = {k: float(c) for k, c in enumerate(motor / load[0]) if c and k}
    if axis.sensor == "load":
        ahead = {}
    friction = axis.friction.coulomb if axis.friction else 0.0
    return _checked(Feedforward(torque, position=ahead, friction=friction), command)


def low_frequency_feedforward(plant: Any, command: Trajectory | None = None) -> Feedforward:
    """Return the inverse's expansion about frequency 0, up to the command's fourth derivative.

        torque = B·ṙ + J·r̈ + … + s·r⁗,   y_motor = r + q·r̈

    from the quotients of the axis's polynomials; what is left of the load's error is of the order
    of r^(6)/ω⁴. It is right for damped modes, and for models of which higher modes are left out.

    Parameters
    ----------
    plant : Inertia, FlexibleInertia or Axis
    command : Trajectory, optional
        To be checked: it must be of the feedforward's order at least.
    """
    axis = as_axis(plant)
    whole, load, motor = _polynomials(axis)
    torque = {k: float(c) for k, c in enumerate(_quotient(whole, load, 5)) if c}
    ahead = {k: float(c) for k, c in enumerate(_quotient(motor, load, 4)) if c and k}
    if axis.sensor == "load":
        ahead = {}
    friction = axis.friction.coulomb if axis.friction else 0.0
    return _checked(Feedforward(torque, position=ahead, friction=friction), command)


def _checked(feedforward: Feedforward, command: Trajectory | None) -> Feedforward:
    if command is not None and command.order < feedforward.order:
        raise ValueError(
            f"the inverse of this axis needs {derivative_name(feedforward.order)} of the command: "
            f"bound it, in a trajectory of order {feedforward.order} instead of {command.order}"
        )
    return feedforward


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
