"""A measured plant under a PID whose gains are still open: L is linear in them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...plant import PID, Controller
from .controller_values import ControllerValues, controller_values
from .conversions import factored_loop
from .loop_grid import loop_grid
from .margins_of_data import measured_margins
from .measured_response import MeasuredResponse
from .rational_fits import Complex, Real
from .result import MeasuredMargins

_BELOW = 1e3
_POINTS_BELOW = 120


@dataclass(frozen=True, eq=False)
class MeasuredGains:
    """What `OpenGains` is for models: L at frequencies and the margins for gains (kp, ki, kr).

    Attributes
    ----------
    measured : MeasuredResponse
        A plant.
    controller : Controller
        Its PID's gains are those to be found.
    """

    measured: MeasuredResponse
    controller: Controller

    def with_gains(self, gains: Real) -> Controller:
        """Return the controller with gains (kp, ki, kr)."""
        law = self.controller.law
        assert isinstance(law, PID)
        kp, ki, kr = gains.tolist()
        return replace(self.controller, law=replace(law, kp=kp, ki=ki, kr=kr))

    @cached_property
    def _of_one_gain(self) -> list[ControllerValues]:
        return [controller_values(self.with_gains(unit), self.measured) for unit in np.eye(3)]

    def omega(self) -> Real:
        """Return frequencies in rad/s at which the loop is looked at: among and between lines.

        And below them, so that no gains are found that are unstable there.
        """
        whole = factored_loop(self.measured, self.with_gains(np.ones(3)))
        among = loop_grid(whole).frequency_hz
        below = np.geomspace(among[0] / _BELOW, among[0], _POINTS_BELOW, endpoint=False)
        return 2.0 * np.pi * np.concatenate([below, among])

    def terms(self, omega: Real) -> Complex:
        """Return what kp, ki and kr are multiplied by in L, (N, 3).

        Below its first line the plant is continued as its slope there says.
        """
        hertz = omega / (2.0 * np.pi)
        inside = np.clip(hertz, *self.measured.frequency_hz[[0, -1]])
        fits = self.measured.fits
        plant = fits.at(inside).value * (inside / hertz) ** fits.power
        columns = [values.at(hertz) * plant for values in self._of_one_gain]
        return np.asarray(np.stack(columns, axis=1))

    def margins(self, gains: Real) -> MeasuredMargins:
        """Return the margins for gains (kp, ki, kr)."""
        return measured_margins(self.measured, self.with_gains(gains))
