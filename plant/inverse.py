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
from .inverse_dynamics import InverseDynamics

_Polynomials = tuple[FloatArray, FloatArray, FloatArray]
_ROUNDING = 1e-13
_NOTHING = 1e-9  # of the largest term, in the axis's own unit of time


def inverse_feedforward(plant: Any, command: Any = None, *, controller: Any = None) -> Feedforward:
    """Return the feedforward that makes the load of an axis follow the command exactly.

    With g_load(s) = N(s)/D(s) and g_motor(s) = N_motor(s)/D(s),

        torque = D/N·r,   y_motor = N_motor/N·r.

    Without damping inside the structure N is a constant, the load's position is flat, and these are
    derivatives of the command up to twice the number of masses. Of one mode, with B and B_L the
    viscous friction of motor and load, λ the load's share, k its spring and ω its free frequency,

        y_motor = r + (B_L·ṙ + λ·J·r̈)/k,
        torque = (B + B_L)·ṙ + (J + B·B_L/k)·r̈ + ((1 − λ)·B_L + λ·B)·J/k·r⃛ + J/ω²·r⁗.

    With damping N has zeros, left of the imaginary axis, and the inverse remembers the command:
    `.dynamics` is a stable filter, exact behind a piecewise polynomial. Of one mode damped by ζ,
    N = 1 + 2ζ·s/ω, and the last term above becomes J/ω²·r⁗/(1 + 2ζ·s/ω): a bounded jerk makes a
    finite torque, but each jump Δ of the jerk a peak of J·Δ/(2ζ·ω). Bounded snap avoids them.

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
        For a zero of g_load that is not left of the imaginary axis: modes of which some are left
        out may give such, or a mode without damping that is not between motor and load.
        `low_frequency_feedforward` takes those.

    Notes
    -----
    In a continuous loop the load follows to rounding: measured 5e-15 rad of a move of 0.4 rad at 1
    and 5 % damping, 5e-13 at 0.01 %. Hold and delay of a digital controller leave
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
        return _remembering(axis, (whole, load, motor), command, controller)
    one = np.ones(1)
    return _feedforward(axis, (whole / load[0], one, motor / load[0]), command, controller)


def low_frequency_feedforward(
    plant: Any, command: Any = None, *, order: int = 4, controller: Any = None
) -> Feedforward:
    """Return the inverse's expansion about frequency 0, up to a derivative of the command.

        torque = B·ṙ + J·r̈ + … + s·r⁗,   y_motor = r + q·r̈ + …

    from the quotients of the axis's polynomials, s = −J·Σ a_i·b_i/ω_i², q = Σ (a_i² − a_i·b_i)/ω_i²
    without friction. It takes models of which higher modes are left out, and remembers nothing of
    a damped mode. The load's error is about the first derivative that is left out: of a mode damped
    by ζ and order 4 2ζ/ω³ times the fifth, without damping 1/ω⁴ times the
    sixth. Measured on a 20 Hz mode of 40 % of the inertia, 0.5 rad in 0.441 s, snap bounded, in a
    4 Hz loop, the load's peak error: 4e-16 rad undamped, 3.6e-6, 7.0e-6 and 3.1e-5 rad at 0.5, 1
    and 5 % damping, of which `inverse_feedforward` leaves nothing; 1.9e-3 rad at order 2.

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

    Returns
    -------
    Feedforward
    """
    axis, order = as_axis(plant), whole_number("order", order, 2, MAX_ORDER)
    whole, load, motor = _polynomials(axis)
    torque, ahead = _quotient(whole, load, order + 1), _quotient(motor, load, order)
    return _feedforward(axis, (torque, np.ones(1), ahead), command, controller)


def _remembering(
    axis: Axis, polynomials: _Polynomials, command: Any, controller: Any
) -> Feedforward:
    """Return the inverse where g_load(s) = N(s)/D(s) has zeros, all of them stable.

    With f poles more than zeros, D/N = Σ_{k < f} t_k·s^k + s^f·R/N, R of the degree of N; what the
    motor is ahead by likewise, its R of a lower degree.
    """
    whole, load, motor = (part / polynomials[1][0] for part in polynomials)
    zeros = np.roots(load[::-1])
    if (zeros.real > -_NOTHING * np.abs(zeros)).any():
        raise _unstable(zeros)
    more = len(whole) - len(load)
    ahead = _ahead(axis, load, motor, controller)
    torque, reference = _quotient(whole, load, more), _quotient(ahead, load, more)
    dynamics = InverseDynamics(
        more,
        tuple(load),
        tuple(_rest(whole, load, torque, len(load))),
        tuple(_rest(ahead, load, reference, len(load) - 1)),
    )
    found = Feedforward(
        _terms(torque), position=_terms(reference), friction=_dry(axis), dynamics=dynamics
    )
    return found if command is None else found.within(command_order(command))


def _unstable(zeros: Any) -> ValueError:
    """Return the error for a load whose inverse has unstable poles, or such as ring for ever."""
    worst = zeros[np.argmax(zeros.real)]
    if worst.real > _NOTHING * abs(worst):
        told = (
            f"the inverse of this axis is unstable, with a pole at {worst.real:.4g} rad/s: modes "
            "are left out of it, or load and motor move against each other"
        )
    else:
        told = (
            f"the inverse of this axis rings for ever, at {abs(worst) / (2.0 * np.pi):.4g} Hz, in "
            "a mode without damping that is not between motor and load; give it damping"
        )
    return ValueError(f"{told}; use low_frequency_feedforward(axis), exact up to snap")


def _feedforward(
    axis: Axis, polynomials: _Polynomials, command: Any, controller: Any
) -> Feedforward:
    """Return feedforward of a torque and a motor's position, in derivatives of the load's."""
    torque, one, motor = polynomials
    ahead = _terms(_ahead(axis, one, motor, controller))
    found = Feedforward(_terms(torque), position=ahead, friction=_dry(axis))
    return found if command is None else found.within(command_order(command))


def _dry(axis: Axis) -> float:
    return axis.friction.coulomb if axis.friction else 0.0


def _ahead(axis: Axis, load: FloatArray, motor: FloatArray, controller: Any) -> FloatArray:
    """Return by how much that is ahead of r which e is taken from, so that nothing is left to do.

    For a PID that is the measured position y; for a cascade, which asks for
    ε = k_v·e + f_v·ṙ − v = 0, y + (v − f_v·ṙ)/k_v. All are polynomials over that of the load.
    """
    size = max(len(load), len(motor)) + 1
    still, moved = (np.pad(part, (0, size - len(part))) for part in (load, motor))
    ahead = moved - still if axis.sensor == "motor" else 0.0 * still
    ahead[np.abs(ahead) < _ROUNDING * np.abs(still)] = 0.0
    law = None if controller is None else as_controller(controller).law
    if not isinstance(law, CascadedPI):
        return np.asarray(ahead)
    rate = (still if axis.sensor == "load" else moved) - law.velocity_feedforward * still
    return np.asarray(ahead + np.roll(rate, 1) / law.position_gain)


def _terms(gains: FloatArray) -> dict[int, float]:
    return {k: float(gain) for k, gain in enumerate(gains) if gain}


def _polynomials(axis: Axis) -> _Polynomials:
    """Return D, N_load and N_motor, lowest power first, the lag's factor in D."""
    from .axis_transfer import numerators_of

    (load, motor), whole = numerators_of(axis, ("load", "motor"))
    return whole[::-1], load[::-1], motor[::-1]


def _rest(above: FloatArray, below: FloatArray, series: FloatArray, count: int) -> FloatArray:
    """Return (above − below·series)/s^n, n the length of the series; rounding is 0."""
    n = len(series)
    rest = np.zeros(count)
    for k in range(n, n + count):
        terms = [below[j] * series[k - j] for j in range(k - n + 1, min(k, len(below) - 1) + 1)]
        value = (above[k] if k < len(above) else 0.0) - sum(terms)
        size = max(map(abs, (value, *terms)), default=0.0)
        rest[k - n] = value if abs(value) > _NOTHING * size else 0.0
    return rest


def _quotient(above: FloatArray, below: FloatArray, count: int) -> FloatArray:
    """Return the first coefficients of a power series above/below, those of rounding 0."""
    series = np.zeros(count)
    for k in range(count):
        known = sum(below[j] * series[k - j] for j in range(1, min(k, len(below) - 1) + 1))
        size = abs(above[k]) if k < len(above) else 0.0
        value = (above[k] if k < len(above) else 0.0) - known
        series[k] = value / below[0] if abs(value) > _NOTHING * (size + abs(known)) else 0.0
    return series
