"""Messages to states: dragged handles, fields, filters, undo; numbers beside the gate's own."""

import re
import tomllib

import pytest
from explored import NOTCH, SCENARIO, problem_of, session_of, told, value_of, written

from jounce.analysis import loop_margins
from jounce.app import load_scenario
from jounce.app.explorer.handles import handles_of
from jounce.app.gate.check_file import Checks
from jounce.app.gate.comparison import measured_baseline
from jounce.app.gate.numbers import loop_numbers
from jounce.app.scenario_loop import servo_loop_of


@pytest.fixture
def path(tmp_path):
    return written(tmp_path)


@pytest.fixture
def session(path):
    return session_of(path)


@pytest.fixture(scope="module")
def refusing(tmp_path_factory):
    """Return one session for all messages that change nothing."""
    return session_of(written(tmp_path_factory.mktemp("refusing")))


def of_file(path, **overrides):
    """Return the margins that the gate would have of a file with other values."""
    return loop_margins(servo_loop_of(load_scenario(path, overrides=overrides)))


def drag(handle=NOTCH, gesture="a", **factors):
    return {"kind": "drag", "handle": handle, "gesture": gesture, "hz": 6.0, **factors}


def test_margins_are_those_of_the_file(session, path):
    shown = told(session, {"kind": "start"})
    exact = of_file(path)
    for row in shown["numbers"]["margins"]:
        assert row["value"] == getattr(exact, row["name"])
        assert row["verdict"] in ("unchecked", "within")
    assert shown["numbers"]["stable"] is True


def test_a_dragged_notch_has_the_margins_of_the_file_with_its_values(session, path):
    shown = told(session, drag(frequency=1.25, gain=0.5))
    values = {f"{NOTCH}.frequency": "90 Hz", f"{NOTCH}.zero_damping": "2.5 %"}
    exact = of_file(path, **values)
    assert value_of(shown, "phase_margin_deg") == exact.phase_margin_deg
    assert value_of(shown, "sensitivity_peak") == exact.sensitivity_peak


def test_a_gesture_is_relative_to_where_it_began_and_one_step_to_undo(session):
    before = session.state.content
    told(session, drag(frequency=2.0), drag(frequency=1.1), drag(frequency=1.25))
    assert session.state.content["controller"]["filters"][0]["frequency"] == "90 Hz"
    told(session, {"kind": "undo"})
    assert session.state.content == before
    told(session, {"kind": "redo"})
    assert session.state.content["controller"]["filters"][0]["frequency"] == "90 Hz"


def test_each_gesture_is_a_step_of_its_own(session):
    told(session, drag(frequency=1.25), drag(gesture="b", frequency=1.25), {"kind": "undo"})
    assert session.state.content["controller"]["filters"][0]["frequency"] == "90 Hz"


def test_a_change_after_undo_forgets_what_was_undone(session):
    shown = told(session, drag(frequency=1.25), {"kind": "undo"}, drag(gesture="b", gain=2.0))
    assert shown["status"]["undo"] is True
    assert shown["status"]["redo"] is False


def test_the_handle_of_the_gain_puts_the_crossover_where_it_is_dragged(session):
    first = told(session, {"kind": "start"})
    place = value_of(first, "crossover_hz")
    message = {"kind": "drag", "handle": "gain", "gesture": "g", "hz": place, "frequency": 1.3}
    moved = told(session, message)
    assert value_of(moved, "crossover_hz") == pytest.approx(1.3 * place, rel=1e-4)


def test_every_handle_stays_under_the_hand_that_drags_it(session):
    crossover = value_of(told(session, {"kind": "start"}), "crossover_hz")
    names = [handle.name for handle in handles_of(session.state, crossover)]
    assert names == ["gain", "integral", "derivative", "rate", NOTCH]
    for name in names[1:]:
        [start] = [h for h in handles_of(session.state, crossover) if h.name == name]
        told(session, drag(name, gesture=name, frequency=1.2))
        [end] = [h for h in handles_of(session.state, crossover) if h.name == name]
        assert end.frequency_hz == pytest.approx(1.2 * start.frequency_hz, rel=1e-4)


def test_a_notch_dragged_down_takes_the_gain_along(session):
    before = told(session, {"kind": "start"})["curves"]["handles"][-1]
    after = told(session, drag(gain=10 ** (-6 / 20)))["curves"]["handles"][-1]
    assert after["db"] == pytest.approx(before["db"] - 6.0, abs=0.01)


def test_filters_come_and_go_and_change_places(session):
    told(session, {"kind": "add", "filter": "low-pass", "hz": 400.0})
    kinds = [each["kind"] for each in session.state.content["controller"]["filters"]]
    assert kinds == ["notch", "low-pass"]
    before = told(session, {"kind": "start"})
    after = told(session, {"kind": "reorder", "index": 1, "to": 0})
    kinds = [each["kind"] for each in session.state.content["controller"]["filters"]]
    assert kinds == ["low-pass", "notch"]
    phase = [value_of(parts, "phase_margin_deg") for parts in (before, after)]
    assert phase[0] == pytest.approx(phase[1], rel=1e-6)
    told(session, {"kind": "remove", "index": 1}, {"kind": "remove", "index": 0})
    assert "filters" not in session.state.content["controller"]


