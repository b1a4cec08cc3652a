"""The command `jounce export c`: what it writes, and one clear line for a wrong input."""

import subprocess
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from fmus import needs_compiler

from jounce.app import scenario_blocks
from jounce.app.block_choice import BlockChoice
from jounce.app.scenario import load_scenario
from jounce.fmu.exporting import export_c as writing
from jounce.plant import PID, Axis, Controller, Feedforward, Friction, ServoLoop
from jounce.shaping import CommandFollower, JerkFilter, Limits

SCENARIO = """
plant.inertia = "2 kg"
controller.gains = {kp = "90 N/m", ki = "60 N/(m s)", kr = "20 N s/m"}
filter = {corner = "20 Hz", order = 4}
limits.axis = {velocity = "1 m/s", acceleration = "2 m/s^2"}
moves = [
    {name = "out & in", distance = "20 mm", settle_to = "1 mm"},
    {name = "back", distance = "-10 mm", settle_to = "1 mm"},
]
"""
ALONE = ["filter", "controller", "plant"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """Work in a folder that holds a scenario; measure nothing."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(writing, "measure", lambda *_: None)
    Path("axis.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


@pytest.fixture
def run(run):
    """Run `jounce export c` on the scenario; its `func` runs any command."""
    return partial(run, "export", "c", "axis.toml", "--block")


@pytest.mark.parametrize("block", ALONE)
def test_every_block_of_a_scenario_leaves(run, block):
    status, out, errors = run(block, "--output", "made")
    assert (status, errors) == (0, [])
    assert f": {block}, C99, " in out
    assert f"int {block}_init({block}_block *block);" in Path("made", f"{block}.h").read_text()


def test_a_move_that_there_is_not_is_refused(run):
    status, out, errors = run("trajectory", "--output", "made", "--move", "away")
    assert (status, out) == (2, "")
    assert "has no move 'away'; give --move one of 'out & in', 'back'" in errors[0]
    assert not Path("made").exists()


@pytest.mark.parametrize("block", ["trajectory", "follower", "shaper"])
def test_a_block_of_a_move_takes_the_first_and_says_so(run, block):
    status, out, _ = run(block, "--output", "made")
    assert status == 0
    assert "The move is 'out & in', the first; --move takes another: 'back'" in out


def test_a_move_is_chosen_by_name(run):
    status, out, _ = run("shaper", "--output", "made", "--move", "back", "--name", "pan")
    assert (status, "The move" in out) == (0, False)
    assert Path("made", "pan.h").exists()
    assert not Path("made", "shaper.h").exists()


def test_the_whole_loop_leaves_to_be_simulated(run):
    status, out, _ = run("servo", "--output", "made", "--sample-time", "2 ms")
    assert (status, "The move is 'out & in'" in out) == (0, True)
    assert "#define SERVO_SAMPLE_TIME 0.002" in Path("made", "servo.h").read_text()


def test_a_shaper_is_the_move_s_input_shaper_where_it_has_one(run):
    Path("axis.toml").write_text(
        f'format = 2\nshaper = {{kind = "ZV", frequency = "5 Hz"}}\n{SCENARIO}', encoding="utf-8"
    )
    status, _, errors = run("shaper", "--output", "made", "--sample-time", "10 ms")
    assert (status, errors) == (0, [])
    text = Path("made", "shaper.c").read_text()
    assert "part_delay[2] = {0.0, 10.0}" in text
    assert "part_weight[2] = {0.5, 0.5}" in text
    assert run("follower", "--output", "followed")[0] == 0
    assert "command_velocity" in Path("followed", "follower.h").read_text()


@pytest.mark.parametrize("bounds", ['snap = "200 m/s^4"', 'crackle = "2 km/s^5"'])
def test_lags_behind_a_follower_keep_the_bounds_above_the_jerk(bounds):
    more = f'"2 m/s^2", jerk = ["-20 m/s^3", "30 m/s^3"], {bounds}}}'
    text = SCENARIO.replace('"2 m/s^2"}', more).replace("filter =", "#")
    Path("axis.toml").write_text(text, encoding="utf-8")
    scenario = load_scenario("axis.toml")
    follower, [told] = scenario_blocks._follower_of(scenario, 1e-3, None)
    order = 4 if "snap" in bounds else 5
    assert f"lags behind the follower, {order - 3} of " in told
    commands = np.repeat([1.0, -1.0, 0.4, 0.5], 700)
    states = follower.run(commands).states
    steps = np.diff(states[3], n=order - 3) / 1e-3 ** (order - 3)
    limit = 200.0 if order == 4 else 2e3
    assert 0.2 * limit < np.abs(steps).max() <= limit
    assert -20.0 <= states[3].min() < 0.0 < states[3].max() <= 30.0


@pytest.mark.parametrize(("corner", "order"), [(0.5, 1), (500.0, 3)])
def test_lags_of_a_filter_keep_the_bounds_above_the_jerk_too(corner, order):
    def follower(filtered):
        text = SCENARIO.replace('"2 m/s^2"}', '"2 m/s^2", jerk = "20 m/s^3", crackle = "2 km/s^5"}')
        Path("axis.toml").write_text(text.replace("filter =", f"{filtered}#"), encoding="utf-8")
        return scenario_blocks._follower_of(load_scenario("axis.toml"), 1e-3, None)[0]

    alone = follower("").jerk_filter
    assert alone.order == 2
    both = follower(f'filter = {{corner = "{corner} Hz", order = {order}}} ').jerk_filter
    assert both.corner_hz == min(corner, alone.corner_hz)
    assert both.order == max(order, alone.order)


@pytest.mark.parametrize("verb", ["c", "fmu"])
@pytest.mark.parametrize("block", BlockChoice)
def test_blocks_have_the_same_names_in_c_and_fmu(run, verb, block):
    name = f"made.{'ssp' if block == 'loop' else 'fmu'}"
    words = ("export", "c") if verb == "c" else ("fmu", "export")
    to = ("made",) if verb == "c" else (name, "--platform", "none")
    status, out, errors = run.func(*words, "axis.toml", "--block", block.value, "-o", *to)
    assert (status, errors) == (0, [])
    assert f"{'C99' if verb == 'c' else 'FMI 2.0'}," in out


def test_a_wrong_name_is_told_with_all_that_there_are(run):
    for words in (("export", "c"), ("fmu", "export")):
        status, _, [line] = run.func(*words, "axis.toml", "--block", "shapr", "-o", "made")
        assert status == 2
        assert all(f"'{block.value}'" in line for block in BlockChoice)


def test_keys_are_set_in_place_of_the_file_s(run):
    given = ("--set", "controller.gains.kp=80 N/m", "--set", 'moves."back".distance="-20 mm"')
    status, out, _ = run("controller", "--output", "made", *given)
    assert (status, "with controller.gains.kp = '80 N/m'" in out) == (0, True)
    assert "block->kp = 80.0;" in Path("made", "controller.c").read_text()
    for wrong, words in (("plnt.inertia=3 kg", "plnt"), ("moves.away.distance=1 m", "no entry")):
        status, out, [line] = run("plant", "--output", "no", "--set", wrong)
        assert (status, out, words in line) == (2, "", True)


@needs_compiler
def test_the_shapers_example_moves_as_python_does(run):
    run("shaper", "--output", "made", "--sample-time", "5 ms")
    subprocess.run(["make", "-s"], cwd="made", check=True)
    made = subprocess.run(["made/build/example"], capture_output=True, text=True, check=True)
    rows = np.array([line.split() for line in made.stdout.splitlines()], dtype=float).T
    limits = Limits(velocity=1.0, acceleration=2.0)
    follower = CommandFollower(limits, dt=0.005, jerk_filter=JerkFilter(20.0, 4))
    np.testing.assert_array_equal(rows, follower.run(np.ones(1000)).states)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("plant", "-o", "axis.toml"), "--output axis.toml: is a file; name a folder"),
        (("plant", "-o", "no/c"), "no is not a folder; create it first"),
        (("plant", "-o", "."), "holds axis.toml, which no export wrote; name a new or empty"),
        (("plant", "-o", "c", "--move", "back"), "--move: a plant belongs to no move"),
        (("plant", "-o", "c", "--name", "main"), "name = 'main'"),
        (("plant", "-o", "c", "--name", "int"), "name = 'int': is a word of C; use another"),
        (("shaper", "-o", "c", "--sample-time", "0 s"), "--sample-time"),
    ],
)
def test_wrong_input_is_one_line(run, arguments, told, folder):
    status, out, errors = run(*arguments)
    assert (status, out, len(errors)) == (2, "", 1)
    assert told in errors[0]
    assert [path.name for path in folder.iterdir()] == ["axis.toml"]


def digital_loop(**more):
    """Return a loop with a sample time of its own, in place of the scenario's."""
    axis = Axis(2.0, friction=Friction(0.5), torque_limit=9.0)
    running = Controller(PID(900.0, 600.0, 80.0), **{"sample_time": 5e-4} | more)
    return ServoLoop(axis, running, Feedforward({2: 2.0}))


@pytest.mark.parametrize("block", ["controller", "plant", "servo"])
def test_a_digital_loop_leaves_as_it_is(run, block, monkeypatch):
    monkeypatch.setattr(scenario_blocks, "servo_loop_of", lambda _: digital_loop())
    monkeypatch.setattr(scenario_blocks, "jerk_filter_of", lambda _: None)
    status, out, errors = run(block, "--output", "made")
    assert (status, errors) == (0, [])
    assert "The controller runs" not in out
    _, out, _ = run(block, "--output", "made", "--sample-time", "2 ms")
    assert ("The controller runs every 0.0005 s, as the scenario says" in out) == (block != "plant")
    header = Path("made", f"{block}.h").read_text()
    assert ("_SAMPLE_TIME 0.0005" in header) == (block != "plant")
    assert "double torque_limit;" in header
    assert "[N/m" in header or block == "plant"


@pytest.mark.parametrize("block", ["controller", "servo"])
def test_a_continuous_loop_of_other_kinds_is_refused_in_one_line(run, block, monkeypatch):
    loop = digital_loop(sample_time=None, anti_windup="conditional")
    monkeypatch.setattr(scenario_blocks, "servo_loop_of", lambda _: loop)
    monkeypatch.setattr(scenario_blocks, "jerk_filter_of", lambda _: None)
    status, out, errors = run(block, "--output", "made")
    assert (status, out, len(errors)) == (2, "", 1)
    assert "a continuous controller with anti-windup cannot leave" in errors[0]
    assert not Path("made").exists()
