"""Files of format 2: every key reaches its noun, in SI units; what is wrong is one line."""

import math
from pathlib import Path

import control
import numpy as np
import pytest

from jounce.analysis.surveyed_moves import planned
from jounce.app import check_scenario, survey_file
from jounce.app.scenario import load_scenario
from jounce.app.scenario_commands import survey_conditions
from jounce.app.scenario_loop import servo_loop_of
from jounce.app.survey_data import survey_data
from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    Inertia,
    InertiaFeedforward,
    LeadLag,
    LowPass,
    Notch,
    Ramp,
    Ripple,
    Sine,
    chain_axis,
)
from jounce.shaping import Limits, input_shaper, scan_move

EXAMPLES = Path(__file__).parents[2] / "examples"
DEGREE = math.pi / 180
ARCSEC = DEGREE / 3600
REST = """
[limits.axis]
velocity = "10 deg/s"
acceleration = "20 deg/s^2"
[[moves]]
name = "go"
distance = "1 deg"
settle_to = "1 arcsec"
"""
PID_GAINS = 'gains = {kp = "1 N m/rad", ki = "2 N m/(rad s)", kr = "3 N m s/rad"}\n'


def file_of(plant='inertia = "2 kg m^2"', controller=PID_GAINS, more="", rest=REST):
    return f"format = 2\n[plant]\n{plant}\n[controller]\n{controller}\n{more}\n{rest}"


def linear(text):
    return text.replace("deg/s", "mm/s").replace("1 deg", "1 mm").replace("1 arcsec", "1 um")


def loop_of(write, *parts, **named):
    return servo_loop_of(load_scenario(write(file_of(*parts, **named))))


def test_an_inertia_alone_is_the_ideal_loop(write):
    loop = loop_of(write)
    assert loop.plant == Inertia(2.0)
    assert loop.controller == PID(1.0, 2.0, 3.0)
    assert loop.feedforward == InertiaFeedforward(2.0)


def test_the_plant_is_an_axis_in_si_units(write):
    plant = """
inertia = "2 kg m^2"
viscous = "30 N mm s/rad"
load_viscous = "0.1 N m s/rad"
spring = "1 N m/deg"
torque_constant = "0.5 N m/A"
current_limit = "4 A"
gear_ratio = 50
current_lag = "0.3 ms"
encoder_step = "20 arcsec"
sensor = "both"
constant_load = "-3 N m"
friction = {coulomb = "1 N m", static = "1.5 N m"}
ripple = {period = "5 deg", positions = ["0 deg", "1 deg"], torques = ["0 N m", "0.2 N m"]}
modes = [{name = "tower", frequency = "600 rpm", damping = "2 %", load_fraction = "25 %"}]
"""
    cascade = """
gains = {kind = "p-pi", position_gain = "20 1/s", velocity_gain = "5 N m s/rad"}
sample_time = "1 ms"
"""
    scenario = load_scenario(write(file_of(plant, cascade)))
    axis = servo_loop_of(scenario).plant
    assert axis == Axis(
        2.0,
        modes=[FlexibleMode(10.0, 0.02, load_fraction=0.25)],
        viscous=0.03,
        load_viscous=0.1,
        spring=axis.spring,
        torque_constant=0.5,
        torque_limit=100.0,
        gear_ratio=50.0,
        current_lag=3e-4,
        encoder_step=axis.encoder_step,
        sensor="both",
        constant_load=-3.0,
        friction=Friction(1.0, 1.5),
        ripple=Ripple(axis.ripple.positions, (0.0, 0.2), axis.ripple.period),
    )
    assert axis.spring == pytest.approx(1.0 / DEGREE, rel=1e-15)
    assert axis.encoder_step == pytest.approx(20 * ARCSEC, rel=1e-15)
    assert axis.ripple.period == pytest.approx(5 * DEGREE, rel=1e-15)
    assert axis.ripple.positions == pytest.approx((0.0, DEGREE), rel=1e-15)
    assert scenario.gains.position_gain == 20.0


def test_modes_have_shapes_or_are_held(write):
    plant = """
inertia = "2 kg m^2"
modes = [
    {frequency = "10 Hz", motor_shape = 0.5, load_shape = -1},
    {frequency = "30 Hz", motor_shape = 0.1, load_shape = 0.2},
]
"""
    expected = [
        FlexibleMode(10.0, motor_shape=0.5, load_shape=-1.0),
        FlexibleMode(30.0, motor_shape=0.1, load_shape=0.2),
    ]
    assert loop_of(write, plant).plant == Axis(2.0, modes=expected)
    held = plant.replace(
        "motor_shape = 0.5, load_shape = -1", 'held = true, load_fraction = "20 %"'
    )
    held = held.replace("motor_shape = 0.1, load_shape = 0.2", 'held = true, load_fraction = "5 %"')
    axis = loop_of(write, held).plant
    assert [mode.load_fraction for mode in axis.modes] == [0.2, 0.05]
    assert all(mode.held for mode in axis.modes)


