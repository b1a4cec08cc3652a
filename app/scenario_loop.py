"""The loop and the filter that a scenario describes."""

from __future__ import annotations

from ..plant import PID, Inertia, InertiaFeedforward, ServoLoop, design_pid
from ..plant.pid import printed_pid
from ..shaping import JerkFilter
from .scenario import Gains, Scenario


def jerk_filter_of(scenario: Scenario) -> JerkFilter | None:
    """Return the filter behind the shaper, if there is one."""
    behind = scenario.filter
    return None if behind is None else JerkFilter(behind.corner_hz, behind.order)


def servo_loop_of(scenario: Scenario) -> ServoLoop:
    """Return the loop, its gains designed where the scenario asks for that."""
    try:
        controller = controller_of(scenario)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: controller.specification: {error}") from None
    feedforward = InertiaFeedforward(scenario.feedforward_inertia)
    return ServoLoop(Inertia(scenario.inertia), controller, feedforward)


def controller_of(scenario: Scenario) -> PID:
    """Return the controller that a scenario gives or asks for."""
    if isinstance(scenario.gains, Gains):
        return PID(scenario.gains.kp, scenario.gains.ki, scenario.gains.kr)
    if scenario.gains == "published":
        return printed_pid(scenario.inertia)
    asked = scenario.specification
    assert asked is not None  # the scenario's own check
    return design_pid(
        scenario.inertia,
        crossover_hz=asked.crossover_hz,
        phase_margin_deg=asked.phase_margin_deg,
        lower_gain_margin_db=asked.lower_gain_margin_db,
    )
