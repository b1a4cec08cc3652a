"""The scenario file as it is written: comments and order kept, nothing else touched."""

import tomllib
from copy import deepcopy

import pytest
from explored import EXAMPLES, NOTCH, SCENARIO, problem_of, session_of, told, written

from jounce.app import load_scenario
from jounce.app.explorer.saving import differences, merged
from jounce.app.scenario_loop import servo_loop_of

pytest.importorskip("tomlkit")

NAMES = ("telescope", "gantry_crane", "servo_drive", "lift", "rubin_mount")


def comments(text):
    """Return the comments of a text, each with the line of code that it stands beside, if any."""
    found = []
    for line in text.splitlines():
        code, mark, comment = line.partition("#")
        if mark:
            found.append((code.partition("=")[0].strip(), comment))
    return found


def heads(text):
    """Return the comment block above each table's header."""
    lines = text.splitlines()
    found = {}
    for at, line in enumerate(lines):
        if line.startswith("["):
            above = []
            while at and lines[at - 1].startswith("#"):
                at -= 1
                above.insert(0, lines[at])
            found.setdefault(line.partition("#")[0].strip(), []).append(above)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_what_is_written_is_read_as_it_was_shown(tmp_path, name):
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    session = session_of(written(tmp_path, text))
    told(session, {"kind": "add", "filter": "notch", "hz": 3.0})
    told(session, {"kind": "set", "key": "feedforward.error", "number": 7.0})
    out = session.text()
    path = written(tmp_path, out)
    assert servo_loop_of(load_scenario(path)) == session.state.loop
    assert repr(load_scenario(path).moves) == repr(session.state.scenario.moves)
    assert [c for c in comments(text) if c not in comments(out)] == []


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_that_nothing_was_changed_of_keeps_its_text(tmp_path, name):
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    assert session_of(written(tmp_path, text)).text() == text


def test_a_changed_value_changes_its_line_alone(tmp_path):
    session = session_of(written(tmp_path))
    told(session, {"kind": "set", "key": "plant.modes[1].frequency", "number": 150.0})
    assert session.text() == SCENARIO.replace('"140 Hz" # measured', '"150 Hz" # measured')


def test_an_added_filter_stands_behind_the_others_and_before_the_next_tables_comment(tmp_path):
    session = session_of(written(tmp_path))
    told(session, {"kind": "add", "filter": "notch", "hz": 150.0})
    out = session.text()
    new = out.index('"150 Hz"')
    assert out.index('"72 Hz"') < new < out.index("# What the turn may be.")
    assert heads(out)["[limits.axis]"] == [["# What the turn may be."]]


def test_a_removed_filter_takes_no_comment_of_the_next_table_along(tmp_path):
    session = session_of(written(tmp_path))
    told(session, {"kind": "remove", "index": 0})
    out = session.text()
    assert "notch" not in out.replace("a notch.", "").replace("that the notch is", "")
    assert heads(out)["[limits.axis]"] == [["# What the turn may be."]]
    assert servo_loop_of(load_scenario(written(tmp_path, out))) == session.state.loop


def test_reordered_filters_keep_the_comments_of_their_values(tmp_path):
    session = session_of(written(tmp_path))
    told(session, {"kind": "add", "filter": "low-pass", "hz": 400.0})
    path = written(tmp_path, session.text())
    session = session_of(path)
    told(session, {"kind": "reorder", "index": 1, "to": 0})
    out = session.text()
    assert ("frequency", " of the free one") in comments(out)
    assert tomllib.loads(out) == session.state.content


def test_filters_within_brackets_stay_there(tmp_path):
    start, end = SCENARIO.index("# Where the first"), SCENARIO.index("# What the turn")
    inline = 'filters = [{ kind = "low-pass", corner = "400 Hz" }]\n\n'
    session = session_of(written(tmp_path, SCENARIO[:start] + inline + SCENARIO[end:]))
    told(session, {"kind": "add", "filter": "notch", "hz": 72.0})
    out = session.text()
    assert "[[controller.filters]]" not in out
    assert tomllib.loads(out) == session.state.content


def test_a_limit_that_comes_stands_in_its_table(tmp_path):
    session = session_of(written(tmp_path))
    told(session, {"kind": "set", "key": "order", "number": 4})
    lines = session.text().splitlines()
    assert lines[lines.index('jerk = "1000 rad/s^3"') + 1].startswith("snap = ")
    told(session, {"kind": "set", "key": "order", "number": 2})
    assert "jerk" not in session.text()
    assert heads(session.text())["[[moves]]"] == [["# The one move."]]


def test_a_rule_for_the_gains_stays_while_the_controller_is_not_changed(tmp_path):
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    session = session_of(written(tmp_path, text))
    told(session, {"kind": "set", "key": "limits.axis.acceleration", "number": 0.3})
    assert 'gains = "design"' in session.text()
    told(session, {"kind": "drag", "handle": "integral", "gesture": "i", "frequency": 1.1})
    out = session.text()
    assert 'gains = "design"' not in out
    assert not out.startswith("format")
    assert "format = 2" not in out


def test_what_needs_format_2_says_so(tmp_path):
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    session = session_of(written(tmp_path, text))
    told(session, {"kind": "add", "filter": "notch", "hz": 3.0})
    assert tomllib.loads(session.text())["format"] == 2


def test_saving_writes_the_file_and_starts_anew_from_it(tmp_path):
    path = written(tmp_path)
    session = session_of(path)
    drag = {"kind": "drag", "handle": NOTCH, "gesture": "n", "frequency": 1.25}
    assert told(session, drag)["status"]["changed"]
    shown = told(session, {"kind": "save"})
    assert path.read_text(encoding="utf-8") == SCENARIO.replace('"72 Hz"', '"90 Hz"')
    assert shown["saved"]["file"] == path.name
    assert not shown["status"]["changed"]
    assert shown["status"]["link"] == "{}"


def test_saving_under_another_name_leaves_the_file_alone(tmp_path):
    path = written(tmp_path)
    session = session_of(path)
    told(
        session,
        {"kind": "set", "key": "plant.inertia", "number": 3.0},
        {"kind": "save", "name": "b.toml"},
    )
    assert path.read_text(encoding="utf-8") == SCENARIO
    assert load_scenario(tmp_path / "b.toml").inertia == 3.0


@pytest.mark.parametrize("name", ["../b.toml", "/tmp/b.toml", "b.txt", "sub/b.toml"])
def test_only_scenario_files_beside_the_scenario_are_written(tmp_path, name):
    session = session_of(written(tmp_path))
    assert "beside the scenario" in problem_of(session, {"kind": "save", "name": name})
    assert [path.name for path in tmp_path.iterdir()] == ["two_modes.toml"]


def test_a_file_that_others_have_changed_is_not_overwritten(tmp_path):
    path = written(tmp_path)
    session = session_of(path)
    path.write_text(SCENARIO + "# more\n", encoding="utf-8")
    told(session, {"kind": "set", "key": "plant.inertia", "number": 3.0})
    assert "changed by others" in problem_of(session, {"kind": "save"})
    assert path.read_text(encoding="utf-8").endswith("# more\n")


def test_differences_and_what_is_merged_are_inverse():
    before = tomllib.loads(SCENARIO)
    after = deepcopy(before)
    after["plant"]["inertia"] = "3 kg m^2"
    del after["plant"]["viscous"]
    after["controller"]["filters"].append({"kind": "notch"})
    after["filter"] = {"order": 2}
    told_of = differences(before, after)
    assert told_of["plant"] == {"viscous": None, "inertia": "3 kg m^2"}
    assert merged(before, told_of) == after
    assert differences(before, before) == {}