def test_chains_and_transfer_functions_are_plants(write):
    chain = 'chain = {masses = ["1 kg", "2000 g"], springs = ["5 N/mm"], dampers = ["3 N s/m"]}'
    gains = 'gains = {kp = "1 N/m", ki = "0 N/(m s)", kr = "3 N s/m"}\n'
    text = linear(file_of(f'{chain}\nforce_limit = "2 kN"\nviscous = "4 N s/m"', gains))
    scenario = load_scenario(write(text))
    assert scenario.inertia == 3.0
    expected = chain_axis([1.0, 2.0], [5000.0], [3.0], torque_limit=2000.0, viscous=4.0)
    assert servo_loop_of(scenario).plant == expected
    transfer = "transfer = {numerator = [3], denominator = [2.0, 0.5, 0]}"
    loop = loop_of(write, transfer)
    s = 2.0j
    assert loop.plant.transfer()(s) == pytest.approx(3.0 / (2.0 * s * s + 0.5 * s))
    assert loop.feedforward is None


def test_mass_is_inertia_of_a_linear_axis(write):
    gains = 'gains = {kp = "1 N/m", ki = "0 N/(m s)", kr = "3 N s/m"}\n'
    assert loop_of(write, 'mass = "2 t"', gains, rest=linear(REST)).plant == Inertia(2000.0)


def test_the_controller_is_digital_with_filters(write):
    controller = PID_GAINS + """
derivative_filter = "5 ms"
sample_time = "1 ms"
delay = "1.5 samples"
anti_windup = {kind = "back-calculation", tracking_time = "0.2 s"}
discretisation = "matched"
filters = [
    NOTCH,
    {kind = "lead-lag", zero = "1 Hz", pole = "10 Hz"},
    {kind = "low-pass", corner = "200 Hz", order = 1},
    {kind = "low-pass", corner = "150 Hz", damping = "60 %"},
]
"""  # fmt: skip
    notch = 'kind = "notch", frequency = "8 Hz", pole_frequency = "9 Hz", zero_damping = "5 %"'
    controller = controller.replace("NOTCH", f'{{{notch}, pole_damping = "50 %"}}')
    assert loop_of(write, controller=controller).controller == Controller(
        PID(1.0, 2.0, 3.0, derivative_filter=5e-3),
        filters=(
            Notch(8.0, 9.0, zero_damping=0.05, pole_damping=0.5),
            LeadLag(1.0, 10.0),
            LowPass(200.0, 1),
            LowPass(150.0, 2, 0.6),
        ),
        sample_time=1e-3,
        delay=1.5e-3,
        anti_windup=BackCalculation(0.2),
        discretisation="matched",
    )


def test_a_filter_may_be_any_transfer_function(write):
    filters = 'filters = [{kind = "transfer", numerator = [1], denominator = [0.01, 1]}]\n'
    (found,) = loop_of(write, controller=PID_GAINS + filters).controller.filters
    assert isinstance(found, control.TransferFunction)
    assert found(2.0j) == pytest.approx(1.0 / (1.0 + 0.02j))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('"none"', None),
        ('"conditional"', "conditional"),
        ('{kind = "clamp", integral_limit = "200 N cm"}', Clamp(2.0)),
    ],
)
def test_anti_windup_is_chosen(write, text, expected):
    controller = PID_GAINS + f'sample_time = "2 ms"\nanti_windup = {text}\n'
    assert loop_of(write, controller=controller).controller.anti_windup == expected


def test_a_cascade_is_what_drives_have(write):
    controller = """
gains.kind = "p-pi"
gains.position_gain = "1.2 m/(min mm)"
gains.velocity_gain = "5 N m s/rad"
gains.reset_time = "50 ms"
gains.velocity_filter = "1 ms"
gains.velocity_feedforward = 0.9
"""  # fmt: skip
    expected = CascadedPI(20.0, 5.0, 0.05, velocity_filter=1e-3, velocity_feedforward=0.9)
    assert loop_of(write, controller=controller).controller == expected


