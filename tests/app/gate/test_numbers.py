"""What the gate measures: the survey's own numbers, in the scenario's unit, and no rounding."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import control
import pytest
from scipy.integrate import solve_ivp

from jounce.analysis import loop_margins
from jounce.analysis.specification import Mode
from jounce.app import load_scenario, survey_file
from jounce.app.gate.numbers import RTOL, Number, is_position, loop_numbers, survey_numbers
from jounce.app.scenario import FilterSection
from jounce.app.survey_data import survey_data

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def rubin():
    return load_scenario(EXAMPLES / "rubin_mount.toml")


def values(numbers) -> dict[str, float]:
    found = {number.name: number.value for number in numbers}
    assert len(found) == len(numbers), "a name is given twice"
    return found


def test_every_number_is_the_survey_files(rubin):
    found = survey_file(rubin)
    numbers, data = values(survey_numbers(found)), survey_data(found)
    for name, value in numbers.items():
        section, *rest = name.split(".")
        if section != "moves":
            (key,) = rest
            stored = data[section][key]
            assert value == (math.inf if stored is None else stored), name
    for move in data["moves"]:
        start = f'moves."{move["name"]}"'
        for key in ("duration_s", "settling_time_s", "peak_error", "peak_torque"):
            assert numbers[f"{start}.{key}"] == move[key]
        for derivative, peak in move["peaks"].items():
            assert numbers[f"{start}.peaks.{derivative}"] == peak
        varied = move["responses"][2:]
        for key in ("settling_time_s", "peak_error"):
            assert numbers[f"{start}.varied_{key}"] == max(entry[key] for entry in varied)


def test_positions_are_what_another_unit_changes():
    """And their rounding with them; a mode's name does not matter."""
    modes = (Mode("duration_s", 3.0, 0.01),)
    scenario = replace(load_scenario(EXAMPLES / "telescope.toml"), modes=modes)
    found = survey_file(scenario)
    other = survey_file(replace(scenario, position_unit="deg"))
    pairs = list(zip(survey_numbers(found), survey_numbers(other), strict=True))
    for number, same in pairs:
        ratio = 3600.0 if is_position(number.key) else 1.0
        assert number.value == pytest.approx(same.value * ratio, rel=1e-12, abs=0.0), number.name
        assert number.atol == pytest.approx(same.atol * ratio, rel=1e-12, abs=0.0)
    assert sum(is_position(number.key) for number, _ in pairs) == 2 * 6


def test_derivatives_beyond_pop_have_plain_names(rubin):
    bounds = tuple(10.0**k for k in range(1, 8))
    moves = (replace(rubin.moves[0], name="go", bounds=bounds),)
    names = values(survey_numbers(survey_file(replace(rubin, moves=moves))))
    assert [name for name in names if ".peaks." in name][-2:] == [
        "moves.go.peaks.pop",
        "moves.go.peaks.derivative_7",
    ]


def test_positions_are_in_the_scenarios_unit(rubin):
    degrees = survey_numbers(survey_file(rubin))
    arcsec = survey_numbers(survey_file(replace(rubin, position_unit="arcsec")))
    for before, after in zip(degrees, arcsec, strict=True):
        name = before.name
        position = name.endswith(("_error", "overshoot")) or ".peaks." in name
        factor = 3600.0 if position else 1.0
        assert after.value == pytest.approx(factor * before.value, rel=1e-12), name
        expected = factor * before.atol if position else before.atol
        assert after.atol == pytest.approx(expected, rel=1e-12), name


