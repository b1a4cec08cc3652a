"""Scenario files whose plant was measured: surveyed, checked, tuned, exported, refused."""

import json

import control
import numpy as np
import pytest
from command_lines import refused

from jounce.app import load_scenario, survey_file, sweep

LINES = np.geomspace(0.5, 60.0, 80)
J, TAU = 2.0, 4e-3
AXIS = """
format = 2
title = "stage"
plant.frf = { file = "axis.csv", integrators = 2, unstable_poles = 0 }
controller.gains = { kp = "800 N/m", ki = "2000 N/(m s)", kr = "60 N s/m" }
controller.derivative_filter = "3 ms"
"""
LOOP = """
format = 2
plant.frf = { file = "loop.csv", kind = "loop", integrators = 3, unstable_poles = 0 }
controller.gains = "measured"
"""


def law(s):
    return 800.0 + 2000.0 / s + 60.0 * s / (3e-3 * s + 1)


def exact_margins():
    """Phase margin and peak of S on a fine grid of the exact loop."""
    omega = 2 * np.pi * np.geomspace(0.5, 60.0, 200_001)
    s = 1j * omega
    loop = law(s) * np.exp(-s * TAU) / (J * s**2)
    at = int(np.argmin(abs(np.log(abs(loop)))))
    return np.degrees(np.angle(-loop[at])), (1 / abs(1 + loop)).max()


@pytest.fixture
def measured(tmp_path):
    """Write a plant's response and its loop's, and give what writes a scenario beside them."""
    rng = np.random.default_rng(3)
    s = 2j * np.pi * LINES
    noise = 1 + 1e-3 * (rng.normal(size=80) + 1j * rng.normal(size=80)) / np.sqrt(2)
    plant = np.exp(-s * TAU) / (J * s**2) * noise
    for name, values in (("axis", plant), ("loop", plant * law(s))):
        rows = [
            f"{hz!r},{v.real!r},{v.imag!r},{1e-3 * abs(v)!r}"
            for hz, v in zip(LINES.tolist(), values.tolist(), strict=True)
        ]
        text = "\n".join(["frequency_hz,re,im,sigma", *rows])
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")

    def write(text=AXIS):
        (tmp_path / "case.toml").write_text(text, encoding="utf-8")
        return tmp_path / "case.toml"

    return write


@pytest.mark.parametrize("text", [AXIS, LOOP])
def test_margins_are_surveyed_within_their_error_bars(measured, text):
    phase, peak = exact_margins()
    found = survey_file(measured(text)).margins
    assert found.stable
    assert abs(found.phase_margin_deg - phase) < 5 * found.phase_margin_deg_sigma
    assert abs(found.sensitivity_peak - peak) < 5 * found.sensitivity_peak_sigma


def test_the_survey_is_printed_and_written(measured, run, tmp_path):
    text = (
        AXIS + "requirements = { phase_margin = { min = '30 deg' }, disk_margin = { min = 1.5 } }"
    )
    status, out, errors = run("survey", measured(text), "-o", tmp_path / "out")
    assert (status, errors) == (1, [])  # a requirement is missed
    assert "phase margin [deg]" in out
    assert "Required disk_margin ≥ 1.5 is" in out
    written = json.loads((tmp_path / "out" / "survey.json").read_text("utf-8"))
    assert written["margins"]["phase_margin_deg_sigma"] > 0
    assert [each["met"] for each in written["requirements"]] == [True, False]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "survey.json",
        "survey.png",
    }


def test_a_plain_text_is_a_plant(measured):
    plain = AXIS.replace('{ file = "axis.csv", integrators = 2, unstable_poles = 0 }', '"axis.csv"')
    assert load_scenario(measured(plain)).plant.frf.kind == "plant"
    assert load_scenario(measured(plain)).motion == "length"
    assert survey_file(measured(plain)).margins.stable


