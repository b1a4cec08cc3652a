"""The examples of real axes: each loads, makes a stable loop, and its moves settle."""

import math
import os
import tomllib
from pathlib import Path

import numpy as np
import pytest

from jounce.analysis import loop_margins
from jounce.analysis.surveyed_moves import planned
from jounce.app import load_scenario, survey_file
from jounce.app.scenario_commands import survey_conditions
from jounce.app.scenario_loop import servo_loop_of
from jounce.app.scenario_schema import scenario_schema
from jounce.plant import Axis, CascadedPI, Controller, FlexibleMode, Notch, Ramp
from jounce.shaping import Limits, input_shaper, min_time_move

EXAMPLES = Path(__file__).parents[2] / "examples"
# What lies beside a scenario (.check, .sweep) has a dot in its stem.
SCENARIOS = sorted(path.stem for path in EXAMPLES.glob("*.toml") if "." not in path.stem)
REAL = sorted(p.stem for p in EXAMPLES.glob("*.toml") if "\nformat = 2\n" in p.read_text())
SLOW = os.environ.get("JOUNCE_TIER") == "slow"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600


def scenario_of(name):
    return load_scenario(EXAMPLES / f"{name}.toml")


def test_there_are_five():
    assert REAL == ["gantry_crane", "lift", "servo_drive", "telescope_azimuth", "wafer_stage"]


@pytest.mark.parametrize("name", REAL)
def test_its_loop_is_stable_and_its_moves_settle_within_the_torque_limit(name):
    scenario = scenario_of(name)
    loop = servo_loop_of(scenario)
    assert loop_margins(loop.loop_transfer()).stable
    for move in scenario.moves:
        command = planned(move)
        long = 3.0 * command.duration
        response = loop.respond(command, long / 500, duration=long)
        settled = response.settling_time(move.distance, move.settle_to, of="load")
        assert 0.5 * command.duration < settled < 2.0 * command.duration
        assert 0.0 < np.abs(response.torque).max() < loop.axis.torque_limit
        assert response.saturated_time == 0.0


@pytest.mark.parametrize("name", SCENARIOS)
def test_its_file_is_right_by_the_schema(name):
    from jsonschema import Draft202012Validator  # which takes seconds to load

    content = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))
    schema = Draft202012Validator(scenario_schema(content.get("format", 1)))
    assert [error.message for error in schema.iter_errors(content)] == []


@pytest.mark.parametrize("name", REAL if SLOW else ["servo_drive", "telescope_azimuth"])
def test_its_survey_meets_what_the_file_requires(name):
    found = survey_file(scenario_of(name))
    assert len(found.requirements) == len(found.scenario.requirements)
    assert [check for check in found.requirements if not check.met] == []
    assert found.findings == ()
    for move in found.moves:
        assert move.configured.load_settling_time_s < 2.0 * move.duration_s
    assert len(found.tracking) == len(found.scenario.tracking)


def test_a_move_that_is_rounded_lasts_whole_samples():
    for move in scenario_of("wafer_stage").moves:
        samples = planned(move).duration / 50e-6
        assert samples == pytest.approx(round(samples), abs=1e-9)


def test_the_telescope_is_as_its_file_says():
    scenario = scenario_of("telescope_azimuth")
    loop = servo_loop_of(scenario)
    mode = FlexibleMode(6.0, 0.01, load_fraction=0.5, held=True)
    assert loop.plant == Axis(
        1000.0, modes=[mode], viscous=20.0, torque_limit=300.0, encoder_step=loop.plant.encoder_step
    )
    assert loop.plant.encoder_step == pytest.approx(1e-3 * ARCSEC, rel=1e-15)
    controller = loop.controller
    assert (controller.sample_time, controller.delay) == (1e-3, 1.5e-3)
    assert controller.filters == (Notch(8.5, zero_damping=0.1, pole_damping=0.6),)
    margins = loop_margins(loop.loop_transfer())
    assert margins.crossover_hz == pytest.approx(1.0, rel=1e-9)
    assert margins.phase_margin_deg == pytest.approx(45.0, rel=1e-9)
    assert loop.feedforward.lead == pytest.approx(2e-3)
    omega_held = 2.0 * math.pi * 6.0
    # undamped: y_motor = r + r″/ω_held², torque J·r″ + J/ω_free²·r⁗, ω_free² = 2·ω_held²
    assert loop.feedforward.position[2] == pytest.approx(omega_held**-2, rel=1e-3)
    assert loop.feedforward.torque[4] == pytest.approx(1000.0 / (2.0 * omega_held**2), rel=1e-3)