@pytest.mark.parametrize("change", [1e-15, -3e-14, 1e-13])
def test_rounding_stays_far_within_the_tolerance(rubin, change):
    """So that another machine's last digits are no regression."""
    nudged = replace(
        rubin,
        inertia=rubin.inertia * (1.0 + change),
        feedforward_inertia=rubin.feedforward_inertia * (1.0 + 2.0 * change),
        moves=tuple(replace(m, distance=m.distance * (1.0 + change)) for m in rubin.moves),
    )
    for was, now in zip(
        survey_numbers(survey_file(rubin)), survey_numbers(survey_file(nudged)), strict=True
    ):
        tolerance = max(RTOL * abs(was.value), was.atol)
        same = was.value == now.value or abs(was.value - now.value) < 0.01 * tolerance
        assert same, (was, now)


def test_tight_settling_leaves_room_for_rounding(rubin):
    move = replace(rubin.moves[0], settle_to=1e-10 * rubin.moves[0].distance)
    numbers = survey_numbers(survey_file(replace(rubin, moves=(move,))))
    error = next(number for number in numbers if number.key[-1] == "peak_error")
    assert 0.0 < error.value < 0.1 * error.atol


def test_a_loop_that_never_crosses_has_no_crossover():
    numbers = values(loop_numbers(loop_margins(control.tf([0.5], [1.0, 1.0]))))
    assert math.isnan(numbers["margins.crossover_hz"])
    assert numbers["margins.phase_margin_deg"] == math.inf
    assert numbers["margins.upper_gain_margin_db"] == math.inf


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan])
@pytest.mark.parametrize(("better", "absent"), [("higher", "inf"), ("lower", "inf"), (None, "nan")])
def test_what_does_not_exist_has_one_value(value, better, absent):
    assert str(Number(("x",), value, better).value) == absent


def rung_amplitude(move, mode) -> float:
    """Return how far a mode rings after a move, by integrating its deflection."""
    omega, zeta = 2.0 * math.pi * mode.frequency_hz, mode.damping
    trajectory, end = move.trajectory, move.trajectory.duration

    def slope(t, state):
        acceleration = float(trajectory(t, 2))
        return state[1], -acceleration - 2.0 * zeta * omega * state[1] - omega**2 * state[0]

    state = [0.0, 0.0]
    for start, stop in pairwise(trajectory.breaks):
        inside = (start + 1e-12 * end, stop - 1e-12 * end)  # not beyond a jump of the acceleration
        state = solve_ivp(slope, inside, state, rtol=1e-10, atol=1e-15).y[:, -1]
    damped = omega * math.sqrt(1.0 - zeta**2)
    return math.hypot(state[0], (state[1] + zeta * omega * state[0]) / damped)


def test_residual_vibration_of_every_mode(rubin):
    modes = (Mode("tower", 1.7, 0.02), Mode("pier", 0.4))
    found = survey_file(replace(rubin, modes=modes))
    numbers = values(survey_numbers(found))
    for move in found.moves:
        for mode in modes:
            expected = rung_amplitude(move, mode) / found.scenario.position_scale
            name = f'moves."{move.name}".residual_vibration.{mode.name}'
            assert numbers[name] == pytest.approx(expected, rel=1e-6, abs=1e-8), name


def test_the_filter_takes_vibration_away(rubin):
    modes = (Mode("tower", 3.0),)
    plain = survey_numbers(survey_file(replace(rubin, modes=modes)))
    behind = FilterSection(corner_hz=2.0, order=6)
    smooth = survey_numbers(survey_file(replace(rubin, modes=modes, filter=behind)))
    gain = abs(1.0 + 1j * 3.0 / 2.0) ** -6.0
    for was, now in zip(plain, smooth, strict=True):
        if "residual_vibration" in was.key:
            assert now.value == pytest.approx(gain * was.value, rel=1e-9)


def test_a_mode_that_decays_as_the_filter_does_is_named(rubin):
    scenario = replace(
        rubin, modes=(Mode("tower", 2.0, 0.999),), filter=FilterSection(corner_hz=2.0, order=6)
    )
    with pytest.raises(ValueError, match="mode 'tower': a mode decays as the lags of") as refusal:
        survey_file(scenario)
    assert str(scenario.path) in str(refusal.value)
