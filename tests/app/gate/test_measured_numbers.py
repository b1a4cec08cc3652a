"""The gate on measured numbers: error bars in baselines, bounds and regressions."""

import numpy as np
import pytest

from jounce.analysis import MeasuredResponse, loop_margins
from jounce.app.gate.baseline import Baseline, Stored, load_baseline
from jounce.app.gate.check_file import CheckError, Checks, Requirement, load_checks
from jounce.app.gate.comparison import compare, measured_baseline
from jounce.app.gate.numbers import Number, measured_numbers
from jounce.plant import PID

KEY = ("margins", "phase_margin_deg")
LINES = np.arange(1.0, 80.0)
S = 2j * np.pi * LINES


def measured(seed=0, gain=1.0, noise=1e-3):
    rng = np.random.default_rng(seed)
    exact = gain * 900.0 / (S * (S + 30.0))
    off = noise * (rng.normal(size=79) + 1j * rng.normal(size=79)) / np.sqrt(2)
    return MeasuredResponse(LINES, exact * (1 + off), noise * abs(exact), kind="loop")


def verdict(value, sigma, was=None, **asked):
    checks = Checks(requirements={KEY: Requirement(**asked)})
    stored = None if was is None else Baseline("s", None, {KEY: Stored(was, 1e-6, 0.0, 0.3)})
    [row] = compare([Number(KEY, value, "higher", sigma=sigma)], stored, checks)
    return row.verdict


def test_a_measured_number_changes_beyond_three_deviations_of_the_difference():
    width = 3 * np.hypot(0.4, 0.3)
    assert verdict(45.0 - 0.99 * width, 0.4, was=45.0) == "same"
    assert verdict(45.0 - 1.01 * width, 0.4, was=45.0) == "worse"
    assert verdict(45.0 + 1.01 * width, 0.4, was=45.0) == "better"
    assert verdict(45.0 - 0.8 * width, 0.4, was=45.0, sigmas=2.0) == "worse"


def test_a_bound_fails_where_it_is_broken_for_sure():
    assert verdict(40.9, 0.4, least=40.0, sigmas=2.0) == "within"
    assert verdict(40.5, 0.4, least=40.0, sigmas=2.0) == "unsure"
    assert verdict(39.3, 0.4, least=40.0, sigmas=2.0) == "unsure"
    assert verdict(39.1, 0.4, least=40.0, sigmas=2.0) == "outside"
    assert verdict(39.9, 0.4, least=40.0) == "outside"


def test_deviations_are_stored_and_read_again(tmp_path):
    numbers = measured_numbers(loop_margins(measured()))
    stored = measured_baseline(numbers, None, Checks())
    stored.write(tmp_path / "baseline.json")
    again = load_baseline(tmp_path / "baseline.json")
    assert again.numbers == stored.numbers
    assert again.numbers[KEY].sigma == pytest.approx(
        loop_margins(measured()).phase_margin_deg_sigma
    )
    assert ("margins", "upper_gain_margin_db") not in again.numbers
    text = (tmp_path / "baseline.json").read_text(encoding="utf-8")
    (tmp_path / "baseline.json").write_text(
        text.replace('"sigma": ', '"sigma": -'), encoding="utf-8"
    )
    with pytest.raises(CheckError, match="sigma = -"):
        load_baseline(tmp_path / "baseline.json")


def test_the_check_file_asks_for_deviations(tmp_path):
    numbers = measured_numbers(loop_margins(measured()))
    path = tmp_path / "axis.check.toml"
    path.write_text("phase_margin_deg = { min = 40, sigmas = 2 }\n", encoding="utf-8")
    assert load_checks(path, numbers).of(KEY) == Requirement(least=40.0, sigmas=2.0)
    path.write_text("phase_margin_deg = { min = 40, sigmas = -2 }\n", encoding="utf-8")
    with pytest.raises(CheckError, match="sigmas = -2 is below zero"):
        load_checks(path, numbers)


def test_another_measurement_of_the_same_loop_passes_and_another_loop_fails(
    margins_regression, tmp_path
):
    path = tmp_path / "kept.json"
    with pytest.raises(pytest.fail.Exception):
        margins_regression.check(measured(), fullpath=path)
    margins_regression.check(measured(seed=1), fullpath=path)
    with pytest.raises(AssertionError, match="differ from"):
        margins_regression.check(measured(seed=2, gain=1.1), fullpath=path)


def test_a_plant_is_kept_with_its_controller(margins_regression, tmp_path):
    plant = MeasuredResponse(LINES, 1 / (S * (S + 30.0)), kind="plant")
    path = tmp_path / "kept.json"
    with pytest.raises(pytest.fail.Exception):
        margins_regression.check(plant, controller=PID(900.0, 0.0, 0.0), fullpath=path)
    margins_regression.check(plant, controller=PID(900.0, 0.0, 0.0), fullpath=path)
    with pytest.raises(AssertionError, match="there are no margins to keep"):
        margins_regression.check(plant, controller=PID(1.0, 0.0, 0.0), fullpath=path)