def test_a_field_takes_a_number_in_its_unit_or_a_text_with_another(session):
    key = "plant.inertia"
    told(session, {"kind": "set", "key": key, "number": 2.5})
    assert session.state.content["plant"]["inertia"] == "2.5 kg m^2"
    told(session, {"kind": "set", "key": key, "text": "25000 kg cm^2"})
    assert session.state.scenario.inertia == pytest.approx(2.5)
    told(session, {"kind": "set", "key": "controller.sample_time", "text": "200 us"})
    assert session.state.loop.controller_noun.sample_time == pytest.approx(2e-4)


@pytest.mark.parametrize(
    ("message", "says"),
    [
        ({"kind": "set", "key": "plant.inertia", "text": "-1 kg m^2"}, "out of range"),
        ({"kind": "set", "key": "plant.inertya", "text": "1 kg m^2"}, "inertya"),
        ({"kind": "set", "key": f"{NOTCH}.frequency", "text": "3000 Hz"}, "3000"),
        ({"kind": "drag", "handle": "nothing", "hz": 1.0}, "nothing"),
        ({"kind": "drag", "handle": NOTCH, "hz": 1.0, "frequency": -1.0}, "frequency = -1.0"),
        ({"kind": "remove", "index": 7}, "filter 7"),
        ({"kind": "add", "filter": "comb"}, "comb"),
        ({"kind": "source", "source": "data"}, "data"),
        ({"kind": "move", "move": 3}, "move 3"),
        ({"kind": "take"}, "tune first"),
        ({"kind": "uncertain", "inertia_error": 1.5}, "1.5"),
        ({"kind": "sing"}, "sing"),
        ({"kind": "set"}, "key"),
    ],
)
def test_what_cannot_be_is_told_in_one_line_and_changes_nothing(refusing, message, says):
    before = refusing.state
    problem = problem_of(refusing, message)
    assert says in problem
    assert "\n" not in problem
    assert str(before.path) not in problem
    assert refusing.state is before


def test_a_link_brings_the_state_back_in_another_session(session, path):
    messages = drag(frequency=1.25), {"kind": "add", "filter": "lead-lag", "hz": 20.0}
    link = told(session, *messages)["status"]["link"]
    other = session_of(path)
    shown = told(other, {"kind": "start", "link": link})
    assert other.state.content == session.state.content
    assert "problem" not in shown


@pytest.mark.parametrize("link", ["nonsense", "[1]", '{"plant": {"inertia": "0 kg m^2"}}'])
def test_a_link_that_is_spoilt_is_told_and_the_file_is_shown(session, link):
    shown = told(session, {"kind": "start", "link": link})
    assert shown["problem"]["text"]
    assert session.state.content["plant"]["inertia"] == "2 kg m^2"
    assert shown["numbers"]["stable"] is True


def test_bounds_of_the_check_file_and_of_requirements_colour_the_margins(tmp_path):
    path = written(tmp_path)
    checks = path.with_name("two_modes.check.toml")
    checks.write_text(
        "[margins]\nphase_margin_deg = { min = 80 }\n[moves.turn]\nduration_s = { max = 9 }\n"
    )
    rows = {r["name"]: r for r in told(session_of(path))["numbers"]["margins"]}
    assert rows["phase_margin_deg"]["verdict"] == "outside"
    assert rows["phase_margin_deg"]["fails"]
    assert rows["phase_margin_deg"]["allowed"] == "≥ 80"
    assert rows["sensitivity_peak"]["allowed"] == "≤ 2"


def test_margins_as_opened_stand_beside_and_judge_nothing(session, path):
    shown = told(
        session, {"kind": "drag", "handle": "gain", "gesture": "g", "hz": 5.0, "gain": 0.5}
    )
    rows = {r["name"]: r for r in shown["numbers"]["margins"]}
    assert shown["numbers"]["revision"] == "as opened"
    assert rows["crossover_hz"]["verdict"] == "unchecked"
    assert not rows["crossover_hz"]["fails"]
    assert rows["crossover_hz"]["was"] == f"{of_file(path).crossover_hz:.4g}"


def test_margins_stand_beside_those_that_were_stored(tmp_path):
    path = written(tmp_path)
    stored = measured_baseline(loop_numbers(of_file(path)), None, Checks())
    stored.write(path.with_name("two_modes.baseline.json"))
    session = session_of(path)
    shown = told(
        session, {"kind": "drag", "handle": "gain", "gesture": "g", "hz": 5.0, "gain": 1.5}
    )
    rows = {r["name"]: r for r in shown["numbers"]["margins"]}
    assert shown["numbers"]["revision"] == "two_modes.baseline.json"
    assert rows["crossover_hz"]["verdict"] == "changed"
    assert rows["upper_gain_margin_db"]["verdict"] == "worse"
    before = of_file(path).upper_gain_margin_db
    assert rows["upper_gain_margin_db"]["was"] == f"{before:.4g}"


