"""Closed loops as python-control systems: the whole loop, and S, T, PS and CS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..shaping.derivatives import DERIVATIVE_NAMES
from ..shaping.pieces import FloatArray
from .axis import Axis
from .linear_system import linear_system
from .models import Rational, StateModel
from .open_loop import OpenLoop

if TYPE_CHECKING:
    import control


class Sensitivity(NamedTuple):
    """The four transfer functions of a closed `ServoLoop`, as python-control systems.

    Attributes
    ----------
    S, T : python-control systems
        1/(1 + L) and L/(1 + L), broken at the torque.
    PS : python-control system
        From a disturbing torque on the motor to the measured position.
    CS : python-control system
        From an error of the measured position to the torque, with the sign turned.
    """

    S: Any
    T: Any
    PS: Any
    CS: Any


def closed_system(axis: Axis, loop: OpenLoop) -> control.StateSpace:
    """Return the continuous loop from the command's derivatives to what it shows."""
    model = closed_model(axis, loop)
    return linear_system(
        (model.A, model.B, model.C, model.D),
        0,
        inputs=[_signal(k) for k in range(model.ninputs)],
        outputs=["y", "e", "u", "y_load", "twist", "torque"],
        states=[
            *axis.dynamics.names,
            *(f"controller_{i}" for i in range(model.nstates - axis.dynamics.size)),
        ],
        name="servo_loop",
    )


def closed_model(axis: Axis, loop: OpenLoop) -> StateModel:
    """Return the numbers of `closed_system`."""
    a, fed = loop.closed()
    n, inputs = len(a), fed.shape[1]
    d = axis.dynamics
    position = d.motor if axis.sensor == "motor" else d.load
    shown = [_wide(position, n), loop.error[:n], loop.asked[:n]]
    shown += [_wide(row, n) for row in (d.load, d.load - d.motor, d.torque[:-1])]
    direct = np.zeros((6, inputs))
    direct[1], direct[2] = loop.error[n:], loop.asked[n:]
    if d.torque[-1]:
        shown[5], direct[5] = loop.asked[:n], loop.asked[n:]
    return StateModel(a, fed, np.array(shown), direct)


def _signal(k: int) -> str:
    if k < 2:
        return ("r", "r_rate")[k]
    return f"r_{DERIVATIVE_NAMES[k] if k < len(DERIVATIVE_NAMES) else k}"


def _wide(row: FloatArray, n: int) -> FloatArray:
    return np.pad(row, (0, n - len(row)))


def continuous_functions(g: Any, k: Any) -> Sensitivity:
    """Return the four of g(s) and k(s), improper ones as they are, as models."""
    (gn,), (gd,), (kn,), (kd,) = g.num_array[0], g.den_array[0], k.num_array[0], k.den_array[0]
    around, straight = np.polymul(gd, kd), np.polymul(gn, kn)
    whole = np.polyadd(around, straight)
    above = around, straight, np.polymul(gn, kd), np.polymul(gd, kn)
    return Sensitivity(*(Rational(numerator, whole) for numerator in above))


def named(functions: Sensitivity) -> Sensitivity:
    """Return the four as python-control systems with their names, models or not."""
    return Sensitivity(*map(_named, Sensitivity._fields, functions))


def _named(name: str, function: Any) -> Any:
    import control

    if isinstance(function, Rational):
        return control.tf(function.numerator, function.denominator, name=name)
    return linear_system(
        (function.A, function.B, function.C, function.D),
        function.dt,
        inputs=[f"into_{name}"],
        outputs=[name],
        states=[f"x_{i}" for i in range(function.nstates)],
        name=name,
    )


def two_encoder_functions(loop: OpenLoop, position: FloatArray) -> Sensitivity:
    """Return the four of a continuous loop whose position and velocity have encoders of their own.

    The loop is one without feedforward; `position` is the row of the measured position. An error
    of the measured position alone enters as the command does, its sign turned.
    """
    loop = loop.without_idle_integral()
    n = len(loop.a)
    a, fed = loop.closed()
    asked, direct = loop.asked[None, :n], loop.asked[n : n + 1]
    drive, seen = loop.drive[:, None], _wide(position, n)[None]

    one, none = np.ones((1, 1)), np.zeros((1, 1))
    return Sensitivity(
        StateModel(a, drive, asked, one),
        StateModel(a, drive, -asked, none),
        StateModel(a, drive, seen, none),
        StateModel(a, fed[:, :1], asked, direct[None]),
    )


def sampled_functions(
    held: StateModel, controller: StateModel, *, one_encoder: bool
) -> Sensitivity:
    """Return the four of a held plant u → (y, y_motor) and what a controller does in a sample."""
    a, b, c = held.A, held.B, held.C
    ac, bc, cc, dc = controller.A, controller.B, controller.C, controller.D
    noisy = np.array([[1.0], [1.0 if one_encoder else 0.0]])
    asked = np.hstack([-dc @ c, cc])  # u_feedback over the states
    whole = np.block([[a, np.zeros((len(a), len(ac)))], [-bc @ c, ac]])
    drive = np.vstack([b, np.zeros((len(ac), 1))])
    closed = whole + drive @ asked
    noise = np.vstack([-b @ dc @ noisy, -bc @ noisy])
    seen = np.hstack([c[:1], np.zeros((1, len(ac)))])
    one, none = np.ones((1, 1)), np.zeros((1, 1))
    return Sensitivity(
        StateModel(closed, drive, asked, one, held.dt),
        StateModel(closed, drive, -asked, none, held.dt),
        StateModel(closed, drive, seen, none, held.dt),
        StateModel(closed, noise, -asked, dc @ noisy, held.dt),
    )
