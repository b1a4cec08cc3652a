"""Reports of surveys: plain data that any JSON reader takes, tables that lose no unit."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from shown import shown

from jounce.analysis.survey_tables import survey_tables
from jounce.app import survey_file
from jounce.app.survey_data import survey_data

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600


def renamed(path: Path, **changes: str):
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return survey_file(path)


def test_data_are_strict_json_with_the_promised_keys(telescope):
    text = json.dumps(survey_data(telescope), allow_nan=False)
    data = json.loads(text)
    assert data["margins"]["crossover_hz"] == pytest.approx(1.0)
    assert data["margins"]["phase_margin_deg"] == pytest.approx(45.0)
    assert data["margins"]["lower_gain_margin_db"] == pytest.approx(12.0)
    assert data["margins"]["upper_gain_margin_db"] is None
    assert data["step"]["overshoot_percent"] == pytest.approx(39.85, abs=0.005)
    assert data["units"]["position"] == "arcsec"
    assert data["units"]["torque"] == "N m"
    first, second = data["moves"]
    assert (first["name"], second["name"]) == ("60 arcsec step", "3600 arcsec step")
    assert first["duration_s"] == pytest.approx(2 * math.sqrt(60 / 720))
    assert first["distance"] == pytest.approx(60.0)
    assert first["settle_to"] == pytest.approx(0.05)
    assert first["peaks"]["acceleration"] == pytest.approx(720.0)
    assert first["peaks"]["velocity"] == pytest.approx(math.sqrt(60 * 720))
    assert first["switch_times_s"] == pytest.approx(
        [0, math.sqrt(60 / 720), 2 * math.sqrt(60 / 720)]
    )
    assert data["findings"] == []


def test_data_of_a_move_are_those_of_the_loop_with_feedforward(telescope):
    for move, found in zip(survey_data(telescope)["moves"], telescope.moves, strict=True):
        by_name = {entry["name"]: entry for entry in move["responses"]}
        assert list(by_name) == list(found.responses)
        configured = by_name["with feedforward"]
        for key in ("settling_time_s", "peak_error", "peak_torque"):
            assert move[key] == configured[key]
        for name, entry in by_name.items():
            response = found.responses[name].response
            assert entry["peak_error"] == pytest.approx(np.abs(response.error).max() / ARCSEC)
            assert entry["peak_torque"] == pytest.approx(np.abs(response.torque).max())
            beyond = response.position.max() / ARCSEC - move["distance"]
            assert entry["overshoot"] == pytest.approx(max(beyond, 0.0), abs=1e-9)


def test_data_of_the_published_gains_say_that_they_miss(published):
    data = survey_data(published)
    assert [entry["met"] for entry in data["design_check"]] == [False] * 3
    assert [entry["achieved"] for entry in data["design_check"]] == pytest.approx(
        [1.750, 73.0, 15.0], abs=0.004
    )
    assert "miss" in data["findings"][0]
    assert data["controller"]["kr"] == pytest.approx(11.09)
    assert data["controller"]["kp"] == pytest.approx(3.187 * 11.09)
    assert data["controller"]["ki"] == pytest.approx(6.286 * 11.09)


def test_the_position_unit_scales_every_position(tmp_path, telescope):
    unit = ('position_unit = "arcsec"', 'position_unit = "deg"')
    data = survey_data(renamed(tmp_path / "deg.toml", unit=unit))
    reference = survey_data(telescope)
    assert data["units"]["position"] == "deg"
    for one, other in zip(data["moves"], reference["moves"], strict=True):
        for key in ("distance", "settle_to"):
            assert one[key] == pytest.approx(other[key] / 3600)
        assert one["peaks"] == pytest.approx({k: v / 3600 for k, v in other["peaks"].items()})
        for mine, theirs in zip(one["responses"], other["responses"], strict=True):
            assert mine["peak_error"] == pytest.approx(theirs["peak_error"] / 3600, abs=1e-12)
            assert mine["overshoot"] == pytest.approx(theirs["overshoot"] / 3600, abs=1e-12)
            assert mine["peak_torque"] == theirs["peak_torque"]
        assert one["duration_s"] == other["duration_s"]


def test_survey_tables_carry_the_numbers(telescope, published):
    text = shown(survey_tables(telescope))
    for part in ("1 Hz", "45 deg", "12 dB", "39.85 %", "0.75645", "0.5774", "4.4721", "12.72"):
        assert part in text
    assert text.count("met") == 3
    assert "…" not in text
    text = shown(survey_tables(published))
    assert text.count("missed") == 3
    for part in ("1.750 Hz", "73.0 deg", "15.0 dB", "21.47 %"):
        assert part in text


def test_survey_tables_carry_the_units(telescope):
    text = shown(survey_tables(telescope))
    for part in ("duration [s]", "settled [s]", "peak error [arcsec]", "peak torque [N m]"):
        assert part in text


def test_survey_tables_show_rounding_errors_as_zero(telescope):
    text = shown(survey_tables(telescope))
    assert "e-1" not in text


@pytest.mark.parametrize("name", ["go [x]", "go [/b]", "go [red]", "go :cat:", r"go \\[x"])
def test_names_are_shown_as_they_are(tmp_path, name):
    found = renamed(tmp_path / "named.toml", name=("3600 arcsec step", name))
    assert name.replace("\\\\", "\\") in shown(survey_tables(found))


def test_a_linear_axis_has_forces(tmp_path):
    path = tmp_path / "stage.toml"
    path.write_text(
        'plant.inertia = "5 kg"\n'
        'controller.gains = {kp = "0.2 N/mm", ki = "50 N/(m s)", kr = "40 N s/m"}\n'
        'limits.axis = {acceleration = "200 mm/s^2"}\n'
        'moves = [{name = "go", distance = "-20 mm", settle_to = "1 um"}]\n'
    )
    found = survey_file(path)
    data = survey_data(found)
    assert data["units"]["torque"] == "N"
    assert data["units"]["inertia"] == "kg"
    assert data["units"]["position"] == "mm"
    assert data["moves"][0]["distance"] == pytest.approx(-20.0)
    assert data["moves"][0]["peak_torque"] == pytest.approx(1.0)
    assert data["design_check"] == []
    assert data["filter"] is None
    text = shown(survey_tables(found))
    assert "peak force" in text
    assert "Design check" not in text


def test_a_margin_that_does_not_exist_is_null_in_the_design_check(tmp_path):
    """PD gains have no lower gain margin; their survey was once refused as not JSON."""
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    gains = 'gains = {kp = "40 N m/rad", ki = "0 N m/(rad s)", kr = "9 N m s/rad"}'
    path = tmp_path / "case.toml"
    path.write_text(text.replace('gains = "design"', gains), encoding="utf-8")
    data = survey_data(survey_file(path))
    achieved = {check["name"]: check["achieved"] for check in data["design_check"]}
    assert achieved["lower gain margin"] is None
    assert json.dumps(data, allow_nan=False)
