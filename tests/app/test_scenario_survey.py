"""Surveys against transfer functions and differential equations written out by hand."""

import math
from itertools import pairwise

import numpy as np
import pytest
from references import thompson_order_3
from scenario_texts import ARCSEC, DEGREE, NAMES, designed, step_of
from scipy.integrate import solve_ivp
from tiers import some

from jounce.plant import LoopResponse

ASSUMED = dict(zip(NAMES, (0.0, 1.0, 1.1, 0.9), strict=True))


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


@pytest.mark.parametrize("name", some(NAMES, 2))
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
