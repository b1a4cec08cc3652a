"""The servo loop: plant, controller and feedforward, and its exact response to a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..shaping import JerkFilter, Trajectory
from ..shaping.checks import finite, positive
from ..shaping.frozen import Frozen
from ..shaping.jerk_filter import checked_filter
from ..shaping.pieces import FloatArray
from ..shaping.propagate import check_fed, product
from ..shaping.real_numbers import shown
from ..shaping.trajectory import Motion, as_trajectory
from .exact_response import respond_on_grid
from .feedforward import InertiaFeedforward
from .flexible_inertia import FlexibleInertia
from .inertia import Inertia
from .linear_system import static_gain
from .pid import PID, Rate
from .sampled import loop_behind

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
    """A plant under feedback, with feedforward of the command's acceleration.

        y/r = g·(k + f)/(1 + g·k)

    Signals, one vocabulary throughout: r command, e = r − y error, u torque, y position;
    r_rate, e_rate, y_rate their velocities, r_acceleration the command's acceleration.

    Parameters
    ----------
    plant : Inertia or FlexibleInertia
    controller : PID
    feedforward : InertiaFeedforward, optional
        Default: none.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.
    """

    plant: Inertia | FlexibleInertia
    controller: PID
    feedforward: InertiaFeedforward | None = None

    def __post_init__(self) -> None:
        for name, block, kinds in (
            ("plant", self.plant, (Inertia, FlexibleInertia)),
            ("controller", self.controller, (PID,)),
            ("feedforward", self._feedforward, (InertiaFeedforward,)),
        ):
            if not isinstance(block, kinds):
                expected = " or ".join(kind.__name__ for kind in kinds)
                raise TypeError(f"{name} = {shown(block)}: expected {expected}")

    def loop_transfer(self) -> control.TransferFunction:
        """Return L(s) = g·k, the open loop from e to y."""
        loop = self.plant.transfer() * self.controller.transfer()
        return _named(loop, "e", "y", "loop")

    def closed_loop(self) -> control.TransferFunction:
        """Return y/r = g·(k + f)/(1 + g·k), feedforward included.

        It is 1 where Ĵ = J on an `Inertia`.
        """
        import control

        g, k, f = (block.transfer() for block in (self.plant, self.controller, self._feedforward))
        (gn,), (gd,), (kn,), (kd,) = g.num_array[0], g.den_array[0], k.num_array[0], k.den_array[0]
        forward = np.polyadd(kn, np.polymul(f.num_array[0, 0], kd))
        characteristic = np.polyadd(np.polymul(gd, kd), np.polymul(gn, kn))
        closed = control.tf(np.trim_zeros(np.polymul(gn, forward), "f"), characteristic)
        return _named(closed, "r", "y", "closed_loop")

    def sampled_loop_transfer(
        self, dt: float, *, delay: float = 0.0, rate: Rate = "measured"
    ) -> control.StateSpace:
        """Return L(z) of the loop under a digital PID: exact, broken at the torque.

        The PID runs every dt on y (and y_rate) as they are at the sample; its torque takes effect
        `delay` later and is held until the next one does. The closed loop's poles are the zeros
        of 1 + L(z).

        Parameters
        ----------
        dt : float
            Sampling time, positive.
        delay : float, optional
            Computing delay ≥ 0 of any length, as in `zero_order_hold`.
        rate : "measured" or "differenced", optional
            Where the controller's rate comes from, as in `PID.sampled`.

        Returns
        -------
        control.StateSpace
            From u to −u_feedback, discrete with this dt.

        Raises
        ------
        ValueError
            As `zero_order_hold` and `PID.sampled` do.

        Examples
        --------
        >>> loop = ServoLoop(Inertia(1.0), PID(kp=1.0, ki=0.0, kr=2.0))
        >>> sampled = loop.sampled_loop_transfer(0.5, delay=0.25)
        >>> round(float(abs(sampled.feedback().poles()).max()), 3)
        0.805
        """
        return loop_behind(self.plant.system(), self.controller.sampled(dt, rate=rate), delay)

    @property
    def _feedforward(self) -> InertiaFeedforward:
        return InertiaFeedforward(0.0) if self.feedforward is None else self.feedforward

    @cached_property
    def _interconnection(self) -> control.StateSpace:
        import control

        plant = self.plant.system()
        outputs = ["y", "e", "u", *plant.output_labels[2:]]
        return control.interconnect(
            [
                plant,
                self.controller.system(),
                self._feedforward.system(),
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

        With a `FlexibleInertia` the outputs go on with y_load and twist.

        The ideal PID needs the command's velocity and the feedforward its acceleration; both
        come from the shaper, so every block is proper and nothing is differentiated.
        """
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
