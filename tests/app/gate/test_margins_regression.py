"""The pytest fixture: as tests use it, in this process and in one of their own."""

import json
import subprocess
import sys
from pathlib import Path

import control
import pytest

from jounce.analysis import loop_margins
from jounce.app import load_scenario, survey_file
from jounce.plant import PID, Inertia, ServoLoop

EXAMPLE = Path(__file__).parents[3] / "examples" / "rubin_mount.toml"
CREATED = pytest.fail.Exception
LOOP = control.tf([4.0, 4.0], [1.0, 2.0, 1.0, 0.0])
SERVO = ServoLoop(Inertia(1.0), PID(28.0, 38.0, 5.4))
UNSTABLE = control.tf([100.0], [1.0, 2.0, 1.0, 0.0])


@pytest.fixture
def kept(margins_regression, tmp_path):
    """Return what checks a loop against one file in a folder of its own."""

    def check(loop, **options):
        margins_regression.check(loop, fullpath=tmp_path / "kept" / "loop.json", **options)

    check.path = tmp_path / "kept" / "loop.json"
    return check


@pytest.mark.parametrize(
    "loop",
    [LOOP, control.ss(LOOP), SERVO, SERVO.loop_transfer(), loop_margins(LOOP)],
    ids=["tf", "ss", "servo-loop", "its-transfer", "margins"],
)
def test_loops_keep_their_margins(kept, loop):
    with pytest.raises(CREATED, match="created"):
        kept(loop)
    kept(loop)
    numbers = json.loads(kept.path.read_text())["numbers"]
    margins = loop if hasattr(loop, "phase_margin_deg") else None
    expected = margins or loop_margins(SERVO.loop_transfer() if loop is SERVO else loop)
    assert set(numbers) == {"margins"}
    stored = numbers["margins"]["phase_margin_deg"]
    assert stored == {"value": expected.phase_margin_deg, "rtol": 1e-6, "atol": 0.0}


@pytest.mark.parametrize("kind", ["path", "text", "scenario", "survey"])
def test_scenarios_keep_every_number(kept, kind):
    scenario = load_scenario(EXAMPLE)
    given = {"path": EXAMPLE, "text": str(EXAMPLE), "scenario": scenario}
    loop = given[kind] if kind in given else survey_file(scenario)
    with pytest.raises(CREATED, match="created"):
        kept(loop)
    kept(loop)
    tree = json.loads(kept.path.read_text())
    assert set(tree["numbers"]) == {"margins", "step", "moves"}
    assert tree["position_unit"] == "deg"


def test_a_changed_loop_fails_with_was_is_and_allowed(kept):
    with pytest.raises(CREATED):
        kept(LOOP)
    with pytest.raises(AssertionError) as failure:
        kept(0.9 * LOOP)
    text = str(failure.value)
    assert "numbers differ from loop.json" in text
    assert "run pytest --force-regen" in text
    row = next(line.split() for line in text.splitlines() if "phase_margin_deg" in line)
    was, now = (loop_margins(gain * LOOP).phase_margin_deg for gain in (1.0, 0.9))
    assert [float(word) for word in row[1:3]] == pytest.approx([was, now], rel=1e-6)
    assert row[-1] == ("better" if now > was else "worse")


def test_an_improvement_fails_too(kept):
    """The file says what the loop is like, and it is no longer."""
    with pytest.raises(CREATED):
        kept(loop_margins(LOOP))
    tree = json.loads(kept.path.read_text())
    tree["numbers"]["margins"]["phase_margin_deg"]["value"] -= 1.0
    kept.path.write_text(json.dumps(tree))
    with pytest.raises(AssertionError, match=r"1 of 10 numbers(.|\n)* to .* better"):
        kept(LOOP)


def test_the_tolerance_may_be_wider(kept):
    with pytest.raises(CREATED):
        kept(LOOP)
    kept(1.0001 * LOOP, rtol=1e-3)
    with pytest.raises(AssertionError, match="numbers differ"):
        kept(1.0001 * LOOP)


def test_a_tolerance_given_when_the_file_is_made_is_kept(kept):
    with pytest.raises(CREATED):
        kept(LOOP, rtol=1e-3)
    kept(1.0001 * LOOP)


@pytest.mark.parametrize("loop", [UNSTABLE, loop_margins(UNSTABLE)], ids=["tf", "margins"])
def test_an_unstable_loop_is_not_kept(kept, loop):
    with pytest.raises(AssertionError, match="UNSTABLE"):
        kept(loop)
    assert not kept.path.exists()


