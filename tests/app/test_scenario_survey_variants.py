"""Surveys of other axes: linear, heavier, backwards, unstable, slow; and what is refused."""

import math
import re
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
from scenario_texts import ARCSEC, DEGREE, NAMES, angular, design, designed, step_of

from jounce.analysis import UnstableLoopError
from jounce.app import load_scenario, survey_file

EXAMPLES = Path(__file__).parents[2] / "examples"
LINEAR = """
title = "Stage"
position_unit = "mm"
[plant]
inertia = "5 kg"
[controller]
gains = {kp = "0.2 N/mm", ki = "50 N/(m s)", kr = "40 N s/m"}
[limits.axis]
acceleration = "200 mm/s^2"
[[moves]]
name = "go"
distance = "20 mm"
settle_to = "1 um"
"""
WITH_FILTER = '[filter]\ncorner = "2 Hz"\norder = 6\n'


def gains_table(kp: float, ki: float, kr: float) -> str:
    return f'gains = {{kp = "{kp!r} N m/rad", ki = "{ki!r} N m/(rad s)", kr = "{kr!r} N m s/rad"}}'


def test_a_bound_of_zero_on_one_side_is_one_way(write):
    one_way = 'velocity = ["0 mm/s", "50 mm/s"]\nacceleration'
    scenario = load_scenario(write(LINEAR.replace("acceleration", one_way, 1)))
    assert scenario.moves[0].bounds == ((0.0, pytest.approx(0.05)), pytest.approx(0.2))
    with pytest.raises(ValueError, match=r"is not a pair around zero; .* lower ≤ 0 ≤ upper"):
        load_scenario(write(LINEAR.replace("acceleration", one_way.replace("50", "0"), 1)))


def test_a_linear_axis(write):
    found = survey_file(write(LINEAR))
    closed = np.roots([5.0, 40.0, 200.0, 50.0])
    assert np.sort_complex(found.margins.closed_loop_poles) == pytest.approx(
        np.sort_complex(closed)
    )
    (move,) = found.moves
    assert move.duration_s == pytest.approx(2 * math.sqrt(0.020 / 0.2), rel=1e-14)
    assert move.configured.peak_torque == pytest.approx(5.0 * 0.2, rel=1e-12)
    assert move.configured.peak_error <= 1e-12 * 0.02
    assert found.checks == ()
    assert found.findings == ()
    time = found.step.time
    position = control.step_response(control.tf([40, 200, 50], [5, 40, 200, 50]), time).outputs
    np.testing.assert_allclose(found.step.position, position, atol=1e-10)


def test_a_heavier_plant_takes_more_torque_and_moves_alike(write):
    light = survey_file(write(angular(design("12 dB"))))
    heavy = survey_file(write(angular(design("12 dB")).replace("1 kg m^2", "3000 kg m^2")))
    for name in NAMES:
        one, other = (found.moves[0].responses[name] for found in (light, heavy))
        assert other.settling_time_s == pytest.approx(one.settling_time_s, rel=1e-9)
        np.testing.assert_allclose(other.response.torque, 3000 * one.response.torque, atol=1e-8)


def test_backwards_is_the_mirror_image(write):
    text = angular(design("12 dB")) + WITH_FILTER
    forth = survey_file(write(text)).moves[0]
    back = survey_file(write(text.replace('"60 arcsec"', '"-60 arcsec"'))).moves[0]
    assert back.duration_s == forth.duration_s
    for name in NAMES:
        one, other = forth.responses[name], back.responses[name]
        np.testing.assert_allclose(
            other.response.position, -one.response.position, atol=1e-12 * 60 * ARCSEC
        )
        assert other.overshoot == pytest.approx(one.overshoot, abs=1e-12 * 60 * ARCSEC)
        assert other.settling_time_s == pytest.approx(one.settling_time_s)
        assert other.peak_torque == pytest.approx(one.peak_torque)


def test_limits_of_their_own_for_each_direction(write):
    pair = '["-0.1 deg/s^2", "0.2 deg/s^2"]'
    found = survey_file(write(angular(design("12 dB")).replace('"0.2 deg/s^2"', pair)))
    distance = 60 / 3600
    assert found.moves[0].duration_s == pytest.approx(
        math.sqrt(2 * distance * (1 / 0.1 + 1 / 0.2)), rel=1e-13
    )


@pytest.mark.parametrize("gains", [(28.0, 38.0, 1.0), (28.0, 0.0, 0.0), (28.0, 2.0, 0.0)])
def test_an_unstable_loop_names_its_pole(write, gains):
    kp, ki, kr = gains
    with pytest.raises(UnstableLoopError, match="UNSTABLE") as refusal:
        survey_file(write(angular(gains_table(kp, ki, kr))))
    named = re.search(r"pole at (\S+) rad/s", str(refusal.value))
    assert named
    worst = max(np.roots([1.0, kr, kp, ki]), key=lambda pole: pole.real)
    pole = complex(named[1])
    assert pole.real == pytest.approx(worst.real, rel=1e-3, abs=1e-9)
    assert abs(pole.imag) == pytest.approx(abs(worst.imag), rel=1e-3)
    assert "case.toml" in str(refusal.value)


