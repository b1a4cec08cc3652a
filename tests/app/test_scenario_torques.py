"""Torques that go on, moves of minimum jerk, ways onto a target, and files without moves."""

import json
import math
import re

import numpy as np
import pytest

from jounce.app import survey_file
from jounce.app.gate.conditions import scenario_conditions
from jounce.app.scenario import ScenarioError, load_scenario
from jounce.app.scenario_commands import survey_conditions
from jounce.plant import Ramp, SampledTorque, TorqueSine, TorqueSteps

DEGREE = math.pi / 180
LOOP = """
format = 2
[plant]
inertia = "2 kg m^2"
viscous = "1 N m s/rad"
[controller]
gains = {kp = "800 N m/rad", ki = "4000 N m/(rad s)", kr = "60 N m s/rad"}
sample_time = "1 ms"
delay = "1 ms"
"""
LIMITS = """
[limits.axis]
velocity = "10 deg/s"
acceleration = "20 deg/s^2"
jerk = "200 deg/s^3"
"""
MOVE = """
[[moves]]
name = "go"
distance = "4 deg"
settle_to = "1 arcsec"
"""
SINE = """
[disturbances.torque_sine]
name = "pump"
amplitude = "0.5 N m"
frequency = "3 Hz"
duration = "8 s"
after = "7 s"
"""


STILL = '[[tracking]]\nname = "still"\nrate = "0 deg/s"\nduration = "1 s"\n'


def test_a_sine_s_error_is_the_loop_s_compliance(write):
    found = survey_file(write(LOOP + SINE))
    [held] = found.tracking
    assert held.name == "pump"
    compliance = abs(found.loop.sensitivity().PS(np.exp(2j * np.pi * 3.0 * 1e-3)))
    # PS is that of a torque held over each sample: at 3 Hz of 1 kHz the two are near.
    assert held.peak_error == pytest.approx(0.5 * compliance, rel=2e-3)
    assert held.rms_error == pytest.approx(held.peak_error / math.sqrt(2.0), rel=2e-3)


def test_a_file_s_torque_is_held_until_the_next(write):
    path = write(
        LOOP + '[disturbances]\ntorque_file = {path = "w.csv", unit = "N mm", on = "load"}'
    )
    path.with_name("w.csv").write_text("t,T\n0,0\n0.5,2000\n1.5,-1000\n3.0,0\n")
    [held] = survey_conditions(load_scenario(path))["tracking"]
    assert (held.name, held.duration, held.after) == ("torque file", 3.0, 0.0)
    [torque] = held.disturbance
    assert isinstance(torque, SampledTorque)
    assert torque.on == "load"
    np.testing.assert_allclose(torque.torques, [0.0, 2.0, -1.0, 0.0], rtol=1e-14)
    found = survey_file(path).tracking[0]
    direct = survey_file(path).loop.respond(held.command, times=[1.4], disturbance=torque)
    at = np.interp(1.4, found.response.time, found.response.load_error)
    assert at == pytest.approx(float(direct.load_error[0]), abs=1e-6)


TABLES = """
encoder_spectrum = {frequencies = ["1 Hz", "500 Hz"], densities = ["4 arcsec^2/Hz", "9 mas^2/Hz"]}
[disturbances.torque_spectrum]
frequencies = ["0.1 Hz", "60 rpm", "1 kHz"]
densities = ["2 N^2 m^2/Hz", "4 (N m)^2/Hz", "9 (N cm)^2/Hz"]
on = "motor"
"""


def test_spectra_are_tables_in_the_file_or_beside_it(write):
    path = write(LOOP + STILL + "[disturbances]" + TABLES)
    given = survey_conditions(load_scenario(path))
    [_, torque], [white, noise] = given["wind"], given["encoder_noise"]
    assert (white, torque.on) == (0.0, "motor")
    np.testing.assert_allclose(torque.frequencies_hz, [0.1, 1.0, 1000.0], rtol=1e-14)
    np.testing.assert_allclose(torque.densities, [2.0, 4.0, 9e-4], rtol=1e-14)
    arcsec = DEGREE / 3600
    np.testing.assert_allclose(noise.densities, np.array([4.0, 9e-6]) * arcsec**2, rtol=1e-14)
    path.with_name("t.csv").write_text("Hz;S\n0,1;2\n1;4\n1000;0,0009\n")
    path.with_name("n.csv").write_text("f,x,S\n1,5,4\n500,6,9e-6\n")
    files = 'torque_spectrum = {path = "t.csv", on = "motor"}\n'
    files += 'encoder_spectrum = {path = "n.csv", unit = "arcsec^2/Hz", density = "S"}\n'
    given = survey_conditions(load_scenario(write(LOOP + STILL + "[disturbances]\n" + files)))
    for one, other in ((given["wind"][1], torque), (given["encoder_noise"][1], noise)):
        np.testing.assert_allclose(one.densities, other.densities, rtol=1e-13)
        np.testing.assert_allclose(one.frequencies_hz, other.frequencies_hz, rtol=1e-13)
        assert one.on == other.on


