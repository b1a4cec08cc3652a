"""The loop that a scenario describes, with the filter behind its shaper."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import isfinite
from typing import Any

from ..analysis.measured import MeasuredResponse
from ..analysis.tuning import tune_pid
from ..plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    Inertia,
    InertiaFeedforward,
    LeadLag,
    LowPass,
    Notch,
    ServoLoop,
    design_pid,
    inverse_feedforward,
    low_frequency_feedforward,
)
from ..plant.discretise import FilterWarning
from ..plant.pid import printed_pid
from ..shaping import JerkFilter
from ..shaping.warned import untold, warned_of
from .scenario import Gains, Scenario
from .scenario_axis import plant_of
from .scenario_frf import TIME_RESPONSE
from .scenario_sections import (
    BackCalculationSection,
    CascadeSection,
    ClampSection,
    ControllerSection,
    LeadLagSection,
    LowPassSection,
    NotchSection,
    TuneSection,
)


def jerk_filter_of(scenario: Scenario) -> JerkFilter | None:
    """Return the filter behind the shaper, if there is one."""
    behind = scenario.filter
    return None if behind is None else JerkFilter(behind.corner_hz, behind.order)


def servo_loop_of(
    scenario: Scenario, fed: InertiaFeedforward | Feedforward | None = None
) -> ServoLoop:
    """Return the loop, its gains designed where the scenario asks for that.

    A feedforward that is known to be the scenario's is not made anew.

    Raises
    ------
    ValueError
        For an axis that cannot hold its load, a filter above the Nyquist frequency, a
        specification out of reach, or an axis without exact inverse: one line, with the key.
    """
    if scenario.body == "frf":
        raise ValueError(f"{scenario.path}: plant.frf: {TIME_RESPONSE}; margins need none of it")
    plant = plant_of(scenario)
    known = scenario.as_believed
    believed = plant if known is scenario else plant_of(known)
    controller = controller_of(known, believed)
    if fed is not None:
        return ServoLoop(plant, controller, fed)
    with _named(scenario, "feedforward"), untold(FilterWarning):  # it is told with its key
        return ServoLoop(plant, controller, feedforward_of(known, believed, controller))


@contextmanager
def _named(scenario: Scenario, key: str) -> Iterator[None]:
    """Name file and key in errors."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{scenario.path}: {key}: {error}") from None


def controller_of(
    scenario: Scenario, plant: Inertia | Axis | MeasuredResponse
) -> PID | CascadedPI | Controller:
    """Return the controller that a scenario gives or asks for."""
    if scenario.controller == ControllerSection():
        with _named(scenario, "controller.specification"):
            return _law(scenario, plant, {})
    run = _run(scenario)
    with untold(FilterWarning):
        return _controller(scenario, plant, run)


def _controller(
    scenario: Scenario, plant: Any, run: dict[str, Any]
) -> PID | CascadedPI | Controller:
    """Return the law behind its filters, or the law alone where nothing else is said."""
    law: PID | CascadedPI
    if scenario.gains == "design":
        with _named(scenario, "controller.specification"):
            law = _designed(scenario, plant, run)
    else:
        with _named(scenario, "controller.gains"):
            law = _law(scenario, plant, run)
    with _named(scenario, "controller.anti_windup"):
        whole = Controller(law, **run, anti_windup=_anti_windup(scenario.controller.anti_windup))
    return law if whole == Controller(law) else whole


def _run(scenario: Scenario) -> dict[str, Any]:
    """Return how the controller is run, each filter checked."""
    section, filters = scenario.controller, []
    clock: dict[str, Any] = {
        "sample_time": section.sample_time,
        "discretisation": section.discretisation,
    }
    for number, given in enumerate(section.filters):
        key = f"controller.filters[{number}]"
        with _named(scenario, key), warned_of(f"{scenario.path}: {key}"):
            filters.append(_filter(given))
            Controller(PID(1.0, 0.0, 0.0), filters=filters[-1:], **clock)
    return {"filters": tuple(filters), "delay": section.delay, **clock}