def test_gains_are_tuned_under_bounds(write):
    from jounce.analysis import loop_margins

    controller = """
gains = "tune"
tune = {max_sensitivity = 1.5, max_complementary = 1.4}
sample_time = "1 ms"
delay = "1 ms"
"""
    margins = loop_margins(loop_of(write, controller=controller).loop_transfer())
    assert margins.sensitivity_peak <= 1.5 * (1 + 1e-4)
    assert margins.complementary_peak == pytest.approx(1.4, rel=1e-4)


def test_feedforward_takes_derivatives_friction_and_lead(write):
    digital = PID_GAINS + 'sample_time = "1 ms"\ndelay = "2 ms"\n'
    more = """
[feedforward]
velocity = "0.1 N m s/rad"
acceleration = "2.1 kg m^2"
jerk = "-0.01 N m s^3/rad"
snap = "0.001 N m s^4/rad"
friction = "0.3 N m"
lead = "auto"
"""
    assert loop_of(write, controller=digital, more=more).feedforward == Feedforward(
        {1: 0.1, 2: 2.1, 3: -0.01, 4: 0.001}, friction=0.3, lead=2.5e-3
    )
    less = '[feedforward]\nvelocity = "0.1 N m s/rad"\nlead = "1 sample"\n'
    assert loop_of(write, controller=digital, more=less).feedforward == Feedforward(
        {1: 0.1, 2: 2.0}, lead=1e-3
    )


def test_the_inverse_is_exact_without_damping(write):
    plant = 'inertia = "2 kg m^2"\nmodes = [{frequency = "20 Hz", load_fraction = "60 %"}]'
    found = loop_of(write, plant, more="[feedforward]\ninverse = true\n").feedforward
    omega = 2.0 * math.pi * 20.0
    assert found.torque == pytest.approx({2: 2.0, 4: 2.0 / omega**2})
    assert found.position == pytest.approx({2: 1.0 / (0.4 * omega**2)})


@pytest.mark.parametrize("damping", ["1 %", "5 %"])
def test_the_inverse_of_a_damped_mode_is_exact_too(write, damping):
    plant = f"""
inertia = "2 kg m^2"
viscous = "0.5 N m s/rad"
spring = "4 N m/rad"
modes = [{{frequency = "20 Hz", damping = "{damping}", load_fraction = "60 %"}}]
"""
    gains = 'gains = {kp = "3e3 N m/rad", ki = "9e3 N m/(rad s)", kr = "300 N m s/rad"}'
    limits = REST.replace('"20 deg/s^2"', '"20 deg/s^2"\njerk = "400 deg/s^3"')
    more = "[feedforward]\ninverse = true\n"
    scenario = load_scenario(write(file_of(plant, gains, more, limits)))
    (move,) = scenario.moves
    response = servo_loop_of(scenario).respond(planned(move), 0.01)
    assert response.peak_load_error < 1e-12 * move.distance


def test_an_inverse_that_is_unstable_is_one_line_with_its_remedy(write):
    shapes = "motor_shape = 1.4, load_shape = -1.3"
    plant = f'inertia = "2 kg m^2"\nmodes = [{{frequency = "20 Hz", {shapes}}}]'
    path = write(file_of(plant, more="[feedforward]\ninverse = true\n"))
    with pytest.raises(ValueError, match=r"case\.toml: feedforward: ") as caught:
        servo_loop_of(load_scenario(path))
    assert "unstable, with a pole at" in str(caught.value)
    assert str(caught.value).endswith('; write inverse = "low-frequency", exact up to snap')


def test_moves_are_shaped_timed_and_rounded(write):
    plant = """
inertia = "2 kg m^2"
modes = [{name = "tower", frequency = "10 Hz", damping = "1 %", load_fraction = "36 %"}]
"""
    more = """
shaper = {kind = "ZVD", modes = ["tower", "mirror"]}
modes = [{name = "mirror", frequency = "3 Hz"}]
"""
    rest = (
        REST
        + """
duration = "2 s"
round_to = "4 ms"
[[moves]]
name = "bare"
distance = "2 deg"
settle_to = "1 arcsec"
shaper = "none"
[[moves]]
name = "other"
distance = "2 deg"
settle_to = "1 arcsec"
shaper = {kind = "EI", frequency = "4 Hz", vibration = "3 %"}
"""
    )
    go, bare, other = load_scenario(write(more + file_of(plant, rest=rest))).moves
    assert (go.duration, go.round_to, bare.duration, bare.round_to) == (2.0, 4e-3, None, None)
    held = input_shaper("ZVD", 8.0, 0.008)  # with the motor held: sqrt(1 - 0.36) of the free one
    for shaper, expected in zip(go.shapers, (held, input_shaper("ZVD", 3.0)), strict=True):
        np.testing.assert_allclose(shaper.times, expected.times, rtol=1e-14)
        np.testing.assert_allclose(shaper.amplitudes, expected.amplitudes, rtol=1e-14)
    assert bare.shapers == ()
    expected = input_shaper("EI", 4.0, vibration=0.03)
    np.testing.assert_allclose(other.shapers[0].amplitudes, expected.amplitudes, rtol=1e-14)