def test_an_unstable_loop_is_shown_with_its_curves_and_without_responses(session):
    message = {"kind": "drag", "handle": "gain", "gesture": "g", "hz": 5.0, "gain": 300.0}
    shown = told(session, message, until="worst")
    assert shown["numbers"]["stable"] is False
    assert len(shown["curves"]["model"]["frequency"]) > 100
    assert "time" not in shown["step"]
    assert "unstable" in shown["response"]["problem"]
    back = told(session, {"kind": "undo"})
    assert back["numbers"]["stable"] is True


def test_lines_on_which_the_loop_is_infinite_are_left_out(session):
    told(session, {"kind": "set", "key": "plant.inertia", "text": "1e-12 kg m^2"})
    shown = told(session)
    for name, column in (
        ("curves", shown["curves"]["model"]["gain_db"]),
        ("closed", shown["closed"]["s_db"]),
    ):
        assert abs(column).max() < 1e6, name


def test_curves_are_the_loops_own(session):
    import numpy as np

    shown = told(session)["curves"]["model"]
    system = session.state.loop.loop_transfer()
    for at in (20, 200, 400):
        hz = shown["frequency"][at]
        exact = system(np.exp(2j * np.pi * hz * 0.25e-3))
        assert shown["gain_db"][at] == pytest.approx(20 * np.log10(abs(exact)), abs=1e-6)
        assert shown["re"][at] == pytest.approx(exact.real, rel=1e-6)


def test_the_worst_case_is_that_of_loops_with_another_inertia_and_a_later_torque(session, path):
    message = {"kind": "uncertain", "inertia_error": 0.2, "delay_error_s": 0.5e-3}
    shown = told(session, message, until="worst")["worst"]
    tough = [
        loop_margins(
            servo_loop_of(
                load_scenario(
                    path,
                    overrides={
                        "plant.inertia": f"{j} kg m^2",
                        "plant.viscous": f"{b} N m s/rad",
                        "controller.delay": d,
                    },
                )
            )
        )
        for j, b in ((1.6, 2.4), (2.4, 3.6))
        for d in ("0.25 ms", "0.75 ms")
    ]
    least = min(margins.phase_margin_deg for margins in tough)
    most = max(margins.sensitivity_peak for margins in tough)
    assert shown["margins"]["phase_margin_deg"] == pytest.approx(least, rel=1e-6)
    assert shown["margins"]["sensitivity_peak"] == pytest.approx(most, rel=1e-6)


def rigid(tmp_path):
    """Return a session of an inertia without modes, on which tuning is quick."""
    first, second = SCENARIO.index("# The first mode"), SCENARIO.index("[controller]")
    return session_of(written(tmp_path, SCENARIO[:first] + SCENARIO[second:]))


def test_tuned_gains_are_shown_before_they_are_taken(tmp_path):
    session = rigid(tmp_path)
    before = session.state.content
    bounds = {"max_sensitivity": 1.8, "max_complementary": 1.8}
    shown = told(session, {"kind": "tune", **bounds}, until="proposal")
    assert session.state.content == before
    peak = {name: after for name, _, after in shown["proposal"]["margins"]}
    assert peak["sensitivity_peak"] <= 1.8 * (1 + 1e-3)
    after = told(session, {"kind": "take"})
    assert value_of(after, "sensitivity_peak") == peak["sensitivity_peak"]
    told(session, {"kind": "undo"})
    assert session.state.content == before


@pytest.mark.parametrize("bound", ["abc", "", None])
def test_bounds_that_are_no_numbers_are_told(refusing, bound):
    message = {"kind": "tune", "max_sensitivity": bound, "max_complementary": 1.6}
    assert "max_sensitivity = " in problem_of(refusing, message)


def test_bounds_that_no_gains_keep_are_told(tmp_path):
    session = rigid(tmp_path)
    bounds = {"max_sensitivity": 1.0001, "max_complementary": 1.0001}
    assert problem_of(session, {"kind": "tune", **bounds})


def test_the_scenario_is_written_as_toml_reads_it(session):
    told(session, drag(frequency=1.25))
    text = session.text()
    assert tomllib.loads(text) == session.state.content
    assert text.replace('"90 Hz"', '"72 Hz"') == SCENARIO


@pytest.mark.parametrize(
    "message",
    [
        {"kind": "uncertain", "delay_error_s": 0.5},
        {"kind": "set", "key": "controller.delay", "text": "1000 sample"},
    ],
    ids=["error", "delay"],
)
def test_a_delay_that_a_page_would_wait_for_is_told(session, message):
    shown = told(session, message)
    assert re.search("samples.*expected 250 at most.*jounce survey", shown["problem"]["text"])
    assert shown["numbers"]["stable"] is True
