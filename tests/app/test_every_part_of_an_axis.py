"""What a real axis can be, part by part: the noun of Python and the lines of a file are one."""

from dataclasses import replace

import control
import numpy as np
import pytest

from jounce.analysis import Disturbances
from jounce.analysis.planned_moves import planned
from jounce.app.gate.conditions import scenario_conditions
from jounce.app.scenario import load_scenario
from jounce.app.scenario_commands import moves_of, survey_conditions
from jounce.app.scenario_loop import jerk_filter_of, servo_loop_of
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
    LeadLag,
    LowPass,
    Notch,
    Ramp,
    Ripple,
    ServoLoop,
    Sine,
    Spectrum,
    TorqueSine,
    TorqueSteps,
    Wind,
    chain_axis,
    inverse_feedforward,
    low_frequency_feedforward,
    system_axis,
)
from jounce.shaping import JerkFilter, Limits, input_shaper, min_jerk_move, min_time_move, scan_move

LAW = PID(800.0, 4000.0, 60.0)
GAINS = 'gains = {kp = "800 N/m", ki = "4000 N/(m s)", kr = "60 N s/m"}'
LIMITS = Limits(velocity=0.5, acceleration=2.0, jerk=40.0)
FILE = """
format = 2
[plant]
{plant}
[controller]
{controller}
{more}
[limits.axis]
velocity = "0.5 m/s"
acceleration = "2 m/s^2"
jerk = "40 m/s^3"
[[moves]]
name = "go"
distance = "0.4 m"
settle_to = "1 um"
{move}
"""
MASS = 'mass = "2 kg"'


@pytest.fixture
def read(write):
    """Return what reads a file of these lines."""

    def scenario(plant=MASS, controller=GAINS, more="", move=""):
        return load_scenario(
            write(FILE.format(plant=plant, controller=controller, more=more, move=move))
        )

    return scenario


HELD = [
    FlexibleMode(6.0, 0.01, load_fraction=0.3, held=True),
    FlexibleMode(11.0, 0.02, load_fraction=0.2, held=True),
]
ZPK = control.zpk([-5.0], [0.0, 0.0, -2.0 + 5.0j, -2.0 - 5.0j, -90.0], 3.0)
STATES = control.ss([[0.0, 1.0], [0.0, -0.5]], [[0.0], [2.0]], [[1.0, 0.0]], [[0.0]])
PLANTS = [
    (MASS, Inertia(2.0)),
    ('viscous = "3 N s/m"\nspring = "5 N/m"', Axis(2.0, viscous=3.0, spring=5.0)),
    ('load_viscous = "3 N s/m"', Axis(2.0, load_viscous=3.0)),
    (
        'modes = [{frequency = "6 Hz", damping = "1 %", load_fraction = "30 %"}]',
        Axis(2.0, modes=[FlexibleMode(6.0, 0.01, load_fraction=0.3)]),
    ),
    (
        'modes = [{frequency = "6 Hz", damping = "1 %", load_fraction = "30 %", held = true}, '
        '{frequency = "11 Hz", damping = "2 %", load_fraction = "20 %", held = true}]',
        Axis(2.0, modes=HELD),
    ),
    (
        'modes = [{frequency = "6 Hz", motor_shape = 0.5, load_shape = -1.0}]',
        Axis(2.0, modes=[FlexibleMode(6.0, motor_shape=0.5, load_shape=-1.0)]),
    ),
    (
        'chain = {masses = ["1 kg", "2 kg"], springs = ["9 N/m"], dampers = ["1 N s/m"]}',
        chain_axis([1.0, 2.0], [9.0], [1.0]),
    ),
    (
        "transfer = {numerator = [3.0], denominator = [2.0, 0.5, 0.0]}",
        system_axis(control.tf([3.0], [2.0, 0.5, 0.0])),
    ),
    (
        "transfer = {zeros = [-5.0], poles = [0, 0, [-2.0, 5.0], -90.0], gain = 3.0}",
        system_axis(ZPK),
    ),
    ("transfer = {a = [[0, 1], [0, -0.5]], b = [0, 2], c = [1, 0]}", system_axis(STATES)),
    ('gear_ratio = 5\ntorque_constant = "3 N/A"', Axis(2.0, gear_ratio=5, torque_constant=3)),
    ('constant_load = "-3 N"', Axis(2.0, constant_load=-3.0)),
    (
        'ripple = {period = "10 mm", amplitude = "0.1 N"}',
        Axis(2.0, ripple=Ripple.sine(0.1, 0.01)),
    ),
    ('friction = {coulomb = "1 N", static = "2 N"}', Axis(2.0, friction=Friction(1.0, 2.0))),
    ('force_limit = "9 N"', Axis(2.0, torque_limit=9.0)),
    (
        'current_limit = "2 A"\ntorque_constant = "3 N/A"\ngear_ratio = 5',
        Axis(2.0, torque_limit=30.0, torque_constant=3.0, gear_ratio=5.0),
    ),
    ('encoder_step = "1 um"\ncurrent_lag = "1 ms"', Axis(2.0, encoder_step=1e-6, current_lag=1e-3)),
    ('sensor = "both"', Axis(2.0, sensor="both")),
]


