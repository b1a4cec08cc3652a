"""Transfer functions of a servo loop: open, closed, sampled, and S, T, PS and CS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..shaping.checks import finite
from ..shaping.real_numbers import shown
from .axis import Axis
from .axis_transfer import transfer_polynomials
from .closed_systems import (
    Sensitivity,
    continuous_functions,
    sampled_functions,
    two_encoder_functions,
)
from .controller import Controller
from .feedforward import Feedforward, InertiaFeedforward
from .flexible_inertia import FlexibleInertia
from .inertia import Inertia
from .linear_system import linear_system
from .models import Rational
from .open_loop import OpenLoop, open_loop
from .pid import PID, Rate
from .sampled import held_model, loop_behind

if TYPE_CHECKING:
    import control


class Loop(Protocol):
    """A servo loop, as far as its transfer functions ask."""

    @property
    def plant(self) -> Any:
        """The plant as it was given."""

    @property
    def controller(self) -> Any:
        """The controller as it was given."""

    @property
    def feedforward(self) -> Any:
        """The feedforward as it was given."""

    @property
    def axis(self) -> Axis:
        """The plant as an axis."""

    @property
    def controller_noun(self) -> Controller:
        """The controller as a noun."""

    @property
    def is_digital(self) -> bool:
        """Whether the controller is sampled."""

    @property
    def open_loop(self) -> OpenLoop:
        """Axis and continuous controller, the torque not yet connected."""

    def system(self) -> control.StateSpace:
        """Return the loop whole."""

    def sampled_loop_transfer(self) -> control.StateSpace:
        """Return L(z)."""


def known_by_polynomials(loop: Loop) -> bool:
    """Return whether it is one of the ideal loops."""
    return isinstance(loop.plant, Inertia | FlexibleInertia) and (
        isinstance(loop.controller, PID)
        and not loop.controller.derivative_filter
        and isinstance(loop.feedforward, InertiaFeedforward | None)
    )


def open_transfer(loop: Loop) -> control.TransferFunction | control.StateSpace:
    """Return L, as `ServoLoop.loop_transfer` says."""
    if loop.is_digital:
        return loop.sampled_loop_transfer()
    if loop.axis.sensor == "both":
        return _broken_at_torque(loop)
    plant = loop.plant if known_by_polynomials(loop) else loop.axis
    return _named(plant.transfer() * loop.controller_noun.transfer(), "e", "y", "loop")


def open_model(loop: Loop) -> Any:
    """Return the numbers of L, or python-control's system where those take it."""
    controller = loop.controller_noun
    if controller.sample_time is not None:
        held = held_model(loop.axis.measured_model(), controller.sample_time, controller.delay)
        return controller.sampled_model().behind(held)
    parts = _models(loop)
    if parts is None:
        return open_transfer(loop)
    g, k = parts
    above, below = np.polymul(g.numerator, k.numerator), np.polymul(g.denominator, k.denominator)
    return Rational(np.asarray(above, dtype=float), np.asarray(below, dtype=float))


def _models(loop: Loop) -> tuple[Rational, Rational] | None:
    """Return plant and controller of a continuous PID without further filters, None of others."""
    controller = loop.controller_noun
    law, axis = controller.law, loop.axis
    if not isinstance(law, PID) or controller.filters or axis.sensor == "both" or axis.is_system:
        return None
    if isinstance(loop.plant, FlexibleInertia):
        return None
    return Rational(*transfer_polynomials(loop.axis)), law.model()


def _broken_at_torque(loop: Loop) -> control.StateSpace:
    """Return the continuous loop from u to −u_feedback."""
    o = open_loop(loop.axis, loop.controller_noun, Feedforward()).without_idle_integral()
    n = len(o.a)
    return linear_system(
        (o.a, o.drive[:, None], -o.asked[None, :n], [[0.0]]),
        0,
        inputs=["u"],
        outputs=["u_feedback"],
        states=[f"x_{i}" for i in range(n)],
        name="loop",
    )


