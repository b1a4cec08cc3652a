"""Reports and files of real loops: complete, with units, and none of it against another."""

import csv
import json
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from real_loops import ARCSEC, AXIS, GAINS, LABELS, J, move, real_survey
from real_scenario import scenario_survey
from shown import shown

from jounce.analysis import Mode, survey
from jounce.analysis.survey_tables import survey_tables
from jounce.app.gate.numbers import bounds_of, is_position, survey_numbers
from jounce.app.result_files import write_survey
from jounce.app.survey_data import survey_data
from jounce.plant import Axis, Inertia, InertiaFeedforward, ServoLoop

EXAMPLE = Path(__file__).parents[2] / "examples" / "telescope.toml"


@pytest.fixture
def quick(monkeypatch):
    """Save empty pictures, where the picture is not the point."""
    monkeypatch.setattr(Figure, "savefig", lambda *args, **_: Path(args[1]).write_bytes(b"picture"))


def test_tables_tell_the_loop_as_it_is():
    text = shown(survey_tables(real_survey()))
    for part in (
        "Requirements",
        "peak of PS",
        "arcsec/(N m)",
        "peak of CS",
        "Unit step, without feedforward",
        "of the linear part",
        "Torque of 10 N m on the load",
        "friction at a reversal",
        "random ones together",
        "Moves, in closed loop",
        "load settled",
        "torque of 150",
        "at the limit",
        "next breakaway",
        "sidereal",
        "missed",
    ):
        assert part in text
    assert "Residual vibration" not in text


def test_open_loop_ringing_is_named_where_it_stands():
    rigid = ServoLoop(Inertia(J), GAINS, InertiaFeedforward(J))
    found = survey(rigid, [move()], modes=[Mode("tower", 6.0, 0.01)], labels=LABELS)
    text = " ".join(shown(survey_tables(found)).split())
    assert "of the commands alone, in open loop" in text
    assert "8.504" in text
    flexible = survey(ServoLoop(AXIS, GAINS, InertiaFeedforward(J)), [move()], labels=LABELS)
    text = shown(survey_tables(flexible))
    assert f"{flexible.moves[0].configured.load_settling_time_s:.4f}" in text
    assert "at the limit" not in text
    assert "breakaway" not in text


def test_a_move_that_does_not_settle_is_followed_for_a_told_time():
    found = real_survey()
    one = found.moves[0]
    response = replace(one.configured, load_settling_time_s=inf)
    moves = (replace(one, responses={**one.responses, "with feedforward": response}),)
    followed = response.response.time[-1]
    assert f"not by {followed:.4g}" in shown(survey_tables(replace(found, moves=moves)))


def test_data_are_strict_json_and_those_of_the_survey():
    found = scenario_survey(EXAMPLE)
    data = json.loads(json.dumps(survey_data(found), allow_nan=False))
    assert data["plant"]["kind"] == "Axis"
    assert data["plant"]["friction"] == {"kind": "Friction", "coulomb": 2.0, "static": 2.5}
    assert data["controller"]["delay"] == 1.5e-3
    assert data["controller"]["filters"][0]["zero_hz"] == 8.485
    assert data["torque_limit"] == 150.0
    assert data["peaks"]["compliance"] == found.compliance.value / ARCSEC
    assert data["disturbance"]["peak"] == found.disturbance.peak / ARCSEC
    assert [entry["kind"] for entry in data["budget"]] == ["random"] * 3 + ["deterministic"]
    assert data["budget"][-1]["torque"] is None
    assert data["limit_cycles"]["simulated"]["slips"] == found.limit_cycles.standstill.slips
    for entry, one in zip(data["moves"], found.moves, strict=True):
        assert entry["left_over"] == one.configured.left_over / ARCSEC
        assert entry["saturated_time_s"] == one.configured.saturated_time_s
        assert entry["responses"][1]["peak_load_error"] == entry["peak_load_error"]
    assert [entry["met"] for entry in data["requirements"]] == [True, True, False, True]
    assert data["requirements"][0]["unit"] == "deg"
    assert data["notes"] == list(found.notes)
    assert data["findings"] == list(found.unmet)


