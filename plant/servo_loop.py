"""The servo loop: plant, controller and feedforward, and its exact response to a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..shaping import JerkFilter, Trajectory
from ..shaping.checks import finite, positive
from ..shaping.frozen import Frozen
from ..shaping.jerk_filter import checked_filter
from ..shaping.propagate import check_fed, product
from ..shaping.real_numbers import real_array, shown
from ..shaping.trajectory import as_trajectory
from .axis import Axis, as_axis
from .closed_systems import (
    Sensitivity,
    closed_model,
    closed_system,
    named,
)
from .commands import Sum, as_command
from .controller import Controller, as_controller
from .deviations import LoopDeviations, continuous_deviations, digital_deviations
from .disturbances import Wind, checked_disturbances
from .exact_response import respond_on_grid
from .feedforward import Feedforward, InertiaFeedforward, as_feedforward
from .filtered_loop import behind_filter, filter_outputs
from .flexible_inertia import FlexibleInertia
from .layout import start_of
from .linear_system import static_gain
from .loop_grid import response_of
from .loop_response import LoopResponse
from .loop_transfers import (
    closed_transfer,
    known_by_polynomials,
    open_model,
    open_transfer,
    sampled_transfer,
    sensitivity_of,
)
from .models import StateModel
from .open_loop import OpenLoop, open_loop
from .pid import Rate
from .run import Scene
from .spectrum import Spectrum

if TYPE_CHECKING:
    import control


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
        if self.feedforward_noun.lead and not self.is_digital:
            raise ValueError(
                f"lead = {shown(self.feedforward_noun.lead)} in a continuous loop: a lead "
                "makes up for "
                "the delay of a digital controller; leave it out"
            )

    @cached_property
    def axis(self) -> Axis:
        """The plant as an axis."""
        return as_axis(self.plant)

    @property
    def is_digital(self) -> bool:
        """Whether the controller runs once a sample."""
        return self.controller_noun.sample_time is not None

    @cached_property
    def controller_noun(self) -> Controller:
        """The controller, a law alone made one."""
        return as_controller(self.controller)

    @cached_property
    def feedforward_noun(self) -> Feedforward:
        """The feedforward, none or an inertia's made one."""
        return as_feedforward(self.feedforward)

    @cached_property
    def open_loop(self) -> OpenLoop:
        """Axis and continuous controller, the torque not yet connected."""
        return open_loop(self.axis, self.controller_noun, self.feedforward_noun)

    def loop_transfer(self) -> control.TransferFunction | control.StateSpace:
        """Return L = g·k, the open loop from e to y: L(s), or L(z) of a digital controller.

        L(z) is as `sampled_loop_transfer` gives it. Friction, limits and resolution are left out.
        """
        return open_transfer(self)

    def closed_loop(self) -> control.TransferFunction:
        """Return y/r = g·(k + f)/(1 + g·k) of a continuous loop, feedforward included.

        It is 1 where Ĵ = J on an `Inertia`.
        """
        return closed_transfer(self)

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
        >>> from jounce.plant import PID, Inertia
        >>> loop = ServoLoop(Inertia(1.0), PID(kp=1.0, ki=0.0, kr=2.0))
        >>> sampled = loop.sampled_loop_transfer(0.5, delay=0.25)
        >>> round(float(abs(sampled.feedback().poles()).max()), 3)
        0.805
        """
        return sampled_transfer(self, dt, delay, rate)

    def sensitivity(self) -> Sensitivity:
        """Return S, T, PS and CS of the linear loop; of a digital one at the samples.

        There PS is the response to a torque that is held from sample to sample.
        """
        return named(sensitivity_of(self))

    def open_model(self) -> Any:
        """Return L as bare numbers with poles, zeros and values, which need no python-control."""
        return self._open_model

    @cached_property
    def _open_model(self) -> Any:
        return open_model(self)

    def sensitivity_models(self) -> Sensitivity:
        """Return S, T, PS and CS in the same way."""
        return sensitivity_of(self)

    @cached_property
    def _interconnection(self) -> control.StateSpace:
        import control

        if not known_by_polynomials(self):
            return closed_system(self.axis, self.open_loop)
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

    @cached_property
    def model(self) -> StateModel:
        """The numbers of `system`."""
        if isinstance(self.plant, FlexibleInertia) and known_by_polynomials(self):
            return StateModel.of(self._interconnection)
        whole = closed_model(self.axis, self.open_loop)
        if not known_by_polynomials(self):
            return whole
        missing = ((0, 0), (0, 3 - whole.ninputs))
        return StateModel(
            whole.A, np.pad(whole.B, missing), whole.C[:3], np.pad(whole.D[:3], missing)
        )

    def system(self) -> control.StateSpace:
        """Return the interconnected loop (r, r_rate, r_acceleration) → (y, e, u).

        With a `FlexibleInertia` the outputs go on with y_load and twist. Of an `Axis` they are y,
        e, u, y_load, twist and torque, and the inputs go up to the derivative that controller
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
        command: Any,
        dt: float | None = None,
        *,
        duration: float | None = None,
        disturbance: Any = None,
        jerk_filter: JerkFilter | None = None,
        times: ArrayLike | None = None,
        start: float | None = None,
        noise: ArrayLike | None = None,
    ) -> LoopResponse:
        """Return the loop's exact response to a command, its derivatives fed forward.

        Parameters
        ----------
        command : Trajectory, Transfer, Ramp, Sine or a sum of them
            A continuous loop needs the derivatives that controller and feedforward take: a
            trajectory of their order or more, or of any order behind a jerk filter that is high
            enough. The loop starts at rest at the command's start.
        dt : float, optional
            Spacing of the time grid; its choice does not change the values. Left out with `times`.
        duration : float, optional
            Length of the grid, which ends at the last multiple of dt within it. Default: the
            trajectory's duration; a command that never ends needs it.
        disturbance : TorqueSteps, SampledTorque, TorqueSine or a list of them, optional
        jerk_filter : JerkFilter, optional
            Put between the trajectory and a continuous loop without disturbance, limit or friction.
        times : (N,) array, optional
            Increasing times instead of the grid, none before the start.
        start : float, optional
            Measured position at the start. Default: where the command starts.
        noise : array, optional
            Added to the measured position, one value a sample of a digital controller.

        Returns
        -------
        LoopResponse

        Raises
        ------
        ValueError
            For a trajectory of too low an order (a derivative is then a train of impulses), a
            dt or duration that is not positive, or a loop that is unstable.
        """
        scene = self.scene(
            *(command, duration, disturbance, times, start, noise), jerk_filter=jerk_filter
        )
        if scene is None:
            return self._respond_exactly(as_trajectory(command), dt, duration, jerk_filter)
        return response_of(scene, dt, times)

    def scene(
        self,
        command: Any,
        duration: float | None = None,
        disturbance: Any = None,
        times: ArrayLike | None = None,
        start: float | None = None,
        noise: ArrayLike | None = None,
        *,
        jerk_filter: JerkFilter | None = None,
    ) -> Scene | None:
        """Return what `respond` simulates; None for a response by powers of a matrix.

        That is what an undisturbed, linear, continuous loop on a grid has; the arguments are those
        of `respond`.
        """
        given = as_command(command)
        exact = isinstance(given, Trajectory) and not (
            self.is_digital
            or self.axis.friction
            or self.axis.ripple
            or self.axis.torque_limit < inf
        )
        given_more = (disturbance, times, start, noise)
        plain = exact and all(each is None for each in given_more)
        if plain and not (self.axis.spring or self.axis.constant_load):
            return None
        if jerk_filter is not None:
            raise ValueError(
                "a jerk filter in front of a loop that is digital, disturbed or nonlinear: shape "
                "the command by limits instead, or leave the filter out"
            )
        self._check_fed(given)
        return self._scene(given, duration, disturbance, start, noise, times)

    def deviations(
        self, wind: Wind | Spectrum | None = None, *, encoder_noise: float | Spectrum = 0.0
    ) -> LoopDeviations:
        """Return the standard deviations of the linear loop in wind and noise, the command still.

        By the covariance at the samples (Lyapunov's equation, the wind's noise gathered over hold
        and delay), or of a spectrum that is no rational function by the integral over frequency,
        what is above the Nyquist frequency included. Friction, limit and resolution are left out;
        the encoder's step q is fairly white noise of q/√12 where the axis moves by more in a
        sample.

        Parameters
        ----------
        wind : Wind or Spectrum, optional
            Of a torque.
        encoder_noise : float or Spectrum, optional
            Standard deviation of independent errors of each sample, or the spectrum of errors of
            the measured position, of which a digital controller's samples fold down what is above
            half their rate.

        Returns
        -------
        LoopDeviations

        Raises
        ------
        ValueError
            For an unstable loop, or white encoder noise in a loop without samples.
        """
        coloured = encoder_noise if isinstance(encoder_noise, Spectrum) else None
        white = 0.0
        if not isinstance(encoder_noise, Spectrum):
            white = finite("encoder_noise", encoder_noise)
        if self.is_digital:
            return digital_deviations(self.axis, self.controller_noun, wind, coloured or white)
        if white:
            raise ValueError(
                f"encoder_noise = {shown(encoder_noise)} in a continuous loop: white "
                "noise comes with "
                "each sample; give the controller a sample_time, or a Spectrum"
            )
        return continuous_deviations(self.axis, self.controller_noun, wind, coloured)

    def _check_fed(self, command: Any) -> None:
        highest = self.feedforward_noun.order
        if not self.is_digital:
            highest = max(highest, self.open_loop.fed.shape[1] - 1)
        for part in command.parts if isinstance(command, Sum) else (command,):
            if isinstance(part, Trajectory):
                check_fed(part, range(highest + 1))

    def _scene(
        self,
        command: Any,
        duration: float | None,
        disturbance: Any,
        start: float | None,
        noise: ArrayLike | None,
        times: ArrayLike | None,
    ) -> Scene:
        begin, where = start_of(command)
        if duration is None and times is not None:
            duration = float(real_array("times", times)[-1]) - begin
        if duration is None and not isinstance(command, Trajectory):
            raise ValueError("a command that never ends: give duration=…")
        length = command.duration if duration is None else positive("duration", duration)
        measured = None if noise is None else real_array("noise", noise)
        scene = Scene(
            self.axis,
            self.controller_noun,
            self.feedforward_noun,
            command,
            where if start is None else finite("start", start),
            begin,
            length,
            checked_disturbances(disturbance),
            measured,
        )
        if measured is not None and measured.shape != (scene.sample_count or -1,):
            raise ValueError(
                f"noise of shape {measured.shape}: expected one value a sample, "
                f"{scene.sample_count} of them; a continuous controller takes none"
            )
        return scene

    def _respond_exactly(
        self,
        trajectory: Trajectory,
        dt: float | None,
        duration: float | None,
        jerk_filter: JerkFilter | None,
    ) -> LoopResponse:
        """Return the response of a linear, continuous loop on a grid, by powers of a matrix."""
        if dt is None:
            raise ValueError("dt is missing: give the spacing of the time grid, or times=…")
        fed = self.model.ninputs
        if jerk_filter is None:
            check_fed(as_trajectory(trajectory), range(fed))
        elif fed > 3:
            raise ValueError(
                "a jerk filter gives position, velocity and acceleration: leave out the filter, or "
                "the feedforward of higher derivatives"
            )
        start = float(as_trajectory(trajectory).start_state[0])
        moved = trajectory.shift(-start)
        system, initial, behind = self.model, np.zeros(self.model.nstates), None
        if jerk_filter is not None:
            behind = filter_outputs(checked_filter(jerk_filter), moved)
            system, fed, initial = behind_filter(system, jerk_filter, moved, behind)
        time, states, inputs, outputs = respond_on_grid(
            system, range(fed), moved, positive("dt", dt), duration, initial
        )
        if behind is not None:
            inputs = product(behind, states[: behind.shape[1]], np.empty((3, time.size)))
            states = states[behind.shape[1] :]
        if self.feedforward_noun.position:
            outputs[1] = inputs[0] - outputs[0]
        for row in (outputs[0], states[0], inputs[0], *outputs[3:4]):
            row += start
        scene = None
        if behind is None:
            scene = self._scene(trajectory, duration, None, None, None, None)
        return LoopResponse(time, inputs, outputs, states, scene=scene)


def _sum(signs: list[float], parts: list[str], whole: str) -> control.StateSpace:
    return static_gain([signs], inputs=parts, outputs=[whole], name=f"sum_{whole}")