def closed_transfer(loop: Loop) -> control.TransferFunction:
    """Return y/r, as `ServoLoop.closed_loop` says."""
    import control

    if not known_by_polynomials(loop):
        return _from_all_derivatives(loop)
    g, k, f = (
        block.transfer()
        for block in (loop.plant, loop.controller, loop.feedforward or InertiaFeedforward(0.0))
    )
    (gn,), (gd,), (kn,), (kd,) = g.num_array[0], g.den_array[0], k.num_array[0], k.den_array[0]
    forward = np.polyadd(kn, np.polymul(f.num_array[0, 0], kd))
    characteristic = np.polyadd(np.polymul(gd, kd), np.polymul(gn, kn))
    closed = control.tf(np.trim_zeros(np.polymul(gn, forward), "f"), characteristic)
    return _named(closed, "r", "y", "closed_loop")


def _from_all_derivatives(loop: Loop) -> control.TransferFunction:
    """Return y/r of any continuous loop: the sum over k of s^k times that from r^(k)."""
    import control

    system = loop.system()
    below = np.poly(system.A)
    total = np.zeros(1)
    for k in range(system.ninputs):
        column = np.poly(system.A - np.outer(system.B[:, k], system.C[0])) - below
        total = np.polyadd(total, np.polymul(column, [1.0] + [0.0] * k))
    closed = control.tf(np.trim_zeros(total, "f"), below)
    return _named(closed, "r", "y", "closed_loop")


def sampled_transfer(
    loop: Loop, dt: float | None, delay: float | None, rate: Rate
) -> control.StateSpace:
    """Return L(z), as `ServoLoop.sampled_loop_transfer` says."""
    controller = loop.controller_noun
    if loop.is_digital:
        if dt is not None or delay is not None:
            raise ValueError(
                f"dt = {shown(dt)}, delay = {shown(delay)}: the controller has its own, "
                f"sample_time = {shown(controller.sample_time)} and delay = "
                f"{shown(controller.delay)}; leave them out, or replace(controller, …)"
            )
        return loop_behind(_held_plant(loop), controller.sampled(), controller.delay)
    if dt is None:
        raise ValueError("a continuous controller has no samples: give dt = …")
    if not isinstance(loop.controller, PID):
        raise ValueError("a continuous controller: give Controller(…, sample_time=dt) for L(z)")
    ideal = known_by_polynomials(loop)
    plant = loop.plant.system() if ideal else _plant_rows(loop, "y", "y_rate")
    delay = 0.0 if delay is None else finite("delay", delay)
    return loop_behind(plant, loop.controller.sampled(dt, rate=rate), delay)


def _held_plant(loop: Loop) -> control.StateSpace:
    """Return the plant from u to what position and velocity are taken from."""
    return _plant_rows(loop, "y", "y" if loop.axis.sensor != "both" else "y_motor")


def _plant_rows(loop: Loop, *names: str) -> control.StateSpace:
    whole = loop.axis.system()
    rows = [whole.output_labels.index(name) for name in names]
    return linear_system(
        (whole.A, whole.B[:, :1], whole.C[rows], whole.D[rows, :1]),
        0,
        inputs=["u"],
        outputs=[f"seen_{i}" for i in range(len(rows))],
        states=whole.state_labels,
        name="plant",
    )


def sensitivity_of(loop: Loop) -> Sensitivity:
    """Return the numbers of S, T, PS and CS."""
    axis, controller = loop.axis, loop.controller_noun
    if controller.sample_time is None:
        if axis.sensor == "both":
            bare = open_loop(axis, controller, Feedforward())
            return two_encoder_functions(bare, axis.dynamics.load)
        plant = loop.plant if known_by_polynomials(loop) else axis
        parts = _models(loop) or (plant.transfer(), controller.transfer())
        return continuous_functions(*parts)
    held = held_model(axis.measured_model(), controller.sample_time, controller.delay)
    return sampled_functions(held, controller.sampled_model(), one_encoder=axis.sensor != "both")


def _named(
    system: control.TransferFunction, source: str, sink: str, name: str
) -> control.TransferFunction:
    import control

    return control.tf(system, inputs=[source], outputs=[sink], name=name)