def test_tracking_disturbances_and_requirements_are_for_the_survey(write):
    write(file_of()).with_name("scan.csv").write_text("t,x\n0,0\n0.5,1\n1,1\n")
    more = """
[[tracking]]
name = "dither"
rate = "1 deg/s"
sine = {amplitude = "2 arcsec", frequency = "3 Hz"}
duration = "5 s"
after = "1 s"
[[tracking]]
name = "scan"
scan = {length = "4 deg", rate = "2 deg/s", lines = 3}
[[tracking]]
name = "recorded"
file = {path = "scan.csv", unit = "arcmin"}
[disturbances]
torque_step = {torque = "2 N m", time = "0.5 s", on = "load"}
wind = {kind = "first_order", sigma = "3 N m", corner = "0.2 Hz"}
encoder_noise = "0.1 arcsec"
[requirements]
load_settling = {max = "2000 ms"}
phase_margin = {min = "0.5 rad", max = "80 deg"}
sensitivity_peak = {max = 2}
[requirements.go]
peak_torque = {max = "2 N m"}
[requirements.dither]
tracking_rms = {max = "1 arcsec"}
"""
    given = survey_conditions(load_scenario(write(file_of(more=more))))
    dither, scan, recorded = given["tracking"]
    assert dither.command == Ramp(DEGREE) + Sine(dither.command.parts[1].amplitude, 3.0)
    assert (dither.duration, dither.after) == (5.0, 1.0)
    limits = Limits.from_bounds((10 * DEGREE, 20 * DEGREE))
    planned = scan_move(4 * DEGREE, 2 * DEGREE, limits, lines=3).trajectory
    np.testing.assert_allclose(scan.command.breaks, planned.breaks, rtol=1e-12)
    np.testing.assert_allclose(scan.command.states, planned.states, rtol=1e-12, atol=1e-12)
    assert scan.duration == planned.duration == pytest.approx(scan.command.duration)
    assert float(recorded.command.end_state[0]) == pytest.approx(DEGREE / 60)
    assert given["torque_step"].times.tolist() == [0.5]
    assert given["torque_step"].torques.tolist() == [2.0]
    assert given["torque_step"].on == given["wind"].on == "load"
    assert (given["wind"].sigma, given["wind"].corner_hz) == (3.0, 0.2)
    assert given["encoder_noise"] == pytest.approx(0.1 * ARCSEC)
    found = {r.name: (r.least, r.most) for r in given["requirements"]}
    assert found == {
        "load_settling": (None, 2.0),
        "phase_margin": (pytest.approx(math.degrees(0.5)), 80.0),
        "sensitivity_peak": (None, 2.0),
        "go.peak_torque": (None, 2.0),
        "dither.tracking_rms": (None, pytest.approx(ARCSEC)),
    }


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("25 nm", 25e-9), ("0.5 um", 0.5e-6), ("2 mil", 50.8e-6), ("0.001 ft", 0.3048e-3),
        ("0.01 inch", 0.254e-3), ("3 count", 30e-9), ("2.5e2 counts", 2.5e-6),
    ],
)  # fmt: skip
def test_every_unit_of_length_is_taken(write, text, value):
    gains = 'gains = {kp = "1 N/m", ki = "0 N/(m s)", kr = "3 N s/m"}\n'
    rest = linear(REST).replace('"1 um"', f'"{text}"')
    plant = 'mass = "2 kg"\nencoder_step = "10 nm"'
    (move,) = load_scenario(write(file_of(plant, gains, rest=rest))).moves
    assert move.settle_to == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("plant", "count"),
    [
        ('encoder_step = "2 arcsec"', 2 * ARCSEC),
        ("encoder_counts = 1048576", 2.0 * math.pi / 2**20),
    ],
)
def test_positions_are_told_in_counts(write, plant, count):
    rest = REST.replace('"1 deg"', '"3600 counts"').replace("10 deg/s", "9000 count/s")
    plant = f'inertia = "2 kg m^2"\n{plant}'
    scenario = load_scenario(write('position_unit = "count"\n' + file_of(plant, rest=rest)))
    assert scenario.position_unit == "count"
    assert scenario.position_scale == pytest.approx(count, rel=1e-15)
    assert scenario.moves[0].distance == pytest.approx(3600 * count, rel=1e-14)
    assert scenario.moves[0].bounds[0] == pytest.approx(9000 * count, rel=1e-14)
    assert servo_loop_of(scenario).axis.encoder_step == pytest.approx(count, rel=1e-15)


