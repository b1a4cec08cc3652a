"""A loop whose PID gains are still open: its frequency response is linear in them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..shaping.checks import finite
from ..shaping.real_numbers import shown
from .controller import Controller
from .models import StateModel
from .pid import PID
from .sampled import held_model
from .servo_loop import ServoLoop


@dataclass(frozen=True)
class OpenGains:
    """A plant under a controller whose law is a PID with gains to be found.

    Attributes
    ----------
    plant : Inertia, FlexibleInertia, Axis or python-control system
    controller : Controller
        Its PID's gains are those to be found; its filter of the rate is kept.
    delay : float
        Pure delay of a continuous loop, in seconds; a digital one has its own.
    """

    plant: Any
    controller: Controller
    delay: float = 0.0

    def law(self, gains: NDArray[np.float64]) -> PID:
        """Return the PID of gains (kp, ki, kr)."""
        kp, ki, kr = gains.tolist()
        law = self.controller.law
        assert isinstance(law, PID)
        return replace(law, kp=kp, ki=ki, kr=kr)

    def with_gains(self, gains: NDArray[np.float64]) -> Controller:
        """Return the controller with gains (kp, ki, kr)."""
        return replace(self.controller, law=self.law(gains))

    def system(self, gains: NDArray[np.float64]) -> Any:
        """Return L(s), without the pure delay, or L(z) with gains (kp, ki, kr)."""
        return ServoLoop(self.plant, self.with_gains(gains)).open_model()

    @cached_property
    def _of_one_gain(self) -> list[Any]:
        return [self.system(unit) for unit in np.eye(3)]

    def terms(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return what kp, ki and kr are multiplied by in L(jω), (N, 3), ω (N,) in rad/s."""
        if self.controller.sample_time is not None:
            return self._sampled_terms(np.exp(1j * omega * self.controller.sample_time))
        columns = [system(1j * omega) for system in self._of_one_gain]
        delayed = np.exp(-1j * omega * self.delay)[:, None]
        return np.asarray(np.stack(columns, axis=1) * delayed)

    @cached_property
    def _sampled_parts(self) -> tuple[StateModel, StateModel, list[StateModel]]:
        """Plant behind hold and delay, filters behind kp = 1, and the law of each gain alone."""
        dt, delay = self.controller.sample_time or 0.0, self.controller.delay
        axis = ServoLoop(self.plant, self.controller).axis
        controllers = [self.with_gains(unit) for unit in np.eye(3)]
        laws = [replace(each, filters=()).sampled_model() for each in controllers]
        held = held_model(axis.measured_model(), dt, delay)
        return held, controllers[0].sampled_model(), laws

    def _sampled_terms(self, z: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return F(z)·k(z)·G(z) of each gain's law k: plant and filters are the same for all."""
        held, filters, laws = self._sampled_parts
        plant = held.at(z)
        columns = [(law.at(z) @ plant)[:, 0, 0] for law in laws]
        return np.asarray(np.stack(columns, axis=1) * filters.at(z)[:, 0, :1])


def pure_delay(delay: float) -> float:
    """Return the delay of a continuous loop; ValueError unless it is ≥ 0 and finite."""
    number = finite("delay", delay)
    if number < 0.0:
        raise ValueError(f"delay = {shown(delay)}: expected a number of seconds, 0 or more")
    return number