def test_a_scenario_of_an_unstable_loop_is_not_kept(kept, tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8")
    gains = 'gains = {kp = "28 N m/rad", ki = "38 N m/(rad s)", kr = "1 N m s/rad"}'
    path = tmp_path / "axis.toml"
    path.write_text(text.replace('gains = "design"', gains), encoding="utf-8")
    with pytest.raises(AssertionError, match="UNSTABLE"):
        kept(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [("<<<<<<< HEAD", "not JSON"), ("{}", "is no baseline")],
    ids=["conflict", "other"],
)
def test_a_broken_file_is_explained(kept, content, words):
    kept.path.parent.mkdir()
    kept.path.write_text(content)
    with pytest.raises(AssertionError, match=rf"{words}(.|\n)*--force-regen") as failure:
        kept(LOOP)
    assert "--update" not in str(failure.value)  # of another command


def test_another_unit_is_told(kept):
    with pytest.raises(CREATED):
        kept(EXAMPLE)
    with pytest.raises(AssertionError, match="has positions in deg, not in None"):
        kept(LOOP)


def test_what_is_no_loop_is_refused(kept):
    with pytest.raises(TypeError, match="list"):
        kept([1.0, 2.0])
    with pytest.raises(ValueError, match="rtol = -1"):
        kept(LOOP, rtol=-1.0)
    with pytest.raises(ValueError, match="rtol = nan"):
        kept(LOOP, rtol=float("nan"))


def test_a_delay_is_taken_and_kept(kept):
    with pytest.raises(CREATED, match="created"):
        kept(LOOP, delay=0.02)
    kept(LOOP, delay=0.02)
    kept(control.ss(LOOP), delay=0.02)
    tree = json.loads(kept.path.read_text())
    stored = tree["numbers"]["margins"]["phase_margin_deg"]["value"]
    plain = loop_margins(LOOP)
    assert stored == pytest.approx(plain.phase_margin_deg - 360 * plain.crossover_hz * 0.02)
    assert tree["conditions"] == {"delay": "0.02 s"}
    with pytest.raises(
        AssertionError, match=r"and 1 of the conditions(.|\n)*delay +0.02 s +0.03 s"
    ):
        kept(LOOP, delay=0.03)
    with pytest.raises(AssertionError, match=r"delay +0.02 s +none +changed"):
        kept(LOOP)


def test_a_loop_without_delay_stores_no_condition(kept):
    with pytest.raises(CREATED):
        kept(LOOP)
    assert "conditions" not in json.loads(kept.path.read_text())
    with pytest.raises(AssertionError, match=r"and 1 of the conditions(.|\n)*delay +none +1e-09 s"):
        kept(LOOP, delay=1e-9)


def test_a_servo_loop_takes_a_delay(kept):
    with pytest.raises(CREATED):
        kept(SERVO, delay=0.01)
    kept(SERVO.loop_transfer(), delay=0.01)


@pytest.mark.parametrize("loop", [EXAMPLE, str(EXAMPLE), loop_margins(LOOP)])
def test_what_has_its_margins_takes_no_delay(kept, loop):
    with pytest.raises(ValueError, match=r"delay = 0.1 of a \w+: expected an open loop or a Servo"):
        kept(loop, delay=0.1)
    with pytest.raises(ValueError, match=r"delay = -1.0: expected a number of seconds"):
        kept(LOOP, delay=-1.0)
    assert not kept.path.exists()


def test_a_changed_condition_of_a_scenario_fails(kept):
    with pytest.raises(CREATED):
        kept(EXAMPLE)
    name = 'moves."azimuth offset".settle_to'
    kept(load_scenario(EXAMPLE, overrides={name: "0.0166666666666667 arcmin"}))
    with pytest.raises(AssertionError, match="numbers differ") as failure:
        kept(load_scenario(EXAMPLE, overrides={name: "2 arcsec"}))
    row = next(line for line in str(failure.value).splitlines() if name in line)
    assert row.split()[-5:] == ["0.000277777777778", "deg", "0.000555555555556", "deg", "changed"]


def test_a_file_of_a_scenario_without_conditions_is_stored_anew(kept):
    with pytest.raises(CREATED):
        kept(EXAMPLE)
    tree = json.loads(kept.path.read_text())
    del tree["conditions"]
    kept.path.write_text(json.dumps(tree))
    with pytest.raises(AssertionError, match=r"without the conditions .* pytest --force-regen"):
        kept(EXAMPLE)


TEST_FILE = """
import os

import numpy as np
import pytest

from jounce.analysis import LoopMargins


@pytest.mark.parametrize("name", ["a", "b [1]"])
def test_loop(margins_regression, name):
    margin = float(os.environ["MARGIN"])
    crossings = {"crossovers_hz": (1.0,), "phase_crossovers_hz": ()}
    poles = np.array([-1.0])
    margins_regression.check(LoopMargins(True, poles, **crossings, phase_margin_deg=margin))
"""


# Runs pytest once for each margin, after one import of everything.
RUNS = """
import os, sys, pytest
for margin, *options in [["45"], ["45.00001"], ["44"], ["44", "--force-regen"], ["44"]]:
    os.environ["MARGIN"] = margin
    status = pytest.main(["-q", "-rN", "-W", "error", "-p", "no:xdist", *options])
    print(f"ended with {int(status)}\\f", flush=True)
"""


def test_in_a_project_of_its_own(tmp_path):
    (tmp_path / "test_loop.py").write_text(TEST_FILE)
    done = subprocess.run(
        [sys.executable, "-c", RUNS],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    made, near, far, again, kept = done.stdout.split("\f")[:-1]
    ends = [text.splitlines()[-1][-1] for text in (made, near, far, again, kept)]
    assert ends == ["1", "0", "1", "1", "0"], done.stdout + done.stderr
    assert made.count("created:") == 2, made
    assert far.count(">= ") + far.count(" worse") == 2, far
    assert "pytest_regressions" not in far  # no frames but the test's own
    assert again.count("regenerating") == 2, again
    files = {path.name for path in (tmp_path / "test_loop").iterdir()}
    assert files == {"test_loop_a_.json", "test_loop_b__1__.json"}


def test_without_pytest_regressions_one_line_says_what_to_install(tmp_path):
    (tmp_path / "conftest.py").write_text(
        "import sys\nsys.modules['pytest_regressions'] = None  # as if it were not there\n"
    )
    (tmp_path / "test_loop.py").write_text("def test_loop(margins_regression): pass\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    line = "margins_regression needs the package pytest-regressions: pip install 'jounce[pytest]'"
    assert done.stdout.splitlines().count(line) == 1, done.stdout
    assert "Traceback" not in done.stdout


def test_the_plugin_costs_other_projects_nothing():
    code = (
        "import sys, pytest; before = set(sys.modules); import jounce.pytest_plugin; "
        "print(*{name.split('.')[0] for name in set(sys.modules) - before})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["jounce"]
