"""The servo loop: plant, controller and feedforward, and its exact response to a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shaping import JerkFilter, Trajectory
from ..shaping.checks import finite, positive
from ..shaping.frozen import Frozen
from ..shaping.jerk_filter import checked_filter
from ..shaping.pieces import FloatArray
from ..shaping.propagate import check_fed, product
from ..shaping.trajectory import Motion, as_trajectory
from .axis import Axis, as_axis
from .closed_systems import (
    Sensitivity,
    closed_system,
    continuous_functions,
    sampled_functions,
)
from .controller import Controller, as_controller
from .exact_response import respond_on_grid
from .feedforward import Feedforward, InertiaFeedforward, as_feedforward
from .flexible_inertia import FlexibleInertia
from .inertia import Inertia
from .linear_system import linear_system, static_gain
from .open_loop import OpenLoop, open_loop
from .pid import PID, Rate
from .sampled import loop_behind, zero_order_hold

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, eq=False)
class LoopResponse(Frozen):
    """Exact response of a servo loop on a uniform time grid; arrays (N,), time last.

    Attributes
    ----------
    time : (N,) array
    inputs : (3, N) array
        Command r, its velocity and its acceleration, as the loop receives them.
    outputs : (3, N) array, or (5, N) for a flexible plant
        Position y, error e = r − y, torque u; the load's position and the twist.
    states : (n, N) array
        States of the closed loop, plant first, in the order of `ServoLoop.system`.
    """

    time: FloatArray
    inputs: FloatArray
    outputs: FloatArray
    states: FloatArray

    @property
    def command(self) -> FloatArray:
        """Command r as the loop receives it, behind any filter."""
        return np.asarray(self.inputs[0])

    @property
    def position(self) -> FloatArray:
        """Position y."""
        return np.asarray(self.outputs[0])

    @property
    def error(self) -> FloatArray:
        """Tracking error e = r − y."""
        return np.asarray(self.outputs[1])

    @property
    def torque(self) -> FloatArray:
        """Torque u."""
        return np.asarray(self.outputs[2])

    @property
    def load(self) -> FloatArray:
        """Position of the load; of a rigid axis, y."""
        return np.asarray(self.outputs[3 if len(self.outputs) > 3 else 0])

    @property
    def twist(self) -> FloatArray:
        """Twist between motor and load, load less motor; of a rigid axis, 0."""
        return np.asarray(self.outputs[4]) if len(self.outputs) > 4 else np.zeros_like(self.time)

    def settling_time(self, target: float, tolerance: float) -> float:
        """Return the time, from the start, after which |y − target| stays within `tolerance`.

        Infinite where the response ends outside it. Between samples the crossing is taken on
        the straight line, so its error falls with dt².
        """
        excess = np.abs(self.position - finite("target", target)) - positive("tolerance", tolerance)
        outside = np.flatnonzero(excess > 0.0)
        if not outside.size:
            return 0.0
        k = int(outside[-1])
        if k + 1 == excess.size:
            return float("inf")
        fraction = excess[k] / (excess[k] - excess[k + 1])
        step = self.time[k + 1] - self.time[k]
        return float(self.time[k] - self.time[0] + fraction * step)


@dataclass(frozen=True)
class ServoLoop(Frozen):
    """A plant under feedback, with feedforward of the command's derivatives.

        y/r = g·(k + f)/(1 + g·k)

    Signals, one vocabulary throughout: r command, e = r − y error, u torque, y position;
    r_rate, e_rate, y_rate their velocities, r_acceleration the command's acceleration.

    Parameters
    ----------
    plant : Inertia, FlexibleInertia, Axis or python-control system
        A system from torque to position.
    controller : PID, CascadedPI or Controller
        A law alone is a continuous controller.
    feedforward : InertiaFeedforward or Feedforward, optional
        Default: none.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.
    """

    plant: Any
    controller: Any
    feedforward: Any = None

    def __post_init__(self) -> None:
        as_axis(self.plant)
        as_controller(self.controller)
        as_feedforward(self.feedforward)
        if self._forward.lead and not self.is_digital:
            raise ValueError(
                f"lead = {self._forward.lead!r} in a continuous loop: a lead makes up for the "
                "delay of a digital controller; leave it out"
            )

    @cached_property
    def axis(self) -> Axis:
        """The plant as an axis."""
        return as_axis(self.plant)

    @property
    def is_digital(self) -> bool:
        """Whether the controller runs once a sample."""
        return self._control.sample_time is not None

    @cached_property
    def _control(self) -> Controller:
        return as_controller(self.controller)

    @cached_property
    def _forward(self) -> Feedforward:
        return as_feedforward(self.feedforward)

    @cached_property
    def _open(self) -> OpenLoop:
        return open_loop(self.axis, self._control, self._forward)

    @property
    def _is_ideal(self) -> bool:
        """Whether it is one of the ideal loops, known by polynomials."""
        return isinstance(self.plant, Inertia | FlexibleInertia) and (
            isinstance(self.controller, PID)
            and not self.controller.derivative_filter
            and isinstance(self.feedforward, InertiaFeedforward | None)
        )

    def loop_transfer(self) -> control.TransferFunction | control.StateSpace:
        """Return L = g·k, the open loop from e to y: L(s), or L(z) of a digital controller.

        L(z) is as `sampled_loop_transfer` gives it. Friction, limits and resolution are left out.
        """
        if self.is_digital:
            return self.sampled_loop_transfer()
        if self.axis.sensor == "both":
            return self._broken_at_torque()
        plant = self.plant if self._is_ideal else self.axis
        return _named(plant.transfer() * self._control.transfer(), "e", "y", "loop")

    def _broken_at_torque(self) -> control.StateSpace:
        """Return the continuous loop from u to −u_feedback."""
        o = self._open
        n = len(o.a)
        return linear_system(
            (o.a, o.drive[:, None], -o.asked[None, :n], [[0.0]]),
            0,
            inputs=["u"],
            outputs=["u_feedback"],
            states=[f"x_{i}" for i in range(n)],
            name="loop",
        )

    def closed_loop(self) -> control.TransferFunction:
        """Return y/r = g·(k + f)/(1 + g·k) of a continuous loop, feedforward included.

        It is 1 where Ĵ = J on an `Inertia`.
        """
        import control

        if not self._is_ideal:
            return self._closed_transfer()
        g, k, f = (
            block.transfer()
            for block in (self.plant, self.controller, self.feedforward or InertiaFeedforward(0.0))
        )
        (gn,), (gd,), (kn,), (kd,) = g.num_array[0], g.den_array[0], k.num_array[0], k.den_array[0]
        forward = np.polyadd(kn, np.polymul(f.num_array[0, 0], kd))
        characteristic = np.polyadd(np.polymul(gd, kd), np.polymul(gn, kn))
        closed = control.tf(np.trim_zeros(np.polymul(gn, forward), "f"), characteristic)
        return _named(closed, "r", "y", "closed_loop")

    def _closed_transfer(self) -> control.TransferFunction:
        """Return y/r of any continuous loop: the sum over k of s^k times that from r^(k)."""
        import control

        system = self.system()
        below = np.poly(system.A)
        total = np.zeros(1)
        for k in range(system.ninputs):
            column = np.poly(system.A - np.outer(system.B[:, k], system.C[0])) - below
            total = np.polyadd(total, np.polymul(column, [1.0] + [0.0] * k))
        closed = control.tf(np.trim_zeros(total, "f"), below)
        return _named(closed, "r", "y", "closed_loop")

    def sampled_loop_transfer(
        self, dt: float | None = None, *, delay: float | None = None, rate: Rate = "measured"
    ) -> control.StateSpace:
        """Return L(z) of the loop under a digital controller: exact, broken at the torque.

        A digital `Controller` has its own sample time and delay. A bare PID is run every dt on y
        (and y_rate) as they are at the sample; its torque takes effect `delay` later and is held
        until the next one does. The closed loop's poles are the zeros of 1 + L(z).

        Parameters
        ----------
        dt : float
            Sampling time of a bare PID, positive.
        delay : float, optional
            Computing delay ≥ 0 of any length, as in `zero_order_hold`.
        rate : "measured" or "differenced", optional
            Where a bare PID's rate comes from, as in `PID.sampled`.

        Returns
        -------
        control.StateSpace
            From u to −u_feedback, discrete with this dt.

        Raises
        ------
        ValueError
            As `zero_order_hold` and `PID.sampled` do, or for a dt or delay beside those of a
            digital controller.

        Examples
        --------
        >>> loop = ServoLoop(Inertia(1.0), PID(kp=1.0, ki=0.0, kr=2.0))
        >>> sampled = loop.sampled_loop_transfer(0.5, delay=0.25)
        >>> round(float(abs(sampled.feedback().poles()).max()), 3)
        0.805
        """
        if self.is_digital:
            if dt is not None or delay is not None:
                raise ValueError(
                    f"dt = {dt!r}, delay = {delay!r}: the controller has its own, "
                    f"sample_time = {self._control.sample_time!r} and delay = "
                    f"{self._control.delay!r}; leave them out, or replace(controller, …)"
                )
            return loop_behind(self._held_plant(), self._control.sampled(), self._control.delay)
        if dt is None:
            raise ValueError("a continuous controller has no samples: give dt = …")
        if not isinstance(self.controller, PID):
            raise ValueError("a continuous controller: give Controller(…, sample_time=dt) for L(z)")
        plant = self.plant.system() if self._is_ideal else self._rates_plant()
        return loop_behind(plant, self.controller.sampled(dt, rate=rate), delay or 0.0)

    def _held_plant(self) -> control.StateSpace:
        """Return the plant from u to what position and velocity are taken from."""
        return self._plant_rows("y", "y" if self.axis.sensor != "both" else "y_motor")

    def _rates_plant(self) -> control.StateSpace:
        return self._plant_rows("y", "y_rate")

    def _plant_rows(self, *names: str) -> control.StateSpace:
        whole = self.axis.system()
        rows = [whole.output_labels.index(name) for name in names]
        return linear_system(
            (whole.A, whole.B[:, :1], whole.C[rows], whole.D[rows, :1]),
            0,
            inputs=["u"],
            outputs=[f"seen_{i}" for i in range(len(rows))],
            states=whole.state_labels,
            name="plant",
        )

    def sensitivity(self) -> Sensitivity:
        """Return S, T, PS and CS of the linear loop; of a digital one at the samples.

        There PS is the response to a torque that is held from sample to sample.
        """
        axis, controller = self.axis, self._control
        if controller.sample_time is None:
            if axis.sensor == "both":
                raise ValueError(
                    "a continuous loop with two encoders has no one g and k: give the controller a "
                    "sample time, or one encoder"
                )
            plant = self.plant if self._is_ideal else axis
            return continuous_functions(plant.transfer(), controller.transfer())
        held = zero_order_hold(self._held_plant(), controller.sample_time, delay=controller.delay)
        return sampled_functions(held, controller.sampled(), one_encoder=axis.sensor != "both")

    @cached_property
    def _interconnection(self) -> control.StateSpace:
        import control

        if not self._is_ideal:
            return closed_system(self.axis, self._open)
        plant = self.plant.system()
        outputs = ["y", "e", "u", *plant.output_labels[2:]]
        return control.interconnect(
            [
                plant,
                self.controller.system(),
                (self.feedforward or InertiaFeedforward(0.0)).system(),
                _sum([1.0, -1.0], ["r", "y"], "e"),
                _sum([1.0, -1.0], ["r_rate", "y_rate"], "e_rate"),
                _sum([1.0, 1.0], ["u_feedback", "u_feedforward"], "u"),
            ],
            inplist=["r", "r_rate", "r_acceleration"],
            outlist=outputs,
            inputs=["r", "r_rate", "r_acceleration"],
            outputs=outputs,
            name="servo_loop",
        )

    def system(self) -> control.StateSpace:
        """Return the interconnected loop (r, r_rate, r_acceleration) → (y, e, u).

        With a `FlexibleInertia` the outputs go on with y_load and twist. Of an `Axis` they are y,
        e, u, y_load, y_motor and torque, and the inputs go up to the derivative that controller
        and feedforward take: r, r_rate, r_acceleration, r_jerk, …

        The ideal PID needs the command's velocity and the feedforward its acceleration; both
        come from the shaper, so every block is proper and nothing is differentiated.
        """
        if self.is_digital:
            raise ValueError(
                "a digital controller makes no system in continuous time: use respond(), "
                "loop_transfer() or sensitivity()"
            )
        return self._interconnection

    def respond(
        self,
        trajectory: Motion,
        dt: float,
        *,
        duration: float | None = None,
        jerk_filter: JerkFilter | None = None,
    ) -> LoopResponse:
        """Return the loop's exact response to a trajectory, its acceleration fed forward.

        Parameters
        ----------
        trajectory : Trajectory
            Of order 2 or more, or of any order behind a jerk filter that is high enough. The
            loop starts at rest at the trajectory's start.
        dt : float
            Spacing of the time grid; its choice does not change the values.
        duration : float, optional
            Length of the grid, which ends at the last multiple of dt within it. Default: the
            trajectory's duration.
        jerk_filter : JerkFilter, optional
            Put between the trajectory and the loop.

        Returns
        -------
        LoopResponse

        Raises
        ------
        ValueError
            For a trajectory of order 1 (its acceleration is a train of impulses: bound the
            acceleration), or a dt or duration that is not positive.
        """
        trajectory = as_trajectory(trajectory)
        if jerk_filter is None:
            check_fed(trajectory, (0, 1, 2))
        start = float(trajectory.start_state[0])
        moved = trajectory.shift(-start)
        system, fed, initial, behind = self.system(), 3, np.zeros(self.system().nstates), None
        if jerk_filter is not None:
            behind = _filter_outputs(checked_filter(jerk_filter), moved)
            system, fed, initial = _behind_filter(system, jerk_filter, moved, behind)
        time, states, inputs, outputs = respond_on_grid(
            system, range(fed), moved, positive("dt", dt), duration, initial
        )
        if behind is not None:
            inputs = product(behind, states[: behind.shape[1]], np.empty((3, time.size)))
            states = states[behind.shape[1] :]
        for row in (outputs[0], states[0], inputs[0], *outputs[3:4]):
            row += start
        return LoopResponse(time, inputs, outputs, states)


def _sum(signs: list[float], parts: list[str], whole: str) -> control.StateSpace:
    return static_gain([signs], inputs=parts, outputs=[whole], name=f"sum_{whole}")


def _filter_outputs(jerk_filter: JerkFilter, trajectory: Trajectory) -> FloatArray:
    """Return the matrix from the lags of a filter's copies to r, r_rate, r_acceleration.

    There is a copy for each derivative of the trajectory that is free of impulses, up to the
    acceleration; what is missing is the derivative of the last copy's output.
    """
    m = jerk_filter.order
    direct = min(2, trajectory.lowest_jump())
    if m <= 2 - direct:
        raise ValueError(
            f"a jerk filter of order {m} behind a trajectory whose derivative {direct} jumps has "
            f"no finite acceleration: use order {3 - direct} or more, or bound the acceleration"
        )
    outputs = np.zeros((3, (direct + 1) * m))
    for i in range(3):
        copy = min(i, direct)
        outputs[i, copy * m : (copy + 1) * m] = jerk_filter.derivative_weights(i - copy)[1:]
    return outputs


def _behind_filter(
    loop: control.StateSpace, jerk_filter: JerkFilter, trajectory: Trajectory, outputs: FloatArray
) -> tuple[control.StateSpace, int, FloatArray]:
    """Return the loop behind the filter's copies, how many there are, and the initial state."""
    import control

    a, b = jerk_filter.state_space()
    lags, n = outputs.shape[1], loop.nstates
    copies = lags // jerk_filter.order
    full = np.zeros((lags + n, lags + n))
    full[:lags, :lags] = np.kron(np.eye(copies), a)
    full[lags:, :lags] = loop.B @ outputs
    full[lags:, lags:] = loop.A
    drive = np.vstack([np.kron(np.eye(copies), b), np.zeros((n, copies))])
    out = np.hstack([loop.D @ outputs, loop.C])
    start = [jerk_filter.steady_state(trajectory, k) for k in range(copies)]
    initial = np.concatenate([*start, np.zeros(n)])
    system = control.StateSpace(full, drive, out, 0, remove_useless_states=False)
    return system, copies, initial


def _named(
    system: control.TransferFunction, source: str, sink: str, name: str
) -> control.TransferFunction:
    import control

    return control.tf(system, inputs=[source], outputs=[sink], name=name)
