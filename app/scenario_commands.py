"""What disturbs the loop of a scenario, and the commands that go on."""

from __future__ import annotations

from typing import Any

from ..analysis.specification import Tracking
from ..plant import Ramp, Sine, TorqueSteps, Wind
from ..shaping import Limits, Trajectory, min_time_move
from .scenario import Scenario
from .scenario_asked import ScanSection, TrackingSection
from .scenario_kinds import SIDEREAL


def survey_conditions(scenario: Scenario) -> dict[str, Any]:
    """Return what `survey` takes of a scenario besides loop and moves, by its keywords."""
    return {
        "wind": wind_of(scenario),
        "encoder_noise": scenario.disturbances.encoder_noise,
        "torque_step": torque_step_of(scenario),
        "tracking": tracking_of(scenario),
        "requirements": scenario.requirements,
    }


def wind_of(scenario: Scenario) -> Wind | None:
    """Return the wind, if there is one."""
    wind = scenario.disturbances.wind
    if wind is None:
        return None
    over = None if wind.length is None or wind.speed is None else wind.length / wind.speed
    return Wind(wind.kind, wind.sigma, corner_hz=wind.corner, length_over_speed=over, on=wind.on)


def torque_step_of(scenario: Scenario) -> TorqueSteps | None:
    """Return the disturbing step of torque, if there is one."""
    import numpy as np

    step = scenario.disturbances.torque_step
    if step is None:
        return None
    return TorqueSteps(np.array([step.time]), np.array([step.torque]), on=step.on)


def tracking_of(scenario: Scenario) -> tuple[Tracking, ...]:
    """Return the commands that go on."""
    return tuple(_tracking(each, scenario) for each in scenario.tracking)


def _tracking(section: TrackingSection, scenario: Scenario) -> Tracking:
    command, duration = _command(section, scenario), section.duration
    if isinstance(command, Trajectory):
        duration = duration or command.duration
    assert duration is not None  # the section's own check
    try:
        return Tracking(section.name, command, duration, section.after)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: tracking.{section.name}: {error}") from None


def _command(section: TrackingSection, scenario: Scenario) -> Any:
    if section.scan is not None:
        return _scan(section.scan, scenario)
    rate, sine = section.rate, section.sine
    parts: list[Any] = []
    if rate is not None:
        parts.append(Ramp(SIDEREAL if isinstance(rate, str) else rate))
    if sine is not None:
        parts.append(Sine(sine.amplitude, sine.frequency))
    return parts[0] if len(parts) == 1 else parts[0] + parts[1]


def _scan(scan: ScanSection, scenario: Scenario) -> Trajectory:
    """Return sweeps forth and back, each a move whose velocity is the scan's rate."""
    from ..shaping.sums import weighted_sum

    bounds = (scan.rate, *scenario.limit_sets[scan.limits][1:])
    forth = min_time_move(scan.length, Limits.from_bounds(bounds))
    sweeps = [forth.delay(k * forth.duration) for k in range(scan.sweeps)]
    return weighted_sum(sweeps, [(-1.0) ** k for k in range(scan.sweeps)])