def test_an_unstable_loop_fails(measured, run, tmp_path):
    much = AXIS.replace("800 N", "9600 N").replace("2000 N", "24000 N").replace("60 N s", "720 N s")
    status, _, errors = run("survey", measured(much), "-o", tmp_path)
    assert status == 1
    assert "the measured loop is UNSTABLE" in errors[0]


def test_what_cannot_be_told_is_told_and_fails_the_check(measured, run, tmp_path):
    path = measured(
        AXIS.replace("800 N/m", "8 N/m").replace("2000 N", "1 N").replace("60 N", "2 N")
    )
    status, out, _ = run("survey", path, "-o", tmp_path / "out")
    assert status == 0
    assert "STABILITY CANNOT BE TOLD" in out
    status, out, _ = run("check", path, "--update")
    assert status == 1
    assert "FAILED: Stability cannot be told: no line with |L| > 1" in out


def test_a_required_margin_that_was_not_measured_fails_the_check(measured, run):
    asked = "requirements.upper_gain_margin = { min = '3 dB' }\n"
    short = AXIS.replace('"axis.csv"', '"short.csv"') + asked
    path = measured(short)
    lines = (path.parent / "axis.csv").read_text("utf-8").splitlines()
    (path.parent / "short.csv").write_text("\n".join(lines[:56]), encoding="utf-8")
    status, out, _ = run("check", path, "--update")
    assert status == 1
    assert "Required upper_gain_margin was not measured" in out


def test_a_check_allows_for_error_bars(measured, run, tmp_path):
    path = measured()
    found = survey_file(path).margins
    bound = found.phase_margin_deg + found.phase_margin_deg_sigma
    checks = tmp_path / "case.check.toml"
    checks.write_text(f"phase_margin_deg = {{ min = {bound}, sigmas = 2 }}\n", encoding="utf-8")
    assert run("check", path, "--update")[0] == 0
    assert run("check", path)[0] == 0
    checks.write_text(f"phase_margin_deg = {{ min = {bound} }}\n", encoding="utf-8")
    assert run("check", path)[0] == 1


def test_a_new_measurement_is_the_same_within_three_deviations(measured, run):
    path = measured()
    assert run("check", path, "--update")[0] == 0
    data = path.parent / "axis.csv"
    head, *rows = data.read_text("utf-8").splitlines()
    numbers = np.array([[float(cell) for cell in row.split(",")] for row in rows])

    def again(name, gain):
        cells = numbers * [1.0, gain, gain, 1.0]
        text = "\n".join([head, *(",".join(map(repr, row)) for row in cells.tolist())])
        (path.parent / name).write_text(text, encoding="utf-8")
        path.write_text(AXIS.replace("axis.csv", name), encoding="utf-8")

    again("later.csv", 1.0003)
    status, out, _ = run("check", path)
    assert status == 0, out
    again("much_later.csv", 1.05)
    status, out, _ = run("check", path)
    assert status == 1
    assert "margins.crossover_hz" in out


def test_gains_are_tuned_on_it(measured):
    tuned = AXIS.replace('{ kp = "800 N/m", ki = "2000 N/(m s)", kr = "60 N s/m" }', '"tune"')
    found = survey_file(measured(tuned))
    gains = found.controller
    s = control.tf("s")
    loop = (gains.kp + gains.ki / s + gains.kr * s / (3e-3 * s + 1)) / (J * s**2)
    omega = 2 * np.pi * np.geomspace(0.5, 60.0, 5001)
    values = loop(1j * omega) * np.exp(-1j * omega * TAU)
    assert (1 / abs(1 + values)).max() == pytest.approx(1.6, rel=0.02)


def test_its_controller_leaves_as_fmu_and_c_and_its_axis_does_not(measured, run, folder):
    path = measured(AXIS + 'controller.sample_time = "1 ms"\n')
    status, out, _ = run("fmu", "export", path, "--block", "controller", "--platform", "none")
    assert (status, "controller, FMI 2.0" in out) == (0, True)
    assert run("export", "c", path, "--block", "controller", "-o", folder / "c")[0] == 0
    assert (folder / "c" / "controller.h").exists()
    line = refused(run, folder, "fmu", "export", path, "--block", "loop")
    assert "has no time response" in line
    assert "fit_axis" in line
    line = refused(run, folder, "fmu", "export", measured(), "--block", "controller")
    assert "write sample_time" in line