def test_spectra_stand_in_the_error_budget_beside_wind_and_noise(write):
    more = 'wind = {kind = "first_order", sigma = "1 N m", corner = "1 Hz"}'
    more += '\nencoder_noise = "1 arcsec"'
    path = write(LOOP + STILL + "[disturbances]\n" + more + TABLES)
    found = survey_file(path)
    names = ["wind", "torque spectrum", "encoder noise", "encoder spectrum"]
    assert [source.name for source in found.budget] == names
    conditions = survey_conditions(found.scenario)
    expected = found.loop.deviations(conditions["wind"][1])
    assert found.budget[1].load == expected.load
    expected = found.loop.deviations(encoder_noise=conditions["encoder_noise"][1])
    assert (found.budget[3].load, found.budget[3].torque) == (expected.load, expected.torque)
    stored = scenario_conditions(found.scenario)
    told = stored["disturbances", "torque_spectrum", "densities"]
    assert told == "2 4 0.0009 N^2 m^2/Hz"


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"60 rpm"', '"60 s"', "torque_spectrum.frequencies: '60 s' has the wrong dimension"),
        ('"2 N^2 m^2/Hz"', '"2 N m"', "torque_spectrum.densities: '2 N m' has the wrong dimension"),
        ('"2 N^2 m^2/Hz"', '"0 N^2 m^2/Hz"', "densities: '0 N^2 m^2/Hz' is out of range; write a"),
        ('"0.1 Hz", ', "", "torque_spectrum: frequencies of shape (2,) with densities of shape (3"),
        (
            '"0.1 Hz"',
            '"2 Hz"',
            "torque_spectrum: frequencies = [2.0, 1.0, 1000.0]: expected",
        ),
        ('on = "motor"', 'path = "t.csv"', "torque_spectrum: needs a table: write either frequenc"),
        ('densities = ["4 arcsec', 'density = ["4 arcsec', "encoder_spectrum.density: "),
        (TABLES, '\ntorque_spectrum = {path = "no.csv"}', "torque_spectrum: file "),
        (
            TABLES,
            '\ntorque_spectrum = {path = "t.csv", unit = "N m"}',
            "torque_spectrum.unit: 'N m'",
        ),
    ],
)
def test_what_is_no_spectrum_is_one_line(write, old, new, line):
    text = LOOP + STILL + "[disturbances]" + TABLES
    assert old in text
    with pytest.raises(ValueError, match=r"case\.toml: disturbances") as caught:
        survey_conditions(load_scenario(write(text.replace(old, new, 1))))
    assert line in str(caught.value).splitlines()[0]


ACTING = """
[moves.disturbances]
torque_step = {torque = "2 N m", time = "0.2 s", on = "load"}
torque_sine = {amplitude = "0.5 N m", frequency = "3 Hz"}
torque_file = {path = "w.csv", unit = "N mm"}
encoder_noise = "0.1 arcsec"
"""
RANDOM = """
wind = {kind = "first_order", sigma = "1 N m", corner = "1 Hz"}
torque_spectrum = {frequencies = ["1 Hz", "9 Hz"], densities = ["1 N^2 m^2/Hz", "1 N^2 m^2/Hz"]}
encoder_spectrum = {frequencies = ["1 Hz", "9 Hz"], densities = ["9 mas^2/Hz", "9 mas^2/Hz"]}
"""


