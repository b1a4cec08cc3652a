"""What disturbs the loop of a scenario, and the commands that go on."""

from __future__ import annotations

from typing import Any

from ..analysis.specification import Tracking
from ..plant import Ramp, Sine, TorqueSteps, Wind
from ..shaping import CommandFollower, Limits, Trajectory, follow_commands, scan_move
from .scenario import Scenario
from .scenario_asked import FileSection, TrackingSection
from .scenario_kinds import SIDEREAL
from .units import factor


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
    try:
        command, duration = _command(section, scenario), section.duration
        if isinstance(command, Trajectory):
            duration = duration or command.duration
        assert duration is not None  # the section's own check
        return Tracking(section.name, command, duration, section.after)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: tracking {section.name!r}: {error}") from None


def _command(section: TrackingSection, scenario: Scenario) -> Any:
    if section.scan is not None:
        scan, limits = section.scan, _limits(section.scan.limits, scenario)
        return scan_move(scan.length, scan.rate, limits, lines=scan.lines).trajectory
    if section.file is not None:
        return _followed(section.file, scenario)
    rate, sine = section.rate, section.sine
    parts: list[Any] = []
    if rate is not None:
        parts.append(Ramp(SIDEREAL if isinstance(rate, str) else rate))
    if sine is not None:
        parts.append(Sine(sine.amplitude, sine.frequency))
    return parts[0] if len(parts) == 1 else parts[0] + parts[1]


def _limits(name: str, scenario: Scenario) -> Limits:
    return Limits.from_bounds(scenario.limit_sets[name])


def _followed(file: FileSection, scenario: Scenario) -> Trajectory:
    """Return what a follower makes of the positions in a file beside the scenario."""
    from ..analysis import read_log

    path = scenario.path.parent / file.path
    try:
        times, positions = read_log(path, _column(file.time), _column(file.position))
    except OSError as error:
        raise ValueError(
            f"file {path}: {error.strerror or error}; name a CSV file, from this file's folder on"
        ) from None
    scale = factor(file.unit or scenario.position_unit)
    follower = CommandFollower(_limits(file.limits, scenario), dt=file.sample_time)
    return follow_commands(follower, times, scale * positions)


def _column(name: str) -> int | str:
    """Return a column's name, or its number from 0 on."""
    return int(name) if name.isdecimal() else name