def test_without_integral_action_there_is_no_lower_gain_margin(write):
    found = survey_file(write(angular(gains_table(28.0, 0.0, 5.0))))
    margins = found.margins
    assert margins.stable
    assert not math.isfinite(margins.lower_gain_margin_db)
    assert not math.isfinite(margins.upper_gain_margin_db)
    time = np.linspace(0.0, 4.0, 10_001)
    closed = control.tf([5.0, 28.0], [1.0, 5.0, 28.0])
    position = control.step_response(closed, time).outputs
    assert found.step.overshoot_percent == pytest.approx(100 * (position.max() - 1), abs=1e-4)
    assert found.moves[0].configured.peak_error <= 1e-12 * 60 * ARCSEC


@pytest.mark.parametrize("decibels", [40.0, 90.0])
def test_a_slow_integrator_does_not_hide_the_step(write, decibels):
    """A large gain margin means a slow pole; the fast part of the response stays what it is."""
    found = survey_file(write(angular(design(f"{decibels} dB"))))
    time = np.linspace(0.0, 4.0, 8_001)
    position = step_of(*designed(10 ** (decibels / 20)), time)
    step = found.step
    assert step.overshoot_percent == pytest.approx(100 * (position.max() - 1), abs=0.01)
    assert step.peak_time_s == pytest.approx(time[position.argmax()], abs=0.01)
    reach = [time[np.argmax(position >= level)] for level in (0.1, 0.9)]
    assert step.rise_time_s == pytest.approx(reach[1] - reach[0], abs=0.005)


@pytest.mark.parametrize("decibels", [12.0, 40.0, 90.0])
def test_a_slow_integrator_does_not_hide_the_move(write, decibels):
    found = survey_file(write(angular(design(f"{decibels} dB"))))
    (move,) = found.moves
    kp, ki, kr = designed(10 ** (decibels / 20))
    # The error of the loop without feedforward is s/(s³ + kr s² + kp s + ki) of the acceleration.
    time = np.linspace(0.0, 4.0, 8_001)
    half = math.sqrt(60 * ARCSEC / (0.2 * DEGREE))
    unit = np.asarray(control.step_response(control.tf([1, 0], [1, kr, kp, ki]), time).outputs)
    error = 0.2 * DEGREE * (
        unit - 2 * np.interp(time - half, time, unit, left=0)
        + np.interp(time - 2 * half, time, unit, left=0)
    )  # fmt: skip
    plain = move.responses["without feedforward"]
    assert plain.peak_error == pytest.approx(np.abs(error).max(), rel=1e-3)
    tolerance = 0.05 * ARCSEC
    assert move.configured.settling_time_s == pytest.approx(
        2 * half - math.sqrt(2 * tolerance / (0.2 * DEGREE)), abs=1e-3
    )


@pytest.mark.parametrize("degrees", [1, 360])
def test_a_long_cruise_does_not_hide_the_peaks(write, degrees):
    limits = 'acceleration = "0.2 deg/s^2"\nvelocity = "0.1 deg/s"'
    text = angular(design("12 dB")).replace('acceleration = "0.2 deg/s^2"', limits)
    (move,) = survey_file(write(text.replace('"60 arcsec"', f'"{degrees} deg"'))).moves
    assert move.duration_s == pytest.approx(0.5 + degrees / 0.1, rel=1e-13)
    kp, ki, kr = designed(10 ** (12 / 20))
    time = np.linspace(0.0, 4.0, 8_001)
    unit = np.asarray(control.step_response(control.tf([1, 0], [1, kr, kp, ki]), time).outputs)
    ramp = 0.2 * DEGREE * (unit - np.interp(time - 0.5, time, unit, left=0))
    plain = move.responses["without feedforward"]
    assert plain.peak_error == pytest.approx(np.abs(ramp).max(), rel=1e-3)


def test_a_velocity_limit_alone_is_refused(write):
    text = angular(design("12 dB")).replace('acceleration = "0.2 deg/s^2"', 'velocity = "1 deg/s"')
    with pytest.raises(ValueError, match="acceleration"):
        survey_file(write(text))


def test_a_scenario_object_serves_as_well_as_its_file(telescope):
    scenario = load_scenario(EXAMPLES / "telescope.toml")
    assert survey_file(scenario).margins.as_dict() == telescope.margins.as_dict()
    assert survey_file(str(EXAMPLES / "telescope.toml")).step.overshoot_percent == (
        telescope.step.overshoot_percent
    )


def test_missing_a_specification_with_gains_of_ones_own(write):
    _, specification = design("9 dB").split("\n")
    gains = gains_table(*designed(10 ** (12 / 20)))
    found = survey_file(write(angular(f"{gains}\n{specification}")))
    assert [check.met for check in found.checks] == [True, True, False]
    (finding,) = found.findings
    assert "12.0 dB" in finding
    assert "asked 9" in finding
    assert "Thompson" not in finding


def test_an_error_of_the_assumed_inertia_of_ones_own():
    scenario = replace(load_scenario(EXAMPLES / "telescope.toml"), inertia_error=0.025)
    move = survey_file(scenario).moves[0]
    assert tuple(move.responses)[2:] == ("Ĵ +2.5 %", "Ĵ -2.5 %")
    plain = move.responses["without feedforward"].peak_error
    assert move.responses["Ĵ -2.5 %"].peak_error == pytest.approx(0.025 * plain, rel=1e-9)


def test_results_cannot_be_changed(telescope):
    with pytest.raises(AttributeError):
        telescope.margins = None
    with pytest.raises(TypeError):
        telescope.moves[0].responses["new"] = None