def test_torques_and_noise_act_on_moves(write):
    path = write(LOOP + LIMITS + MOVE + ACTING)
    path.with_name("w.csv").write_text("t,T\n0,0\n0.5,2000\n1.5,-1000\n")
    found = survey_file(path)
    [surveyed] = found.moves
    response, configured = surveyed.configured.response, surveyed.configured
    torques = [
        TorqueSteps([0.2], [2.0], on="load"),
        TorqueSine(0.5, 3.0),
        SampledTorque([0.0, 0.5, 1.5], [0.0, 2.0, -1.0]),
    ]
    end = float(response.time[-1])
    dt, arcsec = 1e-3, DEGREE / 3600
    count = math.ceil(end / dt)
    noise = 0.1 * arcsec * np.random.default_rng(1 + (3 << 32)).standard_normal(count)
    given = surveyed.move.disturbances.acting(found.loop, end)
    np.testing.assert_allclose(given["noise"], noise, rtol=1e-14)
    direct = found.loop.respond(
        surveyed.trajectory, duration=end, times=response.time, disturbance=torques, noise=noise
    )
    np.testing.assert_allclose(response.load, direct.load, atol=1e-12)
    calm = found.loop.respond(surveyed.trajectory, times=response.time)
    assert configured.peak_load_error > 3.0 * calm.peak_load_error
    stored = scenario_conditions(found.scenario)
    assert stored["moves", "go", "disturbances", "torque_step", "torque"] == "2 N m"
    assert stored["moves", "go", "disturbances", "torque_sine", "frequency"] == "3 Hz"


def test_random_torques_act_by_their_seed_on_moves_and_tracking(write):
    still = STILL + "[tracking.disturbances]" + RANDOM
    text = LOOP + LIMITS + MOVE + "[moves.disturbances]" + RANDOM + still
    path = write(text)
    one, same = (survey_file(path) for _ in range(2))
    other = survey_file(path, overrides={"moves.go.disturbances.seed": 2})
    peaks = [each.moves[0].configured.peak_load_error for each in (one, same, other)]
    assert peaks[0] == peaks[1] != peaks[2]
    conditions = survey_conditions(one.scenario)
    acting = conditions["tracking"][0].acting(one.loop)
    response = one.loop.respond(Ramp(0.0), 1e-3, duration=1.0, **acting)
    assert one.tracking[0].peak_error == pytest.approx(response.peak_load_error, rel=1e-9)
    assert len(acting["disturbance"]) == 2


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("seed = 1", "seed = 0", "moves[0].disturbances.seed: 0 is not a whole number from 1 to"),
        ("seed = 1", "sead = 1", "disturbances.sead: unknown key (with 1); accepted: torque_step,"),
        ('"N mm"', '"mm"', "moves[0].disturbances.torque_file.unit: 'mm' has the wrong dimension"),
        ('"w.csv"', '"v.csv"', "disturbances of 'go': file "),
        ('sample_time = "1 ms"\ndelay = "1 ms"\n', "", "'go': encoder noise in a continuous loop"),
        (MOVE, '[filter]\ncorner = "9 Hz"\norder = 3\n' + MOVE, "disturbances behind a jerk filt"),
    ],
)
def test_what_cannot_act_on_a_move_is_one_line(write, old, new, line):
    text = LOOP + LIMITS + MOVE + ACTING + "seed = 1\n"
    assert old in text
    path = write(text.replace(old, new))
    path.with_name("w.csv").write_text("t,T\n0,0\n0.5,2000\n1.5,-1000\n")
    with pytest.raises(ValueError, match=r"case\.toml: ") as caught:
        survey_file(path)
    assert line in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_names_of_torques_can_be_required(write):
    more = '[requirements.pump]\ntracking_peak = {max = "1 mdeg"}'.replace("1 mdeg", "0.001 deg")
    [check] = survey_file(write(LOOP + SINE + more)).requirements
    assert check.requirement.name == "pump.tracking_peak"
    assert not check.met


def test_a_file_without_moves_is_surveyed_checked_and_told(write, run):
    path = write(
        LOOP + SINE + '[[tracking]]\nname = "stars"\nrate = "sidereal"\nduration = "2 s"\n'
    )
    status, out, _ = run("survey", path, "--output", path.parent / "out")
    assert status == 0
    assert "pump" in out
    told = json.loads((path.parent / "out" / "survey.json").read_text())
    assert told["moves"] == []
    assert [each["name"] for each in told["tracking"]] == ["stars", "pump"]
    assert run("check", path, "--update")[0] == 0
    assert run("check", path)[0] == 0
    output = path.with_name("t.fmu")
    status, _, errors = run("fmu", "export", path, "--block", "trajectory", "--output", output)
    assert status != 0
    assert "has no moves; write [[moves]]" in errors[0]


