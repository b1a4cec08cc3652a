"""Reports of planned moves: tables that lose no unit and break no number."""

import math
import re
from itertools import product

import numpy as np
import pytest
from shown import shown
from tiers import some

from jounce.app.plan import plan_move
from jounce.app.plan_report import plan_tables, switch_rows


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


def test_bounds_on_position_have_a_row_and_one_of_zero_is_not_told_as_touched_at_rest():
    bounds = {1: "0 m/s, 20 m/s", 2: "-4 m/s^2, 1 m/s^2"}
    text = shown(plan_tables(plan_move("60 m", bounds, position="0 m, 70 m")))
    position, velocity = (
        next(line for line in text.splitlines() if line.split()[:1] == [name])
        for name in ("position", "velocity")
    )
    assert position.split() == ["position", "0", "…", "60", "0", "…", "70", "m"]
    assert velocity.split()[2:] == ["0", "…", "20", "m/s"]


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


@pytest.mark.parametrize(("width", "order"), some(product([60, 80, 160, 1000], [2, 6, 11, 14]), 6))
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
