"""What is shown of a move: limits, binding pieces, residual vibration, order and shaper."""

import pytest
from explored import SCENARIO, session_of, told, written

from jounce.analysis import residual_vibration
from jounce.analysis.planned_moves import planned
from jounce.shaping import Limits, min_time_move


@pytest.fixture
def session(tmp_path):
    return session_of(written(tmp_path))


def shown(session, *messages, until="ready"):
    return told(session, {"kind": "view", "view": "move"}, *messages, until=until)


def test_the_move_is_the_fastest_within_its_limits(session):
    move = shown(session)["move"]
    exact = min_time_move(0.1, Limits(velocity=1.0, acceleration=20.0, jerk=1000.0))
    assert move["duration_s"] == exact.duration
    peaks = [each["peak"] for each in move["derivatives"]]
    assert peaks[1:] == pytest.approx([1e3 * exact.peak(k) for k in (1, 2, 3)])
    bounds = [each["high"] for each in move["derivatives"]]
    assert bounds == pytest.approx([None, 1e3, 2e4, 1e6])


def test_the_limits_that_bind_are_named_piece_by_piece(session):
    by = [piece["by"] for piece in shown(session)["move"]["binding"]]
    assert by == [[3], [2], [3], [1], [3], [2], [3]]


def test_what_the_modes_keep_ringing_is_that_of_the_analysis(session):
    move = shown(session)["move"]
    trajectory = planned(session.state.scenario.moves[0])
    left = float(residual_vibration(trajectory, 140.0, 0.01))
    [second] = [mode for mode in move["residual"] if mode["name"] == "second"]
    assert second["left"] == pytest.approx(1e3 * left)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_the_order_is_the_highest_limit_that_there_is(session, order):
    shown(session, {"kind": "set", "key": "order", "number": order})
    assert len(session.state.scenario.moves[0].bounds) == order


def test_the_order_may_fall_below_the_only_limit_there_is(tmp_path):
    from explored import SCENARIO

    alone = SCENARIO.replace('velocity = "1 rad/s"\nacceleration = "20 rad/s^2"\n', "")
    session = session_of(written(tmp_path, alone))
    before = planned(session.state.scenario.moves[0])
    shown(session, {"kind": "set", "key": "order", "number": 2})
    [velocity, acceleration] = session.state.scenario.moves[0].bounds
    assert velocity == float("inf")
    assert acceleration == pytest.approx(before.peak(2), rel=5e-3)


def test_an_input_shaper_nulls_the_lowest_mode(session):
    before = shown(session)["move"]
    after = shown(session, {"kind": "set", "key": "shaper", "word": "ZV"})["move"]
    first = [move["residual"][0]["left"] for move in (before, after)]
    assert first[1] < 1e-6 * first[0]
    assert after["duration_s"] > before["duration_s"]
    text = shown(session, until="proof")["proof"]["text"]
    assert "input shaper" in text
    back = shown(session, {"kind": "set", "key": "shaper", "word": "none"})["move"]
    assert back["duration_s"] == before["duration_s"]


def test_the_minimum_time_is_proven(session):
    proof = shown(session, until="proof")["proof"]
    assert proof["gap"] < 1e-9
    assert proof["text"].startswith("Proven: exactly the minimum time.")


def test_torque_stands_beside_its_limit(session):
    response = shown(session, until="response")["response"]
    assert response["torque_limit"] == 300.0
    figures = {name: value for name, value, _ in response["figures"]}
    assert 0.0 < figures["peak torque"] == pytest.approx(abs(response["torque"]).max(), rel=1e-3)
    share = figures["share of the torque limit"]
    assert share == pytest.approx(figures["peak torque"] / 3.0)


def test_what_is_required_of_the_move_stands_beside_what_it_does(tmp_path):
    asked = """
[requirements]
peak_torque = { max = "1 N m" }
duration = { max = "10 s" }
phase_margin = { min = "10 deg" }

[requirements.turn]
peak_error = { max = "1 rad" }
"""
    text = SCENARIO.partition("[requirements]")[0] + asked.lstrip()
    session = session_of(written(tmp_path, text))
    rows = told(session, {"kind": "view", "view": "move"}, until="response")["response"]["required"]
    met = {name: met for name, _, _, met in rows}
    assert met == {"peak torque": False, "duration": True, "peak error": True}
    assert rows[0][1] == "≤ 1 N m"
    assert float(rows[0][2].removesuffix(" N m")) > 1.0