def test_the_unit_of_positions_without_moves(write):
    dither = '[[tracking]]\nname = "dither"\nsine = {amplitude = "2 arcsec", frequency = "1 Hz"}\n'
    stars = '[[tracking]]\nname = "stars"\nrate = "sidereal"\nduration = "2 s"\n'
    assert load_scenario(write(LOOP + stars)).position_unit == "deg"
    scenario = load_scenario(write(LOOP + dither + 'duration = "2 s"\n'))
    assert scenario.position_unit == "arcsec"


@pytest.mark.parametrize("timing", ["", 'duration = "3 s"\n', 'round_to = "1 ms"\n'])
def test_a_move_of_minimum_jerk_is_as_fast_as_its_bounds_allow(write, timing):
    path = write(LOOP + LIMITS + MOVE + "minimum_jerk = true\n" + timing)
    [move] = survey_file(path).moves
    times = np.linspace(0.0, move.duration_s, 20_001)
    s = times / move.duration_s
    quintic = 4 * DEGREE * (10 * s**3 - 15 * s**4 + 6 * s**5)
    np.testing.assert_allclose(move.trajectory(times), quintic, atol=1e-15)
    steps = [np.gradient(quintic, times)]
    for _ in range(2):
        steps.append(np.gradient(steps[-1], times))
    bounds = (10 * DEGREE, 20 * DEGREE, 200 * DEGREE)
    shares = [abs(d[5:-5]).max() / bound for d, bound in zip(steps, bounds, strict=True)]
    if "duration" in timing:
        assert move.duration_s == 3.0
        assert max(shares) < 1.0
    else:
        assert max(shares) == pytest.approx(1.0, abs=2e-3)
    if "round_to" in timing:
        assert move.duration_s / 1e-3 == pytest.approx(round(move.duration_s / 1e-3), abs=1e-9)


def test_onto_a_target_and_on_with_it(write):
    more = (
        '[[tracking]]\nname = "catch"\nrate = "0.5 deg/s"\nonto = {distance = "3 deg"}\n'
        'duration = "6 s"\nafter = "3 s"\n'
    )
    path = write(LOOP + LIMITS + more)
    [found] = survey_file(path).tracking
    response = found.response
    late = response.time > 3.0
    expected = 3 * DEGREE + 0.5 * DEGREE * response.time[late]
    np.testing.assert_allclose(response.command[late], expected, rtol=1e-12)
    assert response.command[0] == 0.0
    assert found.peak_error < 0.02 * DEGREE


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (LOOP + SINE.replace('duration = "8 s"', ""), "torque_sine: goes on for ever; write dura"),
        (LOOP + SINE.replace('"7 s"', '"9 s"'), "torque_sine: counts errors after 9 s of 8 s;"),
        (LOOP + SINE.replace("0.5 N m", "0.5 N"), "torque_sine.amplitude: '0.5 N' has the wrong"),
        (LOOP + SINE.replace('"3 Hz"', '"0 Hz"'), "torque_sine.frequency: '0 Hz' is out of range"),
        (LOOP, "moves: is missing; write "),
        (LOOP + MOVE, "moves[0].limits: has no limits to keep; write [limits.axis]"),
        (
            LOOP + '[[tracking]]\nname = "a"\nonto = {distance = "1 deg"}\n' + LIMITS,
            "tracking[0]: needs one command",
        ),
        (
            LOOP + SINE + '[disturbances.torque_file]\npath = "w.csv"\nunit = "arcsec"',
            "torque_file.unit: 'arcsec' has the wrong dimension; write the unit of a torque",
        ),
        (
            LOOP + SINE + '[disturbances.torque_file]\npath = "w.csv"\nname = "pump"',
            "torque_file.name: 'pump' is the name of an earlier tracking",
        ),
    ],
)
def test_a_problem_is_one_line(write, text, line):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(write(text))
    assert line in str(caught.value).splitlines()[0]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            LOOP + '[disturbances]\ntorque_file = {path = "none.csv"}',
            "disturbances: torque file: file ",
        ),
        (
            LOOP + LIMITS + MOVE + 'minimum_jerk = true\nduration = "0.2 s"',
            "move 'go': duration = 0.2: a move of minimum jerk takes 1.07",
        ),
        (
            LOOP + LIMITS + 'snap = "1000 deg/s^4"\n' + MOVE + "minimum_jerk = true",
            "move 'go': a move of minimum jerk with a bound on snap: its jerk jumps; leave",
        ),
        (
            LOOP + LIMITS + '[[tracking]]\nname = "a"\nrate = "11 deg/s"\nduration = "3 s"\n'
            'onto = {distance = "1 deg"}',
            "tracking 'a': target velocity",
        ),
    ],
)
def test_what_cannot_be_run_is_one_line(write, text, line):
    with pytest.raises(ValueError, match=r"case\.toml: ") as caught:
        survey_file(write(text))
    assert line in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_sine_is_a_disturbance_of_the_library_s_own(write):
    [held] = survey_conditions(load_scenario(write(LOOP + SINE)))["tracking"]
    assert held.disturbance == (TorqueSine(0.5, 3.0, on="motor"),)


