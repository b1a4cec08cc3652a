"""Surveys against transfer functions and differential equations written out by hand."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import control
import numpy as np
import pytest
from references import thompson_order_3
from scipy.integrate import solve_ivp

from jounce.analysis import UnstableLoopError
from jounce.app import load_scenario, survey_file
from jounce.plant import LoopResponse

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600
OMEGA_C = 2 * math.pi

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
ANGULAR = """
[plant]
inertia = "1 kg m^2"
[controller]
GAINS
[limits.axis]
acceleration = "0.2 deg/s^2"
[[moves]]
name = "go"
distance = "60 arcsec"
settle_to = "50 mas"
"""
WITH_FILTER = '[filter]\ncorner = "2 Hz"\norder = 6\n'
NAMES = ("without feedforward", "with feedforward", "Ĵ +10 %", "Ĵ -10 %")
ASSUMED = dict(zip(NAMES, (0.0, 1.0, 1.1, 0.9), strict=True))

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write_text(text: str) -> Path:
        path = tmp_path / "case.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write_text


@pytest.fixture(scope="module")
def telescope():
    return survey_file(EXAMPLES / "telescope.toml")


@pytest.fixture(scope="module")
def rubin():
    return survey_file(EXAMPLES / "rubin_mount.toml")


@pytest.fixture(scope="module")
def published():
    return survey_file(EXAMPLES / "telescope_published_gains.toml")


def angular(gains: str) -> str:
    return ANGULAR.replace("GAINS", gains)


def gains_table(kp: float, ki: float, kr: float) -> str:
    return f'gains = {{kp = "{kp!r} N m/rad", ki = "{ki!r} N m/(rad s)", kr = "{kr!r} N m s/rad"}}'


def design(margin: str) -> str:
    return (
        'gains = "design"\nspecification = {crossover = "1 Hz", phase_margin = "45 deg", '
        f'lower_gain_margin = "{margin}"}}'
    )


def designed(gain_margin: float) -> tuple[float, float, float]:
    """Return kp, ki, kr of a unit inertia for 1 Hz and 45°: Theory, Section 7."""
    kp = OMEGA_C**2 * math.cos(math.pi / 4)
    q = kp / gain_margin
    kr = OMEGA_C**3 * math.sin(math.pi / 4) / (OMEGA_C**2 - q)
    return kp, kr * q, kr


def step_of(kp: float, ki: float, kr: float, time: np.ndarray) -> np.ndarray:
    """Return the unit step response of a PID around a unit inertia."""
    closed = control.tf([kr, kp, ki], [1.0, kr, kp, ki])
    return np.asarray(control.step_response(closed, time).outputs)


def simulated(
    response: LoopResponse, gains, j_hat: float, switches, levels, *, corner_hz: float | None
) -> dict[str, np.ndarray]:
    """Integrate the loop around a unit inertia, at the response's own times.

    It is driven by a piecewise-constant acceleration or jerk, through six first-order lags.
    """
    kp, ki, kr = gains
    lags, omega = (6, 2 * math.pi * corner_hz) if corner_hz else (0, 0.0)
    order = 2 if len(levels) == 2 else 3

    def command(x: np.ndarray, u: float):
        if not lags:
            return x[0], x[1], x[2] if order == 3 else u
        *_, q4, q5, q6 = x[order : order + lags]
        return q6, omega * (q5 - q6), omega**2 * (q4 - 2 * q5 + q6)

    def torque(x, u):
        r, v, a = command(x, u)
        y, w, z = x[-3:]
        return kp * (r - y) + ki * z + kr * (v - w) + j_hat * a

    def slope(_, x, u):
        chain = np.concatenate([[x[0]], x[order : order + lags]])
        return np.concatenate(
            [
                [*x[1:order], u],
                omega * (chain[:-1] - chain[1:]),
                [x[-2], torque(x, u), command(x, u)[0] - x[-3]],
            ]
        )

    time = response.time
    x, rows = np.zeros(order + lags + 3), []
    for (left, right), u in zip(
        pairwise([*switches, time[-1] + 1e-9]), [*levels, 0.0], strict=True
    ):
        inside = time[(time >= left) & (time < right)]
        run = solve_ivp(
            slope,
            (left, right),
            x,
            method="DOP853",
            t_eval=[*inside, right],
            args=(u,),
            rtol=1e-11,
            atol=1e-16,
        )
        x = run.y[:, -1]
        for state in run.y[:, :-1].T:
            rows.append([command(state, u)[0], state[-3], torque(state, u)])
    r, y, u = np.array(rows).T
    return {"command": r, "position": y, "error": r - y, "torque": u}


def settled_at(time, position, target: float, tolerance: float) -> float:
    """Return when a curve enters the tolerance for good, on the cubic through four samples."""
    excess = np.abs(position - target) - tolerance
    k = int(np.flatnonzero(excess > 0)[-1])
    near = slice(k - 1, k + 3)
    cubic = np.polynomial.Polynomial.fit(time[near], excess[near], 3)
    return float(min((r.real for r in cubic.roots()), key=lambda t: abs(t - time[k])))


def test_the_telescope_meets_its_specification(telescope):
    margins = telescope.margins
    assert margins.crossover_hz == pytest.approx(1.0, rel=1e-10)
    assert margins.phase_margin_deg == pytest.approx(45.0, rel=1e-10)
    assert margins.lower_gain_margin_db == pytest.approx(12.0, rel=1e-10)
    assert math.isinf(margins.upper_gain_margin_db)
    assert (margins.modulus_margin, margins.modulus_margin_hz) == pytest.approx(
        (0.75645, 0.9102), rel=1e-4
    )
    assert [check.met for check in telescope.checks] == [True] * 3
    assert telescope.findings == ()
    controller = telescope.loop.controller
    gains = (controller.kp, controller.ki, controller.kr)
    assert gains == pytest.approx(designed(10 ** (12 / 20)), rel=1e-12)


@pytest.mark.parametrize("name", ["telescope", "published"])
def test_step_agrees_with_a_transfer_function_written_out(name, request):
    found = request.getfixturevalue(name)
    kr = 11.09
    published = (3.187 * kr, 6.286 * kr, kr)
    gains = designed(10 ** (12 / 20)) if name == "telescope" else published
    time = np.linspace(0.0, 8.0, 20_001)
    position = step_of(*gains, time)
    step = found.step
    assert step.overshoot_percent == pytest.approx(100 * (position.max() - 1), abs=1e-4)
    assert step.peak_time_s == pytest.approx(time[position.argmax()], abs=4e-4)
    reach = [time[np.argmax(position >= level)] for level in (0.1, 0.9)]
    assert step.rise_time_s == pytest.approx(reach[1] - reach[0], abs=1e-3)
    last_outside = time[np.flatnonzero(np.abs(position - 1) > 0.02)[-1]]
    assert step.settling_time_s == pytest.approx(last_outside, abs=2e-3)
    assert step.overshoot_percent == pytest.approx(39.85 if name == "telescope" else 21.5, abs=0.05)
    np.testing.assert_allclose(step.position, step_of(*gains, step.time), atol=1e-10)


def test_the_published_gains_miss_and_the_survey_says_so(published):
    margins = published.margins
    assert margins.crossover_hz == pytest.approx(1.750, abs=5e-4)
    assert margins.phase_margin_deg == pytest.approx(73.0, abs=0.05)
    assert margins.lower_gain_margin_db == pytest.approx(15.0, abs=0.05)
    assert margins.modulus_margin == pytest.approx(1.0)
    assert [check.met for check in published.checks] == [False] * 3
    (finding,) = published.findings
    for fact in ("miss", "1.750 Hz", "asked 1)", "73.0 deg", "15.0 dB", "21.5 %", "40 %", "design"):
        assert fact in finding


def test_durations_of_bang_bang_moves(telescope):
    for move, distance in zip(telescope.moves, (60.0, 3600.0), strict=True):
        expected = 2.0 * math.sqrt(distance / 3600 / 0.2)
        assert move.duration_s == pytest.approx(expected, rel=1e-14)
        assert tuple(move.responses) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_responses_of_the_telescope_agree_with_the_differential_equations(telescope, name):
    acceleration = 0.2 * DEGREE
    for move in telescope.moves:
        distance = move.move.distance
        half = math.sqrt(distance / acceleration)
        result = move.responses[name]
        expected = simulated(
            result.response,
            designed(10 ** (12 / 20)),
            ASSUMED[name],
            (0.0, half, 2 * half),
            (acceleration, -acceleration),
            corner_hz=2.0,
        )
        for key in ("command", "position", "error"):
            np.testing.assert_allclose(
                getattr(result.response, key), expected[key], rtol=0, atol=1e-9 * distance
            )
        np.testing.assert_allclose(
            result.response.torque, expected["torque"], rtol=0, atol=1e-7 * acceleration
        )
        assert result.peak_torque == pytest.approx(np.abs(expected["torque"]).max(), rel=1e-6)
        assert result.peak_error == pytest.approx(
            np.abs(expected["error"]).max(), rel=1e-6, abs=1e-9 * distance
        )
        assert result.settling_time_s == pytest.approx(
            settled_at(result.response.time, expected["position"], distance, 0.05 * ARCSEC),
            abs=1e-5,
        )


def test_with_the_right_inertia_the_position_is_the_filtered_command(telescope, published):
    for found in (telescope, published):
        for move in found.moves:
            response = move.configured.response
            np.testing.assert_allclose(
                response.position, response.command, rtol=0, atol=1e-9 * move.move.distance
            )
            assert move.configured.overshoot <= 1e-9 * move.move.distance


@pytest.mark.parametrize("name", NAMES)
def test_responses_of_the_rubin_mount_agree_with_the_differential_equations(rubin, name):
    for move, speed in zip(rubin.moves, (10.5, 5.25), strict=True):
        reference = thompson_order_3(3.5, speed, speed, 4 * speed)
        jerk = 4 * speed * DEGREE
        assert len(reference.switches) == 6
        result = move.responses[name]
        expected = simulated(
            result.response,
            designed(10 ** (12 / 20)),
            ASSUMED[name],
            reference.switches,
            (jerk, 0.0, -jerk, 0.0, jerk),
            corner_hz=None,
        )
        for key in ("command", "position", "error"):
            np.testing.assert_allclose(
                getattr(result.response, key), expected[key], rtol=0, atol=1e-9 * 3.5 * DEGREE
            )
        assert result.settling_time_s == pytest.approx(
            settled_at(result.response.time, expected["position"], 3.5 * DEGREE, ARCSEC), abs=1e-4
        )


def test_durations_of_the_rubin_mount(rubin):
    azimuth, elevation = rubin.moves
    assert azimuth.duration_s == pytest.approx(1.4314539066, abs=5e-11)
    assert elevation.duration_s == pytest.approx(1.9020189668, abs=5e-11)
    assert rubin.jerk_filter is None


def test_a_wrong_inertia_costs_its_share_of_the_whole_error(telescope, rubin):
    """The error is proportional to J − Ĵ, and so mirrored for Ĵ off to either side."""
    for move in (*telescope.moves, *rubin.moves):
        plain, _, more, less = (move.responses[name].response.error for name in NAMES)
        scale = 1e-9 * abs(move.move.distance)
        np.testing.assert_allclose(less, 0.1 * plain, rtol=0, atol=scale)
        np.testing.assert_allclose(more, -0.1 * plain, rtol=0, atol=scale)


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