@pytest.mark.parametrize(("lines", "expected"), PLANTS, ids=range(len(PLANTS)))
def test_plants(read, lines, expected):
    whole = "mass" in lines or "chain" in lines or "transfer" in lines
    plant = servo_loop_of(read(lines if whole else f"{MASS}\n{lines}")).plant
    if "transfer" in lines:
        s = 3.0j
        assert plant.transfer()(s) == pytest.approx(expected.transfer()(s), rel=1e-12)
    else:
        assert plant == expected


DIGITAL = f'{GAINS}\nsample_time = "1 ms"\n'
CONTROLLERS = [
    (f'{GAINS}\nderivative_filter = "2 ms"', replace(LAW, derivative_filter=2e-3)),
    (DIGITAL + 'delay = "1.7 ms"', Controller(LAW, sample_time=1e-3, delay=1.7e-3)),
    (
        'gains = {kind = "p-pi", position_gain = "20 1/s", velocity_gain = "5 N s/m", '
        'reset_time = "50 ms"}',
        CascadedPI(20.0, 5.0, 0.05),
    ),
    *(
        (
            DIGITAL + f"filters = [{{{lines}}}]\ndiscretisation = {way!r}",
            Controller(LAW, filters=element, sample_time=1e-3, discretisation=way),
        )
        for lines, element, way in (
            (
                'kind = "notch", frequency = "8 Hz", zero_damping = "5 %", pole_damping = "50 %"',
                Notch(8.0, zero_damping=0.05, pole_damping=0.5),
                "tustin",
            ),
            ('kind = "lead-lag", zero = "1 Hz", pole = "9 Hz"', LeadLag(1.0, 9.0), "matched"),
            ('kind = "low-pass", corner = "99 Hz", order = 1', LowPass(99.0, 1), "hold"),
        )
    ),
    *(
        (
            DIGITAL + f"anti_windup = {lines}",
            Controller(LAW, sample_time=1e-3, anti_windup=way),
        )
        for lines, way in (
            ('"conditional"', "conditional"),
            ('{kind = "back-calculation", tracking_time = "0.2 s"}', BackCalculation(0.2)),
            ('{kind = "clamp", integral_limit = "2 N"}', Clamp(2.0)),
        )
    ),
]


@pytest.mark.parametrize(("lines", "expected"), CONTROLLERS, ids=range(len(CONTROLLERS)))
def test_controllers(read, lines, expected):
    found = servo_loop_of(read(controller=lines)).controller
    assert found == expected
    plain = ServoLoop(Inertia(2.0), expected).respond(Ramp(0.0), 0.1, duration=0.2, start=0.01)
    assert np.isfinite(plain.error).all()


