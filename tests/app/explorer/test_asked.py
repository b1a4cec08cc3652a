"""Feedforward, disturbances and requirements: edited, added, left out, kept in the file."""

import tomllib

import pytest
from explored import EXAMPLES, SCENARIO, problem_of, session_of, told, written
from tiers import some

from jounce.app import load_scenario
from jounce.app.explorer.asked import asked_part, with_asked, without_asked
from jounce.app.explorer.state import opened

EVERY = sorted(path.stem for path in EXAMPLES.glob("*.toml") if "." not in path.stem)


def sections(session, *messages):
    parts = told(session, *messages, until="asked")
    assert "problem" not in parts, parts["problem"]
    return {each["name"]: each for each in parts["asked"]["elements"]}


def row(session, name):
    [found] = [r for r in told(session)["numbers"]["margins"] if r["name"] == name]
    return found


def saved(session, path):
    session.receive({"kind": "save"})
    return path.read_text()


def test_a_requirement_is_asked_for_changed_and_left_out(tmp_path):
    path = written(tmp_path)
    session = session_of(path)
    assert row(session, "phase_margin_deg")["allowed"] == ""
    asked = sections(session, {"kind": "ask", "section": "requirements", "name": "phase_margin"})
    assert "phase_margin" not in asked["requirements"]["more"]
    assert row(session, "phase_margin_deg")["allowed"] == "≥ 45"
    key = "requirements.phase_margin.min"
    told(session, {"kind": "set", "key": key, "text": "1.2 rad"})
    assert row(session, "phase_margin_deg")["allowed"] == "≥ 68.75"
    assert row(session, "phase_margin_deg")["fails"]
    text = saved(session, path)
    assert text == SCENARIO + 'phase_margin = {min = "1.2 rad"}\n'
    assert load_scenario(path).requirements[-1].least == pytest.approx(68.754935)
    sections(session, {"kind": "leave", "key": key})
    assert row(session, "phase_margin_deg")["allowed"] == ""
    assert saved(session, path) == SCENARIO
    sections(session, {"kind": "leave", "key": "requirements.sensitivity_peak.max"})
    assert session.state.scenario.requirements == ()
    assert "requirements" not in tomllib.loads(saved(session, path))
    told(session, {"kind": "undo"})
    assert row(session, "sensitivity_peak")["allowed"] == "≤ 2"


def test_the_feedforward_changes_its_kind_and_its_gains(tmp_path):
    path = written(tmp_path)
    session = session_of(path)
    before = told(session, until="response")["response"]["figures"]
    asked = sections(session, {"kind": "set", "key": "feedforward", "word": "by derivatives"})
    [acceleration] = [
        f for f in asked["feedforward"]["fields"] if f["key"] == "feedforward.acceleration"
    ]
    assert (acceleration["number"], acceleration["unit"]) == (2.0, "N m s^2/rad")
    assert told(session, until="response")["response"]["figures"] == before
    sections(session, {"kind": "ask", "section": "feedforward", "name": "velocity"})
    told(session, {"kind": "set", "key": "feedforward.velocity", "number": 3.0})
    better = told(session, until="response")["response"]["figures"]
    assert better[1][1] < before[1][1]
    assert session.state.loop.feedforward_noun.torque == {1: 3.0, 2: 2.0}
    asked = sections(session, {"kind": "set", "key": "feedforward", "word": "of the inertia"})
    assert "velocity" not in asked["feedforward"]["more"]
    assert saved(session, path) == SCENARIO
    sections(session, {"kind": "set", "key": "feedforward", "word": "inverse at low frequency"})
    assert tomllib.loads(saved(session, path))["feedforward"] == {"inverse": "low-frequency"}


def test_disturbances_come_change_and_go_as_a_whole(tmp_path):
    path = written(tmp_path)
    session = session_of(path)
    asked = sections(session, {"kind": "ask", "section": "disturbances", "name": "torque_step"})
    fields = {f["key"]: f for f in asked["disturbances"]["fields"]}
    assert fields["disturbances.torque_step.on"]["word"] == "load"
    assert "leave" not in fields["disturbances.torque_step.on"]
    told(session, {"kind": "set", "key": "disturbances.torque_step.on", "word": "motor"})
    told(session, {"kind": "set", "key": "disturbances.torque_step.torque", "number": -7.0})
    written_as = tomllib.loads(saved(session, path))["disturbances"]
    assert written_as == {"torque_step": {"torque": "-7 N m", "on": "motor"}}
    assert path.read_text().startswith(SCENARIO + "\n[disturbances]\ntorque_step")
    leave = fields["disturbances.torque_step.torque"]["leave"]
    asked = sections(session, {"kind": "leave", "key": leave})
    assert asked["disturbances"]["fields"] == []
    assert saved(session, path) == SCENARIO


@pytest.mark.parametrize("name", some(EVERY, 2))
def test_all_that_can_be_added_to_an_example_can_be_taken_away_again(tmp_path, name):
    state = opened(written(tmp_path, (EXAMPLES / f"{name}.toml").read_text()))
    for element in asked_part(state)["elements"]:
        for more in element["more"]:
            with_it = with_asked(state, element["name"], more)
            [now] = [e for e in asked_part(with_it)["elements"] if e["name"] == element["name"]]
            assert more not in now["more"]
            back = without_asked(with_it, f"{element['name']}.{more}")
            assert back.content == state.content


@pytest.fixture(scope="module")
def refusing(tmp_path_factory):
    """Return one session for all messages that change nothing."""
    return session_of(written(tmp_path_factory.mktemp("refusing")))


@pytest.mark.parametrize(
    ("message", "says"),
    [
        ({"kind": "ask", "section": "plant", "name": "inertia"}, "section 'plant'"),
        ({"kind": "ask", "section": "requirements", "name": "beauty"}, "beauty"),
        ({"kind": "leave", "key": "plant.inertia"}, "plant.inertia"),
        ({"kind": "leave", "key": "requirements"}, "requirements"),
        ({"kind": "leave", "key": "requirements.phase_margin"}, "phase_margin"),
        ({"kind": "set", "key": "feedforward", "word": "psychic"}, "psychic"),
        ({"kind": "set", "key": "requirements.sensitivity_peak.max", "text": "low"}, "low"),
    ],
)
def test_what_cannot_be_asked_is_told_in_one_line(refusing, message, says):
    before = refusing.state
    text = problem_of(refusing, message)
    assert says in text
    assert "\n" not in text
    assert refusing.state is before


def test_a_force_step_is_the_torque_step_of_a_linear_axis(tmp_path):
    text = (EXAMPLES / "gantry_crane.toml").read_text()
    state = opened(written(tmp_path, text.replace("torque_step", "force_step")))
    more = {each["name"]: each["more"] for each in asked_part(state)["elements"]}
    assert "torque_step" not in more["disturbances"]
    assert "wind" in more["disturbances"]
    with pytest.raises(ValueError, match="torque_step: expected one of"):
        with_asked(state, "disturbances", "torque_step")