MOVES = """
limits.axis.velocity = "1 m/s"
moves = [{ name = "go", distance = "1 mm", settle_to = "1 um" }]
"""


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("", MOVES, "moves: a measured response has no time response; fit an axis to it with"),
        ("", "feedforward.inertia = '2 kg'\n", "or leave feedforward out"),
        ("", "tracking = [{ name = 'a', rate = '1 mm/s', duration = '2 s' }]\n", "tracking: a mea"),
        ("", "requirements.load_settling = { max = '1 s' }\n", "or require margins alone: cros"),
        ("axis.csv", "none.csv", "none.csv: cannot be read (No such file"),
        ('{ file = "axis.csv", integrators = 2, unstable_poles = 0 }', "3", "3 is no file of a"),
        ("integrators = 2", "integrators = 9", "plant.frf.integrators: 9 is not known"),
        ("integrators = 2", "kid = 2", "did you mean kind?"),
        ("integrators = 2", "averages = 0", "0 is not a whole number from 1"),
        ("integrators = 2", 'columns = "Hz"', "'Hz' is not a list of names"),
        ("integrators = 2", 'columns = ["Hz"]', "1 names for the 4 columns"),
        ("integrators = 2", 'kind = "loop"', "of kind 'loop' has its controller in it"),
        ("plant.frf", "plant.viscous = '2 N s/m'\nplant.frf", "has viscous beside frf"),
        ("plant.frf", "plant.mass = '2 kg'\nplant.frf", "has mass and frf; write one of"),
        ("", "controller.sample_time = '20 ms'\n", "is above half the sampling frequency"),
        ("", "controller.sample_time = '1 ms'\ncontroller.delay = '1 ms'\n", "has its delay in it"),
    ],
)
def test_what_does_not_go_together_is_one_line(measured, run, tmp_path, old, new, told):
    text = AXIS.replace(old, new, 1) if old else AXIS + new
    line = refused(run, tmp_path, "survey", measured(text), "-o", tmp_path / "out")
    assert told in line


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (AXIS.split("controller.gains")[0] + 'controller.gains = "measured"', "write gains = "),
        (AXIS.split("controller.gains")[0] + 'controller.gains = "published"', 'gains = "tune"'),
        (
            LOOP.replace('kind = "loop"', 'kind = "process-sensitivity"').replace(
                '"measured"', '"tune"'
            ),
            "which was measured with gains",
        ),
        (
            LOOP.replace(
                'frf = { file = "loop.csv", kind = "loop", integrators = 3, unstable_poles = 0 }',
                'inertia = "2 kg m^2"',
            ),
            "'measured' without a measured loop",
        ),
    ],
)
def test_gains_have_to_go_with_what_was_measured(measured, run, tmp_path, text, told):
    line = refused(run, tmp_path, "survey", measured(text), "-o", tmp_path / "out")
    assert told in line


def test_a_sweep_takes_gains_and_measurements(measured):
    path = measured()
    (path.parent / "tuesday.csv").write_bytes((path.parent / "axis.csv").read_bytes())
    keys = {
        "controller.gains.kp": ["500 N/m", "800 N/m"],
        "plant.frf.file": ["axis.csv", "tuesday.csv"],
    }
    found = sweep(path, keys, figures=["phase_margin"], workers=1).values("phase_margin")
    assert found[2] == found[3] == survey_file(path).margins.phase_margin_deg
    assert found[0] == found[1] != found[2]
    alone = sweep(path, keys, figures=["load_settling"], workers=1)
    assert "has margins alone" in alone.dataset["failure"].values[0]