@pytest.mark.parametrize(
    "lines",
    [
        "numerator = [1], denominator = [0.01, 1]",
        "poles = [-100.0], gain = 100.0",
        "a = [[-100.0]], b = [1.0], c = [100.0], d = 0.0",
    ],
)
def test_any_linear_element_is_a_filter(read, lines):
    controller = f'{GAINS}\nfilters = [{{kind = "transfer", {lines}}}]'
    (element,) = servo_loop_of(read(controller=controller)).controller.filters
    assert complex(element(7.0j)) == pytest.approx(1.0 / (1.0 + 0.07j), rel=1e-12)


DAMPED = Axis(2.0, modes=[FlexibleMode(6.0, 0.01, load_fraction=0.3)], viscous=1.0)
FEEDFORWARDS = [
    (
        'velocity = "1 N s/m"\nacceleration = "2 kg"\njerk = "3 N s^3/m"\nsnap = "4 N s^4/m"',
        Feedforward({1: 1.0, 2: 2.0, 3: 3.0, 4: 4.0}),
    ),
    ('friction = "1 N"', Feedforward({2: 2.0}, friction=1.0)),
    ("inverse = true", inverse_feedforward(DAMPED)),
    ('inverse = "low-frequency"', low_frequency_feedforward(DAMPED)),
]


@pytest.mark.parametrize(("lines", "expected"), FEEDFORWARDS, ids=range(len(FEEDFORWARDS)))
def test_feedforwards(read, lines, expected):
    modes = 'modes = [{frequency = "6 Hz", damping = "1 %", load_fraction = "30 %"}]'
    plant = f'{MASS}\nviscous = "1 N s/m"\n{modes}'
    found = servo_loop_of(read(plant, more=f"[feedforward]\n{lines}")).feedforward
    assert found == expected


PLAIN = min_time_move(0.4, LIMITS)
MODES = '[[modes]]\nname = "one"\nfrequency = "6 Hz"\n[[modes]]\nname = "two"\nfrequency = "9 Hz"\n'
MOVES = [
    ("", "", PLAIN),
    ("", 'duration = "2 s"', min_time_move(0.4, LIMITS, duration=2.0)),
    ("", 'round_to = "10 ms"', min_time_move(0.4, LIMITS, round_to=0.01)),
    ("", 'minimum_jerk = true\nduration = "3 s"', min_jerk_move(0.4, duration=3.0)),
    *(
        (
            "",
            f'shaper = {{kind = "{kind}", frequency = "6 Hz", damping = "2 %"}}',
            input_shaper(kind, 6.0, 0.02).shape(PLAIN),
        )
        for kind in ("ZV", "ZVD", "ZVDD", "EI")
    ),
    (
        MODES + '[shaper]\nkind = "ZV"\nmodes = ["one", "two"]\n',
        "",
        input_shaper("ZV", 9.0).shape(input_shaper("ZV", 6.0).shape(PLAIN)),
    ),
]


@pytest.mark.parametrize(("more", "lines", "expected"), MOVES, ids=range(len(MOVES)))
def test_moves_and_shapers(read, more, lines, expected):
    (move,) = read(more=more, move=lines).moves
    found = planned(move)
    assert found.duration == pytest.approx(expected.duration, rel=1e-12)
    times = np.linspace(0.0, expected.duration, 50)
    np.testing.assert_allclose(found(times), expected(times), atol=1e-12)


def test_a_jerk_filter(read):
    scenario = read(more='[filter]\ncorner = "9 Hz"\norder = 3')
    assert jerk_filter_of(scenario) == JerkFilter(9.0, 3)


COMMANDS = [
    ('rate = "2 m/s"\nduration = "3 s"', Ramp(2.0)),
    ('sine = {amplitude = "2 m", frequency = "3 Hz"}\nduration = "3 s"', Sine(2.0, 3.0)),
    ('scan = {length = "1 m", rate = "0.2 m/s", lines = 2}', scan_move(1.0, 0.2, LIMITS, lines=2)),
]


