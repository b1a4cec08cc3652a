"""What disturbs the loop of a scenario, and the commands that go on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..analysis.disturbances import Disturbances
from ..analysis.specification import Move, Tracking
from ..plant import Ramp, SampledTorque, Sine, Spectrum, TorqueSine, TorqueSteps, Wind
from ..shaping import (
    CommandFollower,
    Limits,
    Trajectory,
    follow_commands,
    scan_move,
    tracking_transfer,
)
from .counted_units import counted_factor
from .scenario import Scenario
from .scenario_asked import (
    ActingFileSection,
    ActingSection,
    ActingSineSection,
    EncoderSpectrumSection,
    FileSection,
    TorqueFileSection,
    TorqueSineSection,
    TorqueSpectrumSection,
    TorqueStepSection,
    TrackingSection,
    WindSection,
)
from .scenario_kinds import SIDEREAL, density_kind
from .units import factor

FOLLOWED = 3
"""Up to this order a follower keeps bounds itself; those above are kept by averages or lags."""


def survey_conditions(scenario: Scenario) -> dict[str, Any]:
    """Return what `survey` takes of a scenario besides loop and moves, by its keywords."""
    given = scenario.disturbances
    return {
        "wind": _with_spectrum(wind_of(given.wind), scenario, "torque_spectrum"),
        "encoder_noise": _with_spectrum(given.encoder_noise, scenario, "encoder_spectrum"),
        "torque_step": None if given.torque_step is None else _steps(given.torque_step),
        "tracking": tracking_of(scenario),
        "requirements": scenario.requirements,
    }


def moves_of(scenario: Scenario) -> tuple[Move, ...]:
    """Return the moves with what acts on the axis meanwhile."""
    return tuple(
        replace(move, disturbances=_acting(scenario.disturbed[move.name], scenario, move.name))
        if move.name in scenario.disturbed
        else move
        for move in scenario.moves
    )


def _acting(section: ActingSection, scenario: Scenario, name: str) -> Disturbances:
    """Return what acts during the move, or the tracking, of a name."""
    try:
        torques = [
            None if section.torque_step is None else _steps(section.torque_step),
            None if section.torque_sine is None else _sine(section.torque_sine),
            None if section.torque_file is None else _recorded(section.torque_file, scenario),
            wind_of(section.wind),
            None
            if section.torque_spectrum is None
            else _spectrum(section.torque_spectrum, scenario),
        ]
        noise: list[float | Spectrum] = [section.encoder_noise] if section.encoder_noise else []
        if section.encoder_spectrum is not None:
            noise.append(_spectrum(section.encoder_spectrum, scenario))
        kept = tuple(torque for torque in torques if torque is not None)
        return Disturbances(kept, tuple(noise), section.seed)
    except ValueError as error:
        told = str(error).replace("frequencies_hz", "frequencies")
        raise ValueError(f"{scenario.path}: disturbances of {name!r}: {told}") from None


def wind_of(wind: WindSection | None) -> Wind | None:
    """Return a wind, if there is one."""
    if wind is None:
        return None
    over = None if wind.length is None or wind.speed is None else wind.length / wind.speed
    return Wind(wind.kind, wind.sigma, corner_hz=wind.corner, length_over_speed=over, on=wind.on)


def _steps(step: TorqueStepSection) -> TorqueSteps:
    return TorqueSteps(np.array([step.time]), np.array([step.torque]), on=step.on)


def _sine(sine: ActingSineSection) -> TorqueSine:
    return TorqueSine(sine.amplitude, sine.frequency, on=sine.on)


def _recorded(file: ActingFileSection, scenario: Scenario) -> SampledTorque:
    unit = file.unit or ("N m" if scenario.motion == "angle" else "N")
    times, values = _columns(file.path, file.time, file.torque, scenario)
    return SampledTorque(times, factor(unit) * values, on=file.on)


def _with_spectrum(other: Any, scenario: Scenario, key: str) -> Any:
    """Return another source, with the spectrum of a key of the disturbances if there is one."""
    section: TorqueSpectrumSection | EncoderSpectrumSection | None
    section = getattr(scenario.disturbances, key)
    if section is None:
        return other
    try:
        return other, _spectrum(section, scenario)
    except ValueError as error:
        told = str(error).replace("frequencies_hz", "frequencies")
        raise ValueError(f"{scenario.path}: disturbances.{key}: {told}") from None


def _spectrum(
    section: TorqueSpectrumSection | EncoderSpectrumSection, scenario: Scenario
) -> Spectrum:
    of_torque = isinstance(section, TorqueSpectrumSection)
    on: Any = section.on if isinstance(section, TorqueSpectrumSection) else "load"
    if section.path is None:
        return Spectrum(np.array(section.frequencies), np.array(section.densities), on=on)
    columns = section.frequency, section.density
    frequencies, densities = _columns(section.path, *columns, scenario)
    kind = density_kind("torque" if of_torque else "position", scenario.motion)
    usual = kind.unit if of_torque else f"{scenario.position_unit}^2/Hz"
    scale = counted_factor(section.unit or usual, scenario.counted) / factor(kind.unit)
    return Spectrum(frequencies, scale * densities, on=on)


def tracking_of(scenario: Scenario) -> tuple[Tracking, ...]:
    """Return the commands and the torques that go on."""
    disturbances = scenario.disturbances
    held = (disturbances.torque_sine, disturbances.torque_file)
    return (
        *(_tracking(each, scenario) for each in scenario.tracking),
        *(_holding(each, scenario) for each in held if each is not None),
    )


def _holding(section: TorqueSineSection | TorqueFileSection, scenario: Scenario) -> Tracking:
    """Return what it is to stand still against a torque that goes on."""
    torque: TorqueSine | SampledTorque
    try:
        if isinstance(section, TorqueSineSection):
            torque, duration = _sine(section), section.duration
        else:
            torque = _recorded(section, scenario)
            duration = section.duration or float(torque.times[-1])
        assert duration is not None  # the section's own check
        return Tracking(section.name, Ramp(0.0), duration, section.after, torque)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: disturbances: {section.name}: {error}") from None


def _tracking(section: TrackingSection, scenario: Scenario) -> Tracking:
    try:
        command, duration = _command(section, scenario), section.duration
        if isinstance(command, Trajectory):
            duration = duration or command.duration
        assert duration is not None  # the section's own check
        acting = None
        if section.disturbances is not None:
            acting = _acting(section.disturbances, scenario, section.name)
        return Tracking(section.name, command, duration, section.after, acting)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: tracking {section.name!r}: {error}") from None


def _command(section: TrackingSection, scenario: Scenario) -> Any:
    if section.scan is not None:
        scan, limits = section.scan, _limits(section.scan.limits, scenario)
        return scan_move(scan.length, scan.rate, limits, lines=scan.lines).trajectory
    if section.file is not None:
        return _followed(section.file, scenario)
    rate, sine = SIDEREAL if isinstance(section.rate, str) else section.rate, section.sine
    if section.onto is not None and rate is not None:
        target = (section.onto.distance, rate)
        return tracking_transfer(0.0, target, _limits(section.onto.limits, scenario)).trajectory
    parts: list[Any] = []
    if rate is not None:
        parts.append(Ramp(rate))
    if sine is not None:
        parts.append(Sine(sine.amplitude, sine.frequency))
    return parts[0] if len(parts) == 1 else parts[0] + parts[1]


def _limits(name: str, scenario: Scenario) -> Limits:
    return Limits.from_bounds(scenario.limit_sets[name])


def _followed(file: FileSection, scenario: Scenario) -> Trajectory:
    """Return what a follower makes of the positions in a file beside the scenario."""
    times, positions = _columns(file.path, file.time, file.position, scenario)
    scale = counted_factor(file.unit or scenario.position_unit, scenario.counted)
    bounds = scenario.limit_sets[file.limits]
    follower = CommandFollower(Limits.from_bounds(bounds[:FOLLOWED]), dt=file.sample_time)
    within = _limits(file.limits, scenario) if len(bounds) > FOLLOWED else None
    return follow_commands(follower, times, scale * positions, within=within)


def _columns(name: str, time: str, value: str, scenario: Scenario) -> tuple[Any, Any]:
    """Return two columns of a CSV file beside the scenario."""
    from ..analysis import read_log

    path = scenario.path.parent / name
    try:
        return read_log(path, _column(time), _column(value))
    except OSError as error:
        raise ValueError(
            f"file {path}: {error.strerror or error}; name a CSV file, from this file's folder on"
        ) from None


def _column(name: str) -> int | str:
    """Return a column's name, or its number from 0 on."""
    return int(name) if name.isdecimal() else name
