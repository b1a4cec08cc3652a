"""Axis and continuous controller in one state space, the torque command not yet connected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..shaping.pieces import FloatArray
from .axis import Axis
from .controller import Controller
from .discretise import filter_system_of
from .feedforward import Feedforward
from .inverse_dynamics import InverseDynamics
from .pid import PID


@dataclass(frozen=True, eq=False)
class OpenLoop:
    """ẋ = A·x + b·u + P·p + D·d with p the command's derivatives, d = (d_motor, d_load).

    Rows over (x, p) tell what the controller sees and asks for.

    Attributes
    ----------
    a : (n, n) array
    drive : (n,) array
        b.
    fed : (n, K + 1) array
        P.
    disturbed : (n, 2) array
        D.
    error, asked, integrated : (n + K + 1,) arrays
        The error e, the torque asked for w, and what the integral integrates.
    integral : int
        Place of the integral in x.
    """

    a: FloatArray
    drive: FloatArray
    fed: FloatArray
    disturbed: FloatArray
    error: FloatArray
    asked: FloatArray
    integrated: FloatArray
    integral: int

    def without_idle_integral(self) -> OpenLoop:
        """Return it without an integral that nothing takes, which would count as unstable."""
        n, place = len(self.a), self.integral
        if self.asked[place] or self.a[np.arange(n) != place, place].any():
            return self
        a, fed = np.delete(np.delete(self.a, place, 0), place, 1), np.delete(self.fed, place, 0)
        drive, disturbed = np.delete(self.drive, place), np.delete(self.disturbed, place, 0)
        error, asked = np.delete(self.error, place), np.delete(self.asked, place)
        integrated = np.delete(self.integrated, place)
        return OpenLoop(a, drive, fed, disturbed, error, asked, integrated, -1)

    def closed(self) -> tuple[FloatArray, FloatArray]:
        """Return A and P of the loop with u = w."""
        n = len(self.a)
        return (
            self.a + np.outer(self.drive, self.asked[:n]),
            self.fed + np.outer(self.drive, self.asked[n:]),
        )


def needed_order(controller: Controller, feedforward: Feedforward) -> int:
    """Return the highest derivative of the command that a continuous loop takes."""
    ahead = isinstance(controller.law, PID)  # it takes the rate of the reference
    remembered = 0 if feedforward.dynamics is None else feedforward.dynamics.derivative
    return max([1, remembered, *feedforward.torque, *(k + ahead for k in feedforward.position)])


def open_loop(axis: Axis, controller: Controller, feedforward: Feedforward) -> OpenLoop:
    """Return a continuous loop, states plant, integral, filtered rate, filters, the inverse's."""
    highest, dynamics = needed_order(controller, feedforward), feedforward.dynamics
    builder = _Builder(axis, controller, highest, 0 if dynamics is None else dynamics.size)
    position = feedforward.position_gains(highest)
    error = builder.row(-builder.position, position)
    rate = builder.row(-builder.rate, np.append(0.0, position[:-1]))
    torque = builder.row(0.0 * builder.position, feedforward.torque_gains(highest))
    if dynamics is not None:
        more, ahead, ahead_rate = builder.remembered(dynamics)
        torque, error, rate = torque + more, error + ahead, rate + ahead_rate
    if isinstance(controller.law, PID):
        asked, integrated = builder.pid(controller.law, error, rate)
    else:
        asked, integrated = builder.cascade(controller, error)
    for element in controller.filters:
        asked = builder.filtered(filter_system_of(element), asked)
    return builder.finish(error, asked + torque, integrated)


class _Builder:
    """Collects states behind those of the plant; rows run over (plant, controller, p)."""

    def __init__(self, axis: Axis, controller: Controller, highest: int, memory: int) -> None:
        d = axis.dynamics
        rates = int(controller.rate_filter > 0.0)
        filters = sum(filter_system_of(f).nstates for f in controller.filters)
        self.plant, self.inputs = d.size, highest + 1
        self.states = d.size + 1 + rates + filters + memory
        self.next = d.size
        self.rows = np.zeros((self.states, self.states + self.inputs))
        self.rows[: d.size, : d.size] = d.a
        self.b = d.b
        self.position = d.motor if axis.sensor == "motor" else d.load
        self.rate = d.load_rate if axis.sensor == "load" else d.motor_rate

    def row(self, plant: FloatArray, command: FloatArray) -> FloatArray:
        """Return a row of the plant's states and the command's derivatives."""
        row = np.zeros(self.states + self.inputs)
        row[: self.plant], row[self.states :] = plant, command
        return row

    def state(self, rate: FloatArray) -> FloatArray:
        """Add a state with this rate; return its row."""
        self.rows[self.next] = rate
        row = np.zeros(self.states + self.inputs)
        row[self.next] = 1.0
        self.next += 1
        return row

    def lagged(self, signal: FloatArray, lag: float) -> FloatArray:
        """Return a signal behind a first-order lag, or itself."""
        if not lag:
            return signal
        row = np.zeros_like(signal)
        row[self.next] = -1.0
        return self.state((signal + row) / lag)

    def pid(self, law: PID, error: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray]:
        integral = self.state(error)
        rate = self.lagged(rate, law.derivative_filter)
        return law.kp * error + law.ki * integral + law.kr * rate, error

    def cascade(self, controller: Controller, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        law = controller.law
        assert not isinstance(law, PID)
        integral_place = self.next
        self.next += 1
        command_rate = np.append(np.zeros(self.states), np.eye(self.inputs)[1])
        measured = self.lagged(self.row(self.rate, np.zeros(self.inputs)), law.velocity_filter)
        within = law.position_gain * error + law.velocity_feedforward * command_rate - measured
        self.rows[integral_place] = within
        integral = np.eye(len(within))[integral_place]
        return law.velocity_gain * within + law.integral_gain * integral, within

    def filtered(self, system: object, signal: FloatArray) -> FloatArray:
        a, b, c, d = (np.asarray(getattr(system, name)) for name in "ABCD")
        places = slice(self.next, self.next + len(a))
        self.rows[places] = b @ signal[None]
        self.rows[places, places] += a
        out = d[0, 0] * signal
        out[places] += c[0]
        self.next += len(a)
        return np.asarray(out)

    def remembered(self, dynamics: InverseDynamics) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Put the inverse's dynamics into the last states.

        Return the rows of what they add to torque and reference, and of the latter's rate.
        """
        a, b, c, d = dynamics.matrices()
        last = slice(self.states - dynamics.size, self.states)
        fed = self.states + dynamics.derivative
        self.rows[last, last], self.rows[last, fed] = a, b
        torque, ahead, ahead_rate = np.zeros((3, self.rows.shape[1]))
        torque[last], ahead[last], ahead_rate[last] = c[0], c[1], c[1] @ a
        torque[fed], ahead_rate[fed] = d[0], c[1] @ b
        return torque, ahead, ahead_rate

    def finish(self, error: FloatArray, asked: FloatArray, integrated: FloatArray) -> OpenLoop:
        n = self.states
        drive, disturbed = np.zeros(n), np.zeros((n, 2))
        drive[: self.plant], disturbed[: self.plant] = self.b[:, 0], self.b[:, 1:]
        a, fed = self.rows[:, :n], self.rows[:, n:]
        return OpenLoop(a, drive, fed, disturbed, error, asked, integrated, self.plant)
