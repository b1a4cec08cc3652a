"""A loop whose PID gains are still open: its frequency response is linear in them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..shaping.checks import finite
from ..shaping.real_numbers import shown
from .controller import Controller
from .pid import PID
from .servo_loop import ServoLoop

if TYPE_CHECKING:
    pass


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
        dt = self.controller.sample_time
        places = 1j * omega if dt is None else np.exp(1j * omega * dt)
        columns = [system(places) for system in self._of_one_gain]
        delayed = np.exp(-1j * omega * self.delay)[:, None]
        return np.asarray(np.stack(columns, axis=1) * delayed)


def pure_delay(delay: float) -> float:
    """Return the delay of a continuous loop; ValueError unless it is ≥ 0 and finite."""
    number = finite("delay", delay)
    if number < 0.0:
        raise ValueError(f"delay = {shown(delay)}: expected a number of seconds, 0 or more")
    return number
