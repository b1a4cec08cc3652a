"""The exact response of a servo loop, and what is read from it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..shaping.checks import finite, one_of, positive
from ..shaping.drawing import draw
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.told import Told
from .anti_windup import Clamp
from .knife_edges import knife_edges
from .simulate import simulate

if TYPE_CHECKING:
    from .run import Run, Scene
    from .signal_pieces import Pieces

Of = Literal["position", "load"]


@dataclass(frozen=True, eq=False, repr=False)
class LoopResponse(Told, Frozen):
    """Exact response of a servo loop on a time grid; arrays (N,), time last.

    Attributes
    ----------
    time : (N,) array
    inputs : (3, N) array
        Command r, its velocity and its acceleration, as the loop receives them.
    outputs : (3, N) array, or (5, N) for a flexible plant, (6, N) for an axis
        Position y as it is measured, error e = r − y, torque u; the load's position and the twist;
        the motor's torque behind the current loop.
    states : (n, N) array
        States of the closed loop, plant first, in the order of `ServoLoop.system`; of a digital
        or nonlinear loop those of its axis first.
    scene : Scene, optional
        What was simulated, from which everything between the times of the grid is known, too.
    """

    time: FloatArray
    inputs: FloatArray
    outputs: FloatArray
    states: FloatArray
    scene: Scene | None = field(default=None, repr=False, kw_only=True)

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
        """Torque u: what the drive is commanded, within its limit."""
        return np.asarray(self.outputs[2])

    @property
    def load(self) -> FloatArray:
        """Position of the load; of a rigid axis, y."""
        return np.asarray(self.outputs[3 if len(self.outputs) > 3 else 0])

    @property
    def load_error(self) -> FloatArray:
        """Error of the load, r less its position."""
        return self.command - self.load

    @property
    def twist(self) -> FloatArray:
        """Twist between motor and load, load less motor; of a rigid axis, 0."""
        return np.asarray(self.outputs[4]) if len(self.outputs) > 4 else np.zeros_like(self.time)

    @property
    def motor(self) -> FloatArray:
        """Position of the motor."""
        return self.load - self.twist

    @property
    def motor_torque(self) -> FloatArray:
        """Torque of the motor behind the current loop, seen at the axis."""
        return np.asarray(self.outputs[5 if len(self.outputs) > 5 else 2])

    @property
    def current(self) -> FloatArray:
        """Motor current, motor_torque/(gear_ratio·torque_constant).

        Raises
        ------
        ValueError
            For an axis without torque constant.
        """
        axis = self._scene.axis
        if axis.torque_constant is None:
            raise ValueError("an axis without torque_constant tells no current: give it one")
        return self.motor_torque / (axis.gear_ratio * axis.torque_constant)

    def plot(
        self,
        *,
        unit: str = "",
        torque_unit: str = "",
        scale: float = 1.0,
        tolerance: float | None = None,
    ) -> Any:
        """Draw a picture: positions, errors, and torque beside its limit.

        Parameters
        ----------
        unit, torque_unit : str, optional
            For the labels.
        scale : float, optional
            The response's units of position per `unit`, positive.
        tolerance : float, optional
            Of the error, drawn about 0.

        Returns
        -------
        Figure
            As `jounce.plots.plot_loop_response` draws it.
        """
        return draw(self, unit=unit, torque_unit=torque_unit, scale=scale, tolerance=tolerance)

    @cached_property
    def run(self) -> Run:
        """The exact motion between the times of the grid."""
        return simulate(self._scene)

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on what of this response hangs on the last digits: knife edges it has met."""
        return () if self.scene is None else tuple(knife_edges(self.run))

    @property
    def _scene(self) -> Scene:
        if self.scene is None:
            raise ValueError(
                "a response behind a jerk filter, or made from arrays, is known on its grid alone: "
                "respond to a trajectory without filter"
            )
        return self.scene

    def settling_time(
        self, target: float | None, tolerance: float, *, of: Of | None = None
    ) -> float:
        """Return the time, from the start, after which |position − target| is within `tolerance`.

        Infinite where the response ends outside it. Without `of` it is the measured position; the
        load of a flexible axis may settle much later, and is what `of="load"` is for.

        Parameters
        ----------
        target : float or None
            None for the command itself, wherever it moves.
        tolerance : float
            Positive.
        of : "position" or "load", optional
            Whose position: the measured one, or the load's, in exact continuous time. Default:
            the measured one, from the samples of the grid: between them the crossing is taken on
            the straight line, so its error falls with dt². So is either of a response that is
            known on its grid alone.
        """
        tolerance = positive("tolerance", tolerance)
        goal = None if target is None else finite("target", target)
        if of is not None:
            one_of("of", of, ("position", "load"))
            if self.scene is not None:
                return self.run.last_outside(*self._signal(of, goal), tolerance)
        position = self.load if of == "load" else self.position
        excess = np.abs(position - (self.command if goal is None else goal)) - tolerance
        outside = np.flatnonzero(excess > 0.0)
        if not outside.size:
            return 0.0
        k = int(outside[-1])
        if k + 1 == excess.size:
            return float("inf")
        fraction = excess[k] / (excess[k] - excess[k + 1])
        step = self.time[k + 1] - self.time[k]
        return float(self.time[k] - self.time[0] + fraction * step)

    def _signal(self, of: Of, target: float | None) -> tuple[FloatArray, float, float]:
        """Return what makes position less target, or less the command, as `Run.pieces` takes it."""
        row = self.run.load_row if of == "load" else self.run.seen_row
        return row, -1.0 if target is None else 0.0, target or 0.0

    def _pieces(self, of: Of, target: float | None) -> Pieces:
        """Return position less target, or less the command, between all times of the run."""
        return self.run.pieces(*self._signal(of, target))

    @cached_property
    def peak_load_error(self) -> float:
        """Largest |r − load| over continuous time."""
        return self._pieces("load", None).peak()

    @cached_property
    def peak_error(self) -> float:
        """Largest |r − y| over continuous time."""
        return self._pieces("position", None).peak()

    @property
    def sample_times(self) -> FloatArray:
        """Times at which a digital controller samples."""
        dt = self._scene.controller.sample_time or 0.0
        return np.asarray(self._scene.begin + dt * np.arange(len(self.run.samples)))

    @property
    def controller_error(self) -> FloatArray:
        """Error as a digital controller computes it, at its samples: quantised, and ahead."""
        return self.run.samples[:, 0]

    @property
    def asked_torque(self) -> FloatArray:
        """Torque that a digital controller asks for at its samples, before the limit."""
        return self.run.samples[:, 1]

    @property
    def saturated_samples(self) -> int:
        """Number of samples at which the torque is at its limit."""
        return int(np.count_nonzero(self.run.samples[:, 1] != self.run.samples[:, 2]))

    @property
    def saturated_time(self) -> float:
        """Time for which the torque is at its limit."""
        if self._scene.is_digital:
            return self.saturated_samples * float(self._scene.controller.sample_time or 0.0)
        limited = np.array([mode.limit != 0 for mode in self.run.hybrid.modes])
        return float(np.diff(self.run.times)[limited[self.run.modes[:-1]]].sum())

    @cached_property
    def friction_events(self) -> tuple[tuple[float, int, int], ...]:
        """Changes of friction (time, from, to): 0 sticks, 1 and −1 slip forwards, backwards."""
        if self._scene.axis.friction is None:
            return ()
        kinds = np.array([mode.friction for mode in self.run.hybrid.modes])
        states = np.append(0, kinds[self.run.modes[:-1]])
        changes = np.flatnonzero(np.diff(states))
        return tuple(
            (self._scene.begin + float(self.run.times[i]), int(states[i]), int(states[i + 1]))
            for i in changes
        )

    @cached_property
    def stick_intervals(self) -> tuple[tuple[float, float], ...]:
        """Intervals of time for which the motor sticks."""
        if self._scene.axis.friction is None:
            return ()
        begin, end = self._scene.begin, self._scene.begin + float(self.run.times[-1])
        events = [(begin, 1, 0), *self.friction_events, (end, 0, 1)]
        starts = [time for time, _, to in events if to == 0]
        ends = [time for time, before, _ in events if before == 0]
        found = zip(starts, ends, strict=False)
        return tuple((start, stop) for start, stop in found if stop > start)

    @property
    def time_in_stick(self) -> float:
        """Time for which the motor sticks."""
        return float(sum(end - start for start, end in self.stick_intervals))

    @cached_property
    def next_breakaway(self) -> float:
        """Time at which a motor that sticks at the end breaks away, if the command stands still.

        Being stuck is not rest: the integral goes on. Infinite where it does not, or where the
        torque limit, or the clamp of the integral, is reached before the stiction; now for a motor
        that slips.
        """
        friction, run = self._scene.axis.friction, self.run
        mode = run.hybrid.modes[run.modes[-1]]
        end = self._scene.begin + float(run.times[-1])
        if friction is None or mode.friction:
            return end
        push = float(run.hybrid.pushing[run.modes[-1]] @ run.states[-1])
        error = float(run.samples[-1, 0]) if len(run.samples) else float(self.error[-1])
        ramp = self._scene.controller.standing_gain * error
        if ramp == 0.0:
            return inf
        missing = friction.holds - push * np.sign(ramp)
        left = self._scene.axis.torque_limit - float(self.motor_torque[-1]) * np.sign(ramp)
        if missing >= min(left, self._left_to_integrate(ramp)):
            return inf
        return float(end + missing / abs(ramp))

    def _left_to_integrate(self, ramp: float) -> float:
        """Return by how much the integral's torque, behind the filters, can grow at the end."""
        controller, held = self._scene.controller, self.run.held
        if not isinstance(controller.anti_windup, Clamp):
            return inf
        behind = controller.filter_gain
        way = np.sign(ramp * behind)
        return float(abs(behind) * (controller.anti_windup.integral_limit - way * held))
