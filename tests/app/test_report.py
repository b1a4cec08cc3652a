"""Reports: plain data that any JSON reader takes, tables that lose no unit and no digit."""

import io
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from jounce.app import survey_file
from jounce.app.plan import plan_move
from jounce.app.report import plan_tables, survey_data, survey_tables, switch_rows

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600


@pytest.fixture(scope="module")
def telescope():
    return survey_file(EXAMPLES / "telescope.toml")


@pytest.fixture(scope="module")
def published():
    return survey_file(EXAMPLES / "telescope_published_gains.toml")


def shown(tables, width: int = 160) -> str:
    console = Console(file=io.StringIO(), width=width)
    for table in tables:
        console.print(table)
    return console.file.getvalue()


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


def test_switch_rows_have_full_precision_and_their_units():
    plan = plan_move("2 mm", {1: "1 mm/s", 2: "5 mm/s^2", 3: "40 mm/s^3"})
    header, rows = switch_rows(plan)
    assert header == ["time [s]", "position [mm]", "velocity [mm/s]", "acceleration [mm/s^2]",
                      "jerk [mm/s^3]"]  # fmt: skip
    # Thompson III, case 4: t_w = 1/8, t_v = 1/8 + 1/5, T = 2 + t_v; a jerk-limited start by hand.
    times = [0.0, 0.125, 0.2, 0.325, 2.0, 2.125, 2.2, 2.325]
    np.testing.assert_allclose([row[0] for row in rows], times, rtol=1e-14)
    np.testing.assert_allclose(rows[1], [0.125, 40 * 0.125**3 / 6, 0.3125, 5, 0], rtol=1e-13)
    np.testing.assert_allclose(rows[3], [0.325, 0.1625, 1, 0, 0], rtol=1e-13, atol=1e-13)
    assert [row[-1] for row in rows] == pytest.approx([40, 0, -40, 0, -40, 0, 40, 0])
    np.testing.assert_allclose(rows[-1], [2.325, 2, 0, 0, 0], rtol=1e-14, atol=1e-14)
    assert all(math.copysign(1.0, value) > 0 for row in rows for value in row if value == 0.0)


def plan_of_order(order: int):
    bounds = {order: f"4e{order // 2} mm/s^{order}" if order > 1 else "4 mm/s"}
    return plan_move("2 mm", bounds)


@pytest.mark.parametrize("order", [1, 2, 3, 6, 10])
def test_plan_tables_cut_nothing_off(order):
    plan = plan_of_order(order)
    text = shown(plan_tables(plan))
    assert "…" not in text
    assert f"order {order}" in text
    assert f"{plan.trajectory.duration:.10g} s" in text


def test_plan_tables_keep_their_numbers_in_a_narrow_terminal():
    assert "…" not in shown(plan_tables(plan_of_order(6)), width=80)


@pytest.mark.parametrize("width", [60, 80, 160, 1000])
@pytest.mark.parametrize("order", [2, 6, 11, 14])
def test_no_number_of_the_switch_table_is_broken(order, width):
    """At order 12, "1.53063e-10" once read "1.53063e" above "-10"."""
    bounds = {1: "1 mm/s", order: f"4e{order} mm/s^{order}"}
    plan = plan_move("1 mm", bounds, method="closed-form")
    text = shown([plan_tables(plan)[1]], width)
    assert max(map(len, text.splitlines())) <= width
    blocks = re.split("Switch table", text)[1:]
    assert (len(blocks) == 1) == (order == 2 or width == 1000 or (order, width) == (6, 160))
    header, rows = switch_rows(plan)
    found = []
    for block in blocks:
        lines = [line.split() for line in re.split("─ *\n", block)[-1].splitlines()]
        columns = list(zip(*(line for line in lines if line), strict=True))
        assert len(columns[0]) == len(rows)
        assert [float(time) for time in columns[0]] == pytest.approx([row[0] for row in rows])
        found += columns[1:]
    assert len(found) == order + 1
    for column, values in zip(found, zip(*(row[1:] for row in rows), strict=True), strict=True):
        largest = max(map(abs, values))
        assert [float(n) for n in column] == pytest.approx(values, rel=1e-5, abs=1e-11 * largest)
    for name in header:
        assert all(part in text for part in name.rsplit(" ", 1))


def test_a_plan_of_many_pieces_is_told_in_a_few_lines():
    plan = plan_of_order(6)
    text = shown(plan_tables(plan, pieces=False), width=80)
    assert "Switch table" not in text
    assert f"{len(plan.trajectory.states)} pieces; --pieces prints them" in text
    assert len(text.splitlines()) < 16
    assert max(map(len, text.splitlines())) <= 80
    assert "Switch table" in shown(plan_tables(plan_of_order(3), pieces=False))


def test_plan_tables_tell_how_long_each_limit_binds():
    """Shares by values at many times, and a limit that is only touched."""
    bounds = {1: "1 mm/s", 2: "4 mm/s^2", 3: "16 mm/s^3", 4: "100 mm/s^4"}
    plan = plan_move("3 mm", bounds, method="closed-form")
    lines = shown(plan_tables(plan)).splitlines()
    move, times = plan.trajectory, np.linspace(0.0, plan.trajectory.duration, 200_001)[1:-1]
    for k, name in ((1, "velocity"), (4, "snap")):
        row = next(line for line in lines if line.strip().startswith(name))
        share = float(re.search(r"([\d.]+) % of the time", row).group(1))
        most = plan.limits.bounds(k)[1]
        assert share == pytest.approx(
            100.0 * np.mean(np.abs(move(times, k)) > most * (1.0 - 1e-9)), rel=6e-3
        )
    touching = {4: "1 mm/s^4", 2: f"{move_alone_peak():.12g} mm/s^2"}
    row = next(
        line
        for line in shown(plan_tables(plan_move("3 mm", touching))).splitlines()
        if line.strip().startswith("acceleration")
    )
    assert row.rstrip().endswith("touched")


def move_alone_peak():
    """Return the peak acceleration, in mm/s², of 3 mm with nothing but 1 mm/s⁴ bounded."""
    return 1e3 * plan_move("3 mm", {4: "1 mm/s^4"}).trajectory.peak("acceleration") * (1.0 + 1e-9)


def test_plan_tables_carry_the_units():
    text = shown(plan_tables(plan_of_order(3)))
    for part in ("time [s]", "position [mm]", "velocity [mm/s]", "jerk [mm/s^3]"):
        assert part in text


def test_plan_tables_show_peaks_beside_limits():
    bounds = {2: "-0.1 deg/s^2, 0.2 deg/s^2", 3: "76.8 deg/s^3"}
    lines = shown(plan_tables(plan_move("60 arcsec", bounds))).splitlines()
    row = next(line.split() for line in lines if "acceleration" in line)
    assert "-360" in row
    assert "720" in row
    row = next(line.split() for line in lines if "velocity" in line)
    assert "none" in row


def test_a_plan_without_motion_has_no_negative_zero():
    text = shown(plan_tables(plan_move("0 mm", {2: "1 mm/s^2"})))
    assert not re.search(r"(?<!\S)-0(?!\S)", text)


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
