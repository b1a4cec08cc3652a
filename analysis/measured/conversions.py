"""From what was measured to what is asked for: L from S, T or PS, S and T from L."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...shaping.frozen import Frozen
from ...shaping.told import Told
from .controller_values import ControllerValues, controller_values
from .measured_response import MeasuredResponse, as_measured
from .rational_fits import Complex, Real


@dataclass(frozen=True, eq=False)
class Factored:
    """A loop as what is fitted between lines times what is known everywhere: L = fitted·C."""

    fitted: MeasuredResponse
    controller: ControllerValues


def factored_loop(measured: MeasuredResponse, controller: Any = None) -> Factored:
    """Return the open loop of a measured response of any kind, with a controller as C.

    Raises
    ------
    ValueError
        For a plant or PS without controller, or another kind with one.
    """
    measured = as_measured(measured, plant=controller is not None)
    values = controller_values(controller, measured)
    needs = measured.kind in ("plant", "process-sensitivity")
    if needs and controller is None:
        raise ValueError(
            f"kind = {measured.kind!r} without a controller: margins are those of a loop; give "
            "controller=…, or kind='loop' if the controller is measured with the plant"
        )
    if not needs and controller is not None:
        raise ValueError(
            f"kind = {measured.kind!r} with a controller: the response has one in it; leave "
            "controller out, or measure the plant (kind='plant')"
        )
    if measured.kind == "plant":
        return Factored(measured, values)
    return Factored(_loop_of(measured, values), ControllerValues())


def open_loop(measured: MeasuredResponse, controller: Any = None) -> MeasuredResponse:
    """Return L on the lines of a measured response.

        L = C·G,   L = 1/S − 1,   L = T/(1 − T),   L = C·PS/(1 − C·PS)

    with |dL| = |C|·|dG|, |dS|/|S|², |dT|/|1 − T|² and |C|·|dPS|/|1 − C·PS|².

    Parameters
    ----------
    measured : MeasuredResponse
    controller : Controller, PID, CascadedPI or python-control system, optional
        Needed with a plant and with PS, refused with the others.

    Returns
    -------
    MeasuredResponse
        Of kind "loop", on the same frequencies in Hz.

    Raises
    ------
    ValueError, TypeError
        For a controller that is missing or too many, and for what is no measured response.
    """
    measured = as_measured(measured, plant=controller is not None)
    parts = factored_loop(measured, controller)
    if measured.kind != "plant":
        return parts.fitted
    c: Any = parts.controller.at(measured.frequency_hz)
    return _as_loop(
        measured, measured.response * c, _times(measured.sigma, abs(c)), parts.controller
    )


def plant_response(measured: MeasuredResponse, controller: Any) -> MeasuredResponse:
    """Return G on the lines of a measured loop, S, T or PS, by the controller it ran with.

        G = L/C,   |dG| = |dL|/|C|,   L as `open_loop` has it

    Parameters
    ----------
    measured : MeasuredResponse
        One of a plant is returned as it is.
    controller : Controller, PID, CascadedPI or python-control system

    Returns
    -------
    MeasuredResponse
        Of kind "plant", position per torque, on the same frequencies in Hz.

    Raises
    ------
    ValueError, TypeError
        For a controller that is missing, or sampled at another rate than the data.
    """
    measured = as_measured(measured, plant=False)
    if measured.kind == "plant":
        return measured
    values = controller_values(controller, measured)
    of_loop = controller if measured.kind == "process-sensitivity" else None
    loop = open_loop(measured, of_loop)
    c: Any = values.at(measured.frequency_hz)
    integrators = loop.integrators
    if integrators is not None:
        integrators = max(0, integrators - values.integrators)
    return replace(
        loop,
        response=loop.response / c,
        sigma=_times(loop.sigma, 1.0 / abs(c)),
        kind="plant",
        integrators=integrators,
    )


@dataclass(frozen=True, eq=False, repr=False)
class ClosedResponses(Told, Frozen):
    """S and T of a measured loop on its lines.

    Attributes
    ----------
    frequency_hz : (N,) array
    sensitivity, complementary : (N,) complex array
    sigma : (N,) array or None
        Complex standard deviation of both: |S|²·σ_L.
    """

    frequency_hz: Real
    sensitivity: Complex
    complementary: Complex
    sigma: Real | None

    def band(self, which: str = "sensitivity", probability: float = 0.95) -> tuple[Real, Real]:
        """Return the least and the largest magnitude within circles of a probability, (N,) each.

        Their radius is σ·√(−ln(1 − p)).
        """
        if not 0.0 < probability < 1.0:
            raise ValueError(f"probability = {probability!r}: expected a number between 0 and 1")
        size = abs(getattr(self, which))
        sigma = np.zeros_like(size) if self.sigma is None else self.sigma
        radius = sigma * np.sqrt(-np.log(1.0 - probability))
        return np.maximum(size - radius, 0.0), size + radius

    def above(self, limit: Any, which: str = "sensitivity") -> Real:
        """Return the lines in Hz on which a magnitude is above a limit, a number or (N,) array."""
        return np.asarray(self.frequency_hz[abs(getattr(self, which)) > np.asarray(limit)])


def closed_responses(measured: MeasuredResponse, controller: Any = None) -> ClosedResponses:
    """Return S and T on the lines of a measured response.

        S = 1/(1 + L),   T = L·S,   |dS| = |dT| = |S|²·|dL|

    Parameters
    ----------
    measured : MeasuredResponse
    controller : Controller, PID, CascadedPI or python-control system, optional
        As in `open_loop`, which L is of.

    Returns
    -------
    ClosedResponses
        On the same frequencies in Hz.

    Raises
    ------
    ValueError, TypeError
        As `open_loop` does.
    """
    loop = open_loop(measured, controller)
    s = 1.0 / (1.0 + loop.response)
    sigma = _times(loop.sigma, abs(s) ** 2)
    return ClosedResponses(loop.frequency_hz, s, loop.response * s, sigma)


def _loop_of(measured: MeasuredResponse, values: ControllerValues) -> MeasuredResponse:
    """Return L of what is not a plant."""
    value = measured.response
    if measured.kind == "loop":
        return measured
    if measured.kind == "sensitivity":
        _check_loop(measured, value, "S = 0", "L = 1/S − 1")
        return _as_loop(measured, 1.0 / value - 1.0, _times(measured.sigma, abs(value) ** -2.0))
    c: Any = 1.0
    if measured.kind == "process-sensitivity":
        c = values.at(measured.frequency_hz)
    t = c * value
    _check_loop(measured, 1.0 - t, "T = 1", "L = T/(1 − T)")
    sigma = _times(measured.sigma, abs(c) / abs(1.0 - t) ** 2)
    return _as_loop(measured, t / (1.0 - t), sigma, values)


def _check_loop(measured: MeasuredResponse, divisor: Complex, where: str, formula: str) -> None:
    """Refuse lines on which the loop would be infinite."""
    if not divisor.all():
        at = measured.frequency_hz[int(np.argmin(abs(divisor)))]
        raise ValueError(
            f"{where} at {at:g} Hz, where {formula} is infinite: expected digits that tell S and T "
            "from 0 and 1; write more of them, or leave the line out"
        )


def _as_loop(
    measured: MeasuredResponse,
    response: Complex,
    sigma: Real | None,
    values: ControllerValues | None = None,
) -> MeasuredResponse:
    integrators = measured.integrators
    if integrators is not None and values is not None:
        integrators += values.integrators
    return replace(measured, response=response, sigma=sigma, kind="loop", integrators=integrators)


def _times(sigma: Real | None, factor: Any) -> Real | None:
    return None if sigma is None else sigma * factor
