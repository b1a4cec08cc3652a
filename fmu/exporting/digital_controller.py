"""The whole digital controller, to be exported: law, filters, feedforward, limit, encoder."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import inf
from typing import Any

from ...plant.controller import Controller, as_controller
from ...plant.feedforward import Feedforward, as_feedforward
from ...plant.layout import at_rest, start_of
from ...plant.servo_loop import ServoLoop
from ...shaping.checks import finite, of_kind
from ...shaping.frozen import Frozen
from ...shaping.real_numbers import real_number


@dataclass(frozen=True)
class DigitalController(Frozen):
    """A digital controller with all that runs in one sample of it, to be exported.

    Law, filters, feedforward of any derivative, torque limit, anti-windup, encoder: what
    `ServoLoop.respond` runs, to the last bit. What the exact inverse of a damped axis remembers of
    the command are inputs of it, which the trajectory beside it in an SSP puts out.

    Parameters
    ----------
    controller : Controller
        With a sample time.
    feedforward : Feedforward or InertiaFeedforward, optional
        Default: none.
    torque_limit : float, optional
        Positive. Default: none.
    encoder_step : float, optional
        Resolution ≥ 0 in which positions are read.
    two_encoders : bool, optional
        Whether the velocity is taken from an encoder of its own, on the motor.
    holding : float, optional
        Torque that the integral holds at the start.

    Raises
    ------
    TypeError, ValueError
        For a continuous controller, or a value out of range.

    Examples
    --------
    >>> from jounce.plant import PID
    >>> digital = Controller(PID(2.0, 1.0, 3.0), sample_time=1e-3)
    >>> DigitalController(digital, torque_limit=5.0).dt
    0.001
    """

    controller: Controller
    feedforward: Any = None
    _: KW_ONLY
    torque_limit: float = inf
    encoder_step: float = 0.0
    two_encoders: bool = False
    holding: float = 0.0

    def __post_init__(self) -> None:
        of_kind("controller", self.controller, Controller, "a Controller(law, sample_time=…)")
        check_digital(self.controller)
        object.__setattr__(self, "feedforward", as_feedforward(self.feedforward))
        limit = real_number("torque_limit", self.torque_limit)
        if not limit > 0.0:
            raise ValueError(f"torque_limit = {self.torque_limit!r}: expected a positive torque")
        step = finite("encoder_step", self.encoder_step)
        if step < 0.0:
            raise ValueError(f"encoder_step = {self.encoder_step!r}: expected a number ≥ 0")
        for name, value in (("torque_limit", limit), ("encoder_step", step)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "holding", finite("holding", self.holding))

    @classmethod
    def of(cls, loop: ServoLoop, command: Any = None) -> DigitalController:
        """Return that of a loop, which holds the axis where the command starts (default: at 0)."""
        of_kind("loop", loop, ServoLoop, "a ServoLoop")
        axis = loop.axis
        return cls(
            as_controller(loop.controller),
            loop.feedforward,
            torque_limit=axis.torque_limit,
            encoder_step=axis.encoder_step,
            two_encoders=axis.sensor == "both",
            holding=at_rest(axis, 0.0 if command is None else start_of(command)[1])[1],
        )

    @property
    def dt(self) -> float:
        """Sample time."""
        assert self.controller.sample_time is not None
        return self.controller.sample_time

    @property
    def order(self) -> int:
        """Highest derivative of the command that is taken."""
        fed: Feedforward = self.feedforward
        return max(fed.order, 1)


def check_digital(controller: Controller) -> None:
    """Refuse a controller that runs continuously."""
    if controller.sample_time is None:
        raise ValueError(
            "a continuous controller cannot leave: only what runs once a sample is the same in a "
            "processor; give it one, Controller(…, sample_time=1e-3)"
        )
