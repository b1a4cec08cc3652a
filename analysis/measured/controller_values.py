"""A controller's own response, exact at every frequency, and where it is narrow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isclose
from typing import Any

import numpy as np

from ...plant import Controller, as_controller
from ...plant.cascade import CascadedPI
from ...plant.frequency_points import frequency_points
from ...plant.pid import PID
from ...shaping.real_numbers import shown
from .measured_response import MeasuredResponse, is_frd
from .rational_fits import Complex, Real
from .state_groups import StateGroups, state_groups

_SAME = 1e-6  # relative, of sample times
_SINGULAR = 1e-7  # of 1 − z or s over its scale: an integrator


@dataclass(frozen=True, eq=False)
class ControllerValues:
    """A controller as a system with one input and output, to be evaluated anywhere.

    A system without one, None, is 1 everywhere.
    """

    system: Any = None

    @property
    def dt(self) -> float | None:
        """Sample time of a digital one."""
        if self.system is None or not self.system.isdtime(strict=True):
            return None
        return float(self.system.dt)

    def at(self, frequency_hz: Real) -> Complex:
        """Return C at frequencies in Hz."""
        if self.system is None:
            return np.ones(len(frequency_hz), dtype=complex)
        s: Complex = np.asarray(2j * np.pi * frequency_hz)
        places = s if self.dt is None else np.asarray(np.exp(s * self.dt))
        if hasattr(self.system, "num_array"):
            above, below = self.system.num_array[0, 0], self.system.den_array[0, 0]
            return np.asarray(np.polyval(above, places) / np.polyval(below, places))
        return self._grouped.at(places)

    def slope(self, frequency_hz: Real) -> Complex:
        """Return dC/df, by a difference that is exact to 1e-8 of it."""
        if self.system is None:
            return np.zeros(len(frequency_hz), dtype=complex)
        step = 1e-6 * frequency_hz
        apart = self.at(frequency_hz + step) - self.at(frequency_hz - step)
        return np.asarray(apart / (2.0 * step))

    def places(self, low: float, high: float) -> Real:
        """Return frequencies in Hz between two where it has to be looked at: its narrow parts."""
        if self.system is None:
            return np.empty(0)
        hertz = frequency_points(self.system, 0.0) / (2.0 * np.pi)
        return np.asarray(hertz[(hertz > low) & (hertz < high)])

    @cached_property
    def _grouped(self) -> StateGroups:
        return state_groups(self.system)

    @property
    def integrators(self) -> int:
        """Number of poles at s = 0 or z = 1."""
        return self._count(unstable=False)

    @property
    def unstable_poles(self) -> int:
        """Number of poles in the right half plane, or outside the unit circle."""
        return self._count(unstable=True)

    def _count(self, *, unstable: bool) -> int:
        if self.system is None:
            return 0
        poles = np.asarray(self.system.poles())
        off = poles - 1.0 if self.dt is not None else poles
        scale = 1.0 if self.dt is not None else max(float(abs(poles).max(initial=0.0)), 1e-300)
        at_zero = abs(off) <= _SINGULAR * scale
        beyond = abs(poles) - 1.0 if self.dt is not None else poles.real / scale
        return int((~at_zero & (beyond > _SINGULAR)).sum() if unstable else at_zero.sum())


def controller_values(controller: Any, measured: MeasuredResponse | None = None) -> Any:
    """Return a controller to evaluate; None stands for 1.

    Parameters
    ----------
    controller : Controller, PID, CascadedPI or python-control system, optional
        The computing delay of a Controller is left out: it is in what was measured.
    measured : MeasuredResponse, optional
        What it is to control: sample times have to agree.

    Raises
    ------
    TypeError
        For anything else, measured controllers among them.
    ValueError
        For a controller of another sample time, or with several inputs or outputs.
    """
    values = ControllerValues(_system(controller))
    if measured is not None and values.system is not None:
        _check_sample_time(values, measured)
    return values


def _system(controller: Any) -> Any:
    import control

    if controller is None:
        return None
    if isinstance(controller, Controller | PID | CascadedPI):
        whole = as_controller(controller)
        if whole.sample_time is None:
            return whole.transfer()
        both = whole.sampled()
        a, b, c, d = (np.asarray(part) for part in (both.A, both.B, both.C, both.D))
        sums = b.sum(axis=1, keepdims=True), c, d.sum(axis=1, keepdims=True)
        return control.ss(a, *sums, whole.sample_time)
    if is_frd(controller) or isinstance(controller, MeasuredResponse):
        raise TypeError(
            f"controller is a {type(controller).__name__}: expected a model, which is known "
            "between the lines, too; give a Controller or a python-control system"
        )
    if not isinstance(controller, control.StateSpace | control.TransferFunction):
        raise TypeError(
            f"controller = {shown(controller)}: expected a Controller, PID, CascadedPI or a "
            "python-control system"
        )
    if (controller.noutputs, controller.ninputs) != (1, 1):
        raise ValueError(
            f"controller has {controller.ninputs} inputs and {controller.noutputs} outputs: "
            "expected one of each; pick a channel with controller[i, j]"
        )
    if controller.isdtime(strict=True) and controller.dt is True:
        raise ValueError(
            "controller is discrete in time, but its dt = True names no sample time: give it when "
            "the system is made, control.tf(…, dt=0.001)"
        )
    return controller


def _check_sample_time(values: ControllerValues, measured: MeasuredResponse) -> None:
    dt, own = measured.dt, values.dt
    if dt is not None and own is None:
        raise ValueError(
            f"the controller is continuous, the response was sampled every {dt:g} s: expected a "
            f"digital one; give Controller(…, sample_time={dt:g})"
        )
    if dt is not None and own is not None and not isclose(dt, own, rel_tol=_SAME):
        raise ValueError(
            f"the controller's sample time is {own:g} s, that of the response {dt:g} s: expected "
            "the same; design the controller anew for the response's, or measure at its own"
        )
    last = float(measured.frequency_hz[-1])
    if own is not None and last > 0.5 / own * (1.0 + 1e-9):
        raise ValueError(
            f"the response goes up to {last:g} Hz, beyond half the controller's sampling frequency "
            f"({0.5 / own:g} Hz): leave those lines out, or see that frequencies are in Hz"
        )