@pytest.mark.usefixtures("quick")
def test_files_hold_load_disturbance_and_tracking(tmp_path):
    found = scenario_survey(EXAMPLE)
    files = {path.name for path in write_survey(found, tmp_path, details=True)}
    assert files == {
        *("survey.json", "survey.png", "details.png", "step.csv"),
        *("move_1_slew.csv", "move_2_smooth_slew.csv"),
        *("disturbance.csv", "tracking_1_sidereal.csv"),
    }
    with (tmp_path / "move_1_slew.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    table = dict(zip(header, np.array(rows, dtype=float).T, strict=True))
    error = table["command_arcsec"] - table["load_with_feedforward_arcsec"]
    peak = found.moves[0].configured.peak_load_error / ARCSEC
    assert np.abs(error).max() == pytest.approx(peak, rel=1e-3)
    with (tmp_path / "disturbance.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    load = np.array(rows, dtype=float)[:, header.index("load_arcsec")]
    assert np.abs(load).max() == pytest.approx(found.disturbance.peak / ARCSEC, rel=1e-3)


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("constant", [2.0, None])
def test_files_tell_the_current_where_the_torque_constant_is_known(tmp_path, constant):
    axis = Axis(J, torque_constant=constant, gear_ratio=5.0)
    loop = ServoLoop(axis, GAINS, InertiaFeedforward(J))
    found = survey(loop, [move()], torque_step=5.0, labels=LABELS)
    write_survey(scenario_survey(EXAMPLE, found), tmp_path)
    for name, of in (("move_1_slew.csv", "_with_feedforward"), ("disturbance.csv", "")):
        with (tmp_path / name).open(newline="") as file:
            header, *rows = csv.reader(file)
        assert any("current" in column for column in header) == (constant is not None)
        table = dict(zip(header, np.array(rows, dtype=float).T, strict=True))
        if constant is not None:
            expected = table[f"torque{of}"] / (5.0 * 2.0)
            np.testing.assert_allclose(table[f"current{of}_A"], expected, rtol=1e-12)
    assert {"position_arcsec", "error_arcsec"} <= set(header)


def test_gate_numbers_are_those_of_the_survey_in_its_unit():
    found = real_survey()
    numbers = {number.key: number for number in survey_numbers(found)}
    assert len(numbers) == len(survey_numbers(found))
    slew = found.moves[0].configured
    for key, value in {
        ("margins", "phase_margin_deg"): found.margins.phase_margin_deg,
        ("moves", "slew", "left_over"): slew.left_over / ARCSEC,
        ("moves", "slew", "saturated_time_s"): slew.saturated_time_s,
        ("moves", "slew", "peak_load_error"): slew.peak_load_error / ARCSEC,
        ("peaks", "compliance"): found.compliance.value / ARCSEC,
        ("disturbance", "recovery_time_s"): found.disturbance.recovery_time_s,
        ("budget", "wind", "load"): found.budget[0].load / ARCSEC,
        ("tracking", "sidereal", "rms_error"): found.tracking[0].rms_error / ARCSEC,
        ("standstill", "swing"): found.limit_cycles.standstill.swing / ARCSEC,
        ("requirements", "slew.peak_torque"): 150.0,
    }.items():
        assert numbers[key].value == value
    positions = {key for key in numbers if is_position(key)}
    assert ("tracking", "sidereal", "peak_error") in positions
    assert ("budget", "wind", "load") in positions
    assert ("budget", "wind", "torque") not in positions
    assert ("standstill", "slips") not in positions
    assert bounds_of(found)["requirements", "load_settling"] == (-inf, 2.0)


def test_numbers_of_an_ideal_loop_are_those_they_were():
    rigid = ServoLoop(Inertia(J), GAINS, InertiaFeedforward(J))
    names = {number.key[-1] for number in survey_numbers(survey(rigid, [move()]))}
    assert not names & {"left_over", "compliance", "load_settling_time_s", "saturated_time_s"}


def test_a_printed_survey_is_the_page_and_its_repr_one_line(capsys):
    found = real_survey()
    print(found)
    printed = capsys.readouterr().out
    for part in ("Requirements", "Loop margins", "Moves, in closed loop", *found.notes):
        assert part in printed
    assert "\n" not in repr(found)
    assert len(repr(found)) < 1000