def test_a_survey_and_the_gate_tell_counts(write):
    gains = 'gains = {kp = "800 N m/rad", ki = "4e3 N m/(rad s)", kr = "60 N m s/rad"}\n'
    plant = 'inertia = "2 kg m^2"\nencoder_counts = 1048576'
    rest = '[[tracking]]\nname = "still"\nrate = "0 deg/s"\nduration = "1 s"\n'
    gains += 'sample_time = "1 ms"\n'
    path = write('position_unit = "count"\n' + file_of(plant, gains, rest=rest))
    found = survey_file(path)
    told = survey_data(found)
    assert told["units"]["position"] == "count"
    assert found.labels.unit_of("compliance")[0] == "count/(N m)"
    [quantisation] = told["budget"]
    count = 2.0 * math.pi / 2**20
    assert quantisation["load"] == pytest.approx(found.budget[0].load / count, rel=1e-12)
    assert check_scenario(path, update=True).position_unit == "count"


def test_counts_are_units_wherever_there_are_positions(write):
    more = """
[disturbances]
encoder_noise = "0.5 count"
encoder_spectrum = {frequencies = ["1 Hz", "9 Hz"], densities = ["3 count^2/Hz", "3 count²/Hz"]}
torque_step = {torque = "1 N m"}
[[tracking]]
name = "recorded"
file = {path = "scan.csv", unit = "count"}
[requirements]
peak_load_error = {max = "30 counts"}
"""
    plant = 'inertia = "2 kg m^2"\nviscous = "3 N m s/count"\nencoder_step = "2 arcsec"'
    gains = PID_GAINS.replace("2 N m/(rad s)", "2 N m/(count s)") + 'sample_time = "1 ms"\n'
    path = write(file_of(plant, gains, more))
    path.with_name("scan.csv").write_text("t,x\n0,0\n0.5,1\n1,100\n")
    scenario = load_scenario(path)
    count = 2 * ARCSEC
    assert scenario.plant.viscous == pytest.approx(3.0 / count, rel=1e-14)
    assert scenario.gains.ki == pytest.approx(2.0 / count, rel=1e-14)
    given = survey_conditions(scenario)
    white, table = given["encoder_noise"]
    assert white == pytest.approx(0.5 * count, rel=1e-14)
    np.testing.assert_allclose(table.densities, 3.0 * count**2, rtol=1e-14)
    end = float(given["tracking"][0].command.end_state[0])
    assert end == pytest.approx(100 * count, rel=1e-12)
    assert given["requirements"][0].most == pytest.approx(30 * count, rel=1e-14)


@pytest.mark.parametrize(
    ("plant", "unit", "line"),
    [
        ("", "count", "position_unit: 'count' is in counts of an encoder that is not given; write"),
        ("encoder_counts = 0", "deg", "encoder_counts: 0 is not a whole number from 1 to"),
        ('encoder_counts = 9\nencoder_step = "1 deg"', "deg", "which say the same; keep one"),
    ],
)
def test_counts_of_no_encoder_are_one_line(write, plant, unit, line):
    text = file_of(f'inertia = "2 kg m^2"\n{plant}')
    with pytest.raises(ValueError, match=r"case\.toml: ") as caught:
        load_scenario(write(f'position_unit = "{unit}"\n' + text))
    assert line in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_linear_axis_has_no_counts_of_a_revolution(write):
    gains = 'gains = {kp = "1 N/m", ki = "0 N/(m s)", kr = "3 N s/m"}\n'
    path = write(file_of('mass = "2 kg"\nencoder_counts = 90', gains, rest=linear(REST)))
    with pytest.raises(ValueError, match="90 a revolution, and a linear axis has none; write enc"):
        servo_loop_of(load_scenario(path))


def test_moves_in_counts_are_told_in_the_encoder_s_unit(write):
    rest = REST.replace('"1 deg"', '"3600 count"')
    scenario = load_scenario(
        write(file_of('inertia = "2 kg m^2"\nencoder_step = "2 arcsec"', rest=rest))
    )
    assert scenario.position_unit == "arcsec"
    assert scenario.moves[0].distance == pytest.approx(2 * DEGREE, rel=1e-14)
