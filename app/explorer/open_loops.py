"""L at any frequency, from what changes and what does not: plant and controller apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np

from ...analysis.measured.controller_values import ControllerValues, controller_values
from ...plant import ServoLoop
from ...plant.frequency_points import frequency_points
from ...plant.loop_transfers import known_by_polynomials
from ...plant.sampled import zero_order_hold
from ...shaping.pieces import FloatArray

_PER_CURVE = 400
_BESIDE = 1.0 + np.linspace(-0.5, 0.5, 31)


@dataclass(frozen=True, eq=False)
class OpenGain:
    """A loop's open-loop gain, L = G·C.

    Attributes
    ----------
    plant, controller : ControllerValues
        G with its hold and delay, of a digital loop, and C.
    resonances_hz : (N,) array
        Frequencies around the plant's, so that its light modes are drawn to their tips.
    """

    plant: ControllerValues
    controller: ControllerValues
    resonances_hz: FloatArray

    def at(self, frequency_hz: Any) -> Any:
        """Return L at frequencies in Hz, (N,) complex."""
        return self.plant.at(frequency_hz) * self.controller.at(frequency_hz)

    def size(self, frequency_hz: Sequence[float]) -> FloatArray:
        """Return |L| at frequencies in Hz."""
        return np.asarray(abs(self.at(np.asarray(frequency_hz, dtype=float))))

    def curve(
        self, low_hz: float, high_hz: float, beside: Sequence[float] = ()
    ) -> tuple[FloatArray, Any]:
        """Return the points to draw L at, and L, but where it is infinite."""
        frequency = self.points(low_hz, high_hz, beside)
        with np.errstate(all="ignore"):
            value = self.at(frequency)
        finite = np.isfinite(value)
        return frequency[finite], value[finite]

    def points(self, low_hz: float, high_hz: float, beside: Sequence[float] = ()) -> FloatArray:
        """Return frequencies in Hz to draw L at from low to high, dense beside some."""
        extra = [place * _BESIDE for place in beside]
        even = np.geomspace(low_hz, high_hz, _PER_CURVE)
        every = np.unique(np.concatenate([even, self.resonances_hz, *extra]))
        return np.asarray(every[(every >= low_hz) & (every <= high_hz)])


def open_gain(loop: ServoLoop) -> OpenGain:
    """Return L of a loop; with a sensor on either side that from the torque round to itself."""
    noun = loop.controller_noun
    if loop.axis.sensor == "both":
        whole = loop.loop_transfer()
        return OpenGain(ControllerValues(whole), ControllerValues(), _dense(whole))
    source = loop.plant if known_by_polynomials(loop) else loop.axis
    plant, resonances = _plant(source, noun.sample_time, noun.delay)
    return OpenGain(plant, controller_values(noun), resonances)


@lru_cache(maxsize=8)
def _plant(plant: Any, sample_time: float | None, delay: float) -> tuple[Any, FloatArray]:
    """Return G, of a digital loop behind its hold, and its resonances."""
    if sample_time is None:
        system = plant.transfer()
    else:
        system = zero_order_hold(plant.system()[0, 0], sample_time, delay=delay)
    return ControllerValues(system), _dense(system)


def _dense(system: Any) -> FloatArray:
    """Return frequencies in Hz where they are closer than anywhere between resonances."""
    points = frequency_points(system, 0.0) / (2.0 * pi)
    apart = np.diff(np.log(points), prepend=-np.inf)
    return np.asarray(points[apart < 0.5 * np.median(apart)])