def test_an_exact_inverse_follows_a_file_within_limits_of_snap(write):
    """Undamped it needs the snap, which a follower's motion has when it is averaged."""
    mode = '[[plant.modes]]\nname = "a"\nfrequency = "20 Hz"\ndamping = "0 %"\n'
    text = LOOP.replace("[controller]", mode + 'load_fraction = "40 %"\n[controller]')
    text = text.replace('sample_time = "1 ms"\ndelay = "1 ms"\n', "")
    text += '[feedforward]\ninverse = true\n[[tracking]]\nname = "way"\n'
    text += f'file = {{path = "way.csv", unit = "deg"}}\n{LIMITS}'
    path = write(text + 'snap = "8000 deg/s^4"\n')
    path.with_name("way.csv").write_text("t,x\n0,0\n0.1,0.05\n0.2,0.3\n0.6,0.2\n")
    [way] = survey_conditions(load_scenario(path))["tracking"]
    assert way.command.order == 4
    assert way.command.peak(4) <= 8000.0 * DEGREE * (1.0 + 1e-9)
    assert survey_file(path).tracking[0].peak_error < 1e-12
    for bounds, words in (
        ("", "tracking 'way': snap of .* use limits up to snap at least"),
        ('crackle = "1e6 deg/s^5"\n', "tracking 'way': snap from -inf to inf: expected a bound"),
    ):
        with pytest.raises(ValueError, match=words) as refused:
            survey_file(write(text + bounds))
        assert str(refused.value).count("case.toml") <= 1


LINEAR = """
format = 2
[plant]
mass = "2 kg"
current_limit = "5 A"
force_constant = "20 N/A"
ripple = {period = "1 mm", positions = ["0 mm", "0.5 mm"], forces = ["0.1 N", "-0.1 N"]}
[controller]
gains = {kp = "800 N/m", ki = "4000 N/(m s)", kr = "60 N s/m"}
sample_time = "1 ms"
[disturbances]
force_step = {force = "3 N", time = "0.1 s"}
force_sine = {amplitude = "0.5 N", frequency = "3 Hz", duration = "2 s"}
force_file = {path = "w.csv", unit = "mN", force = "T"}
force_spectrum = {frequencies = ["1 Hz", "9 Hz"], densities = ["1 N^2/Hz", "2 N^2/Hz"]}
[requirements]
peak_force = {max = "40 N"}
[[tracking]]
name = "still"
rate = "0 mm/s"
duration = "1 s"
disturbances.force_step = {force = "1 N"}
"""


def test_a_linear_axis_has_forces_where_another_has_torques(write):
    path = write(LINEAR)
    path.with_name("w.csv").write_text("t,T\n0,0\n0.5,2000\n3.0,0\n")
    forces = load_scenario(path)
    torques = load_scenario(write(re.sub("force(?=_|s| =)|(?<=peak_)force", "torque", LINEAR)))
    assert forces.plant == torques.plant
    assert forces.plant.torque_constant == 20.0
    assert forces.disturbances == torques.disturbances
    assert forces.tracking == torques.tracking
    assert forces.requirements == torques.requirements
    assert scenario_conditions(forces) == scenario_conditions(torques)
    assert survey_conditions(forces)["torque_step"].torques.tolist() == [3.0]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('{force = "3 N"', '{force = "3 N", torque = "3 N"', "has torque and force, which say the"),
        ('{force = "3 N", ', "{", 'has no torque; write torque = "1 N m", or force = "1 N"'),
        ("force_sine", "torque_step = {torque = '1 N'}\nforce_sine", "torque_step and force_step"),
        ('{force = "3 N"', '{force = "3 N m"', "force_step.force: '3 N m' has the wrong dimension"),
    ],
)
def test_forces_that_are_not_right_are_one_line(write, old, new, words):
    with pytest.raises(ValueError, match=words) as refused:
        load_scenario(write(LINEAR.replace(old, new, 1)))
    assert "\n" not in str(refused.value)