@pytest.mark.parametrize(("lines", "expected"), COMMANDS, ids=range(len(COMMANDS)))
def test_commands_that_go_on(read, lines, expected):
    scenario = read(more=f'[[tracking]]\nname = "on"\n{lines}')
    (found,) = survey_conditions(scenario)["tracking"]
    if isinstance(expected, Ramp | Sine):
        assert found.command == expected
    else:
        np.testing.assert_allclose(found.command.breaks, expected.trajectory.breaks, rtol=1e-12)


TABLE = "frequencies = ['1 Hz', '9 Hz'], densities = "
ACTING = [
    ('torque_step = {torque = "1 N"}', Disturbances(TorqueSteps([0.0], [1.0]), seed=1)),
    (
        'torque_sine = {amplitude = "1 N", frequency = "2 Hz", on = "load"}',
        Disturbances(TorqueSine(1.0, 2.0, on="load"), seed=1),
    ),
    (
        'wind = {kind = "double_pole", sigma = "2 N", corner = "1 Hz"}',
        Disturbances(Wind("double_pole", 2.0, corner_hz=1.0), seed=1),
    ),
    (
        f"torque_spectrum = {{{TABLE}['1 N^2/Hz', '2 N^2/Hz']}}",
        Disturbances(Spectrum([1.0, 9.0], [1.0, 2.0]), seed=1),
    ),
    ('encoder_noise = "1 um"', Disturbances((), 1e-6, seed=1)),
    (
        f"encoder_spectrum = {{{TABLE}['1 um^2/Hz', '1 um^2/Hz']}}",
        Disturbances((), Spectrum([1.0, 9.0], [1e-12, 1e-12]), seed=1),
    ),
]


@pytest.mark.parametrize(("lines", "expected"), ACTING, ids=range(len(ACTING)))
def test_disturbances_of_moves(read, lines, expected):
    scenario = read(controller=DIGITAL, move=f"[moves.disturbances]\n{lines}")
    (move,) = moves_of(scenario)
    loop = servo_loop_of(scenario)
    one, other = (
        loop.respond(PLAIN, 0.05, duration=1.5, **each.acting(loop, 1.5))
        for each in (move.disturbances, expected)
    )
    np.testing.assert_allclose(one.load, other.load, rtol=1e-12, atol=1e-15)
    assert np.abs(one.load - loop.respond(PLAIN, 0.05, duration=1.5).load).max() > 0.0


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("numerator = [1.0]", "plant.transfer: has numerator; write numerator and denominator, or"),
        ("poles = [0.0], gain = 1.0, a = [[1.0]]", "plant.transfer: has poles, gain, a; write"),
        ("poles = [[1, 2, 3]], gain = 1.0", "transfer.poles: [1, 2, 3] is not a pair; write [real"),
        ("poles = 3, gain = 1.0", "plant.transfer.poles: 3 is not a list of numbers, a pair of"),
        ("a = [[0, 1], [0]], b = [1], c = [1]", "transfer.a: [[0, 1], [0]] is not a square matrix"),
        ("a = [[0, 1], [0, 0]], b = [1], c = [1, 0]", "transfer: has b and c of 1 and 2 numbers"),
        ("poles = [-1.0], gain = 1.0", "expected two poles more than zeros"),
    ],
)
def test_what_is_no_linear_system_is_one_line(read, lines, words):
    with pytest.raises(ValueError, match=r"case\.toml: plant") as caught:
        servo_loop_of(read(f"transfer = {{{lines}}}"))
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_zeros_and_poles_are_conditions_of_the_gate(read):
    lines = "transfer = {zeros = [-5.0], poles = [0, 0, [-2.0, 5.0]], gain = 3.0}"
    conditions = scenario_conditions(read(lines))
    assert conditions["plant", "transfer", "poles"] == "0+0j 0+0j -2+5j -2-5j"
    assert conditions["plant", "transfer", "gain"] == "3"