def test_the_telescope_tracks_the_stars_in_wind():
    given = survey_conditions(scenario_of("telescope_azimuth"))
    (tracking,) = given["tracking"]
    assert tracking.command == Ramp(tracking.command.rate)
    assert tracking.command.rate == pytest.approx(2.0 * math.pi / 86164.098903691, rel=1e-9)
    assert given["wind"].length_over_speed == 8.0
    assert given["torque_step"].on == "load"
    assert given["encoder_noise"] == pytest.approx(1e-3 * ARCSEC)
    assert {r.name for r in given["requirements"]} == {
        "load_settling", "phase_margin", "peak_torque",
    }  # fmt: skip


def test_snap_feedforward_settles_the_telescope_in_half_the_time():
    name = EXAMPLES / "telescope_azimuth.toml"
    settled = []
    for given in ({}, {"feedforward.inverse": False}):
        scenario = load_scenario(name, overrides=given)
        (move,) = scenario.moves
        command = min_time_move(move.distance, Limits.from_bounds(move.bounds))
        response = servo_loop_of(scenario).respond(command, 0.02, duration=12.0)
        settled.append(response.settling_time(move.distance, move.settle_to, of="load"))
    assert 2.0 * settled[0] < settled[1]


def test_the_crane_does_not_swing():
    """ZV of the pendulum against the plain move."""
    scenario = scenario_of("gantry_crane")
    ship, inch = scenario.moves
    expected = [input_shaper(kind, 0.3, 0.005) for kind in ("ZV", "ZVD")]
    for move, shaper in zip((ship, inch), expected, strict=True):
        (given,) = move.shapers
        np.testing.assert_allclose(given.times, shaper.times, rtol=1e-14)
        np.testing.assert_allclose(given.amplitudes, shaper.amplitudes, rtol=1e-14)
    loop = servo_loop_of(scenario)
    plain = min_time_move(ship.distance, Limits.from_bounds(ship.bounds))
    swing = []
    for command in (plain, ship.shapers[0].shape(plain)):
        response = loop.respond(command, 0.05, duration=40.0)
        after = response.time > command.duration
        swing.append(np.abs(response.load_error[after]).max())
    assert swing[1] < 0.1 * swing[0]


def test_the_drive_is_a_cascade_with_friction_and_counts():
    scenario = scenario_of("servo_drive")
    loop = servo_loop_of(scenario)
    assert loop.controller.law == CascadedPI(30.0, 0.8, 0.02)
    assert loop.plant.friction.static == 0.4
    assert loop.plant.torque_limit == pytest.approx(12 * 0.8)
    count = 2.0 * math.pi / 2**20
    assert loop.plant.encoder_step == pytest.approx(count, rel=1e-14)
    assert scenario.moves[0].settle_to == pytest.approx(30 * count, rel=1e-14)


def test_the_lift_is_loaded_and_starts_more_gently_than_it_stops():
    scenario = scenario_of("lift")
    loop = servo_loop_of(scenario)
    assert loop.plant.constant_load == -4000.0
    assert isinstance(loop.controller, Controller)
    assert scenario.moves[0].bounds[1] == (-1.0, 0.7)
    still = loop.respond(Ramp(0.0), 0.1, duration=5.0)
    assert still.torque[-1] == pytest.approx(4000.0, rel=1e-6)


def test_the_stage_tells_its_current_and_keeps_its_peaks():
    loop = servo_loop_of(scenario_of("wafer_stage"))
    margins = loop_margins(loop.loop_transfer())
    assert margins.sensitivity_peak == pytest.approx(1.6, rel=1e-4)
    assert margins.complementary_peak <= 1.6 * (1 + 1e-4)
    still = loop.respond(Ramp(0.0), 1e-3, duration=0.01)
    np.testing.assert_array_equal(still.current, still.motor_torque / 60.0)