def _law(scenario: Scenario, plant: Any, run: dict[str, Any]) -> PID | CascadedPI:
    gains, filtered = scenario.gains, scenario.controller.derivative_filter
    if isinstance(gains, CascadeSection):
        return _cascade(gains, filtered)
    if isinstance(gains, Gains):
        return PID(gains.kp, gains.ki, gains.kr, derivative_filter=filtered)
    if gains == "published":
        printed = printed_pid(scenario.inertia)
        return PID(printed.kp, printed.ki, printed.kr, derivative_filter=filtered)
    if gains == "tune":
        bounds = scenario.controller.tune or TuneSection()
        return tune_pid(plant, derivative_filter=filtered, **vars(bounds), **run).pid
    return _designed(scenario, plant, run)


def _designed(scenario: Scenario, plant: Any, run: dict[str, Any]) -> PID:
    asked = scenario.specification
    assert asked is not None  # the scenario's own check
    filtered = scenario.controller.derivative_filter
    try:
        return design_pid(plant, derivative_filter=filtered, **vars(asked), **run)
    except ValueError as error:
        found = str(error).replace("let analysis.tune_pid find the gains", 'write gains = "tune"')
        raise ValueError(found) from None


def _cascade(gains: CascadeSection, filtered: float) -> CascadedPI:
    if filtered:
        raise ValueError(
            "derivative_filter is of a PID: write velocity_filter into the gains of the p-pi"
        )
    rest = {} if gains.reset_time is None else {"reset_time": gains.reset_time}
    return CascadedPI(
        gains.position_gain,
        gains.velocity_gain,
        velocity_filter=gains.velocity_filter,
        velocity_feedforward=gains.velocity_feedforward,
        **rest,
    )


def _filter(given: Any) -> Any:
    if isinstance(given, NotchSection):
        return Notch(
            given.frequency,
            given.pole_frequency,
            zero_damping=given.zero_damping,
            pole_damping=given.pole_damping,
        )
    if isinstance(given, LeadLagSection):
        return LeadLag(given.zero, given.pole)
    if isinstance(given, LowPassSection):
        return LowPass(given.corner, given.order, given.damping)
    return given.system()


def _anti_windup(given: Any) -> Any:
    if isinstance(given, BackCalculationSection):
        return BackCalculation(given.tracking_time)
    if isinstance(given, ClampSection):
        return Clamp(given.integral_limit)
    return None if given == "none" else given


def feedforward_of(
    scenario: Scenario, plant: Inertia | Axis, controller: Any
) -> InertiaFeedforward | Feedforward | None:
    """Return the feedforward; the plant's inertia where the scenario says nothing else."""
    section, lead = scenario.feedforward, _lead(scenario)
    if section.inverse:
        find = inverse_feedforward if section.inverse is True else low_frequency_feedforward
        try:
            found = find(plant, controller=controller)
        except ValueError as error:
            use, remedy = "use low_frequency_feedforward(axis)", 'write inverse = "low-frequency"'
            raise ValueError(str(error).replace(use, remedy)) from None
        return replace(found, friction=section.friction or found.friction, lead=lead)
    inertia = scenario.feedforward_inertia
    if not (section.gains or section.friction or lead):
        return InertiaFeedforward(inertia) if isfinite(inertia) else None
    assumed = {2: inertia} if isfinite(inertia) else {}
    return Feedforward(assumed | section.gains, friction=section.friction, lead=lead)


def _lead(scenario: Scenario) -> float:
    """Return by how much the feedforward looks ahead; "auto" makes up for delay and hold."""
    lead, controller = scenario.feedforward.lead, scenario.controller
    if not isinstance(lead, str):
        return lead
    if controller.sample_time is None:
        raise ValueError(
            "lead = 'auto' without a sample time: a continuous loop has no delay to make up for; "
            "leave it out"
        )
    return controller.delay + 0.5 * controller.sample_time
