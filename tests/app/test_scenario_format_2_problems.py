"""What is wrong in a file of format 2: one line with file, key, value and remedy."""

from pathlib import Path

import pytest

from jounce.app import survey_file
from jounce.app.scenario import ScenarioError, load_scenario
from jounce.app.scenario_loop import servo_loop_of

EXAMPLES = Path(__file__).parents[2] / "examples"
SAMPLED = 'sample_time = "1 ms"\ndelay = "1.5 samples" # from the sample to the torque\n'
TELESCOPE = (EXAMPLES / "telescope_azimuth.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("viscous", "viscos",
         "plant.viscos: unknown key (with '20 N m s/rad'); accepted: inertia,"),
        ("viscous", "viscos", "did you mean viscous?"),
        ('"20 N m s/rad"', '"20 N s/m"',
         "plant.viscous: '20 N s/m' has the wrong dimension; write a"),
        ('"20 N m s/rad"', "20",
         "plant.viscous: 20 has no unit; write a viscous friction not below"),
        ('"20 N m s/rad"', '"-1 N m s/rad"',
         "plant.viscous: '-1 N m s/rad' is out of range; write"),
        ('sensor = "motor"', 'sensor = "shaft"',
         "plant.sensor: 'shaft' is not known; write one of 'mo"),
        ("held = true", 'held = "yes"',
         "plant.modes[0].held: 'yes' is not known; write one of true,"),
        ('load_fraction = "50 %"', "",
         "plant: a mode of 6.0 Hz without its share: give load_fraction"),
        ('load_fraction = "50 %"', 'load_fraction = "150 %"',
         "plant.modes[0].load_fraction: '150 %' is out of range"),
        ('load_fraction = "50 %"', "motor_shape = true",
         "plant.modes[0].motor_shape: true is not a number; write"),
        ("[[plant.modes]]", "[plant.modes]",
         "plant.modes: a table is not a list of modes; write [[plan"),
        ('torque_limit = "300 N m"', 'torque_limit = "9 N m"\nconstant_load = "-10 N m"',
         "plant: torque_limit = 9.0 cannot hold the constant_load = -10.0: raise the limit above"),
        ('torque_limit = "300 N m"', 'torque_limit = "9 N m"\nfriction = {coulomb = "10 N m"}',
         "plant: torque_limit = 9.0 never overcomes the static friction of 10.0: raise the limit"),
        ('torque_limit = "300 N m"',
         'current_limit = "2 A"\ntorque_constant = "3 N m/A"\nconstant_load = "7 N m"',
         "plant: current_limit, seen at the axis a torque, = 6.0 cannot hold the constant_load"),
        ('inertia = "1000 kg m^2"', "", "plant: has nothing to move; write one of inertia = "),
        ('inertia = "1000 kg m^2"', 'mass = "3 kg"',
         "plant.mass: '3 kg' is of a linear axis, and th"),
        ('inertia = "1000 kg m^2"',
         'inertia = "3 kg m^2"\nchain = {masses = ["1 kg m^2"], springs = []}',
         "plant.chain.springs: [] is not a list of quantities; write one such as ['2 N m/rad']"),
        ("torque_limit", 'current_limit = "3 A"\ntorque_limit',
         "plant: has torque_limit and current_"),
        ('torque_limit = "300 N m"', 'current_limit = "3 A"',
         "plant: has a current_limit, and current"),
        ("[controller]", '[plant.friction]\ncoulomb = "2 N m"\nstatic = "1 N m"\n[controller]',
         "plant.friction: has a static friction of 1 below coulomb = 2; write a larger one"),
        ("[controller]", '[plant.ripple]\nperiod = "2 deg"\n[controller]',
         "plant.ripple: needs a shape: write either amplitude = "),
        ('sample_time = "1 ms"', "",
         "controller.delay: '1.5 samples' is in samples that are not given; w"),
        ('"1.5 samples"', '"-1 ms"',
         "controller.delay: '-1 ms' is out of range; write a duration not be"),
        ('anti_windup = "conditional"',
         'anti_windup = {kind = "back-calculation", tracking_time = "0.4 ms"}',
         "controller.anti_windup: tracking_time = 0.0004: below half a sample the limited loop's "
         "integral is unstable; give 0.0005 or more"),
        ('frequency = "8.5 Hz"', 'frequency = "600 Hz"',
         "at or above the Nyquist frequency of 500 Hz: use a sample time below 0.0008333"),
        ('crossover = "1 Hz"', 'crossover = "40 Hz"',
         "are out of reach: no integral gain gives this low"),
        ('crossover = "1 Hz"', 'crossover = "40 Hz"', 'or write gains = "tune"'),
        ('kind = "notch"', 'kind = "nothc"',
         "controller.filters[0].kind: 'nothc' is not known; write o"),
        ('kind = "notch"', "",
         'controller.filters[0].kind: is missing; write kind = "lead-lag" or kind ='),
        ("zero_damping", "zero_dmping",
         "controller.filters[0].zero_dmping: unknown key (with '10 %'); a"),
        ("[[controller.filters]]", "[controller.filters]",
         "controller.filters: a table is not a list of"),
        ('anti_windup = "conditional"', 'anti_windup = {kind = "clam"}',
         "controller.anti_windup.kind: 'clam' is not known; write one of 'back-cal"),
        ('anti_windup = "conditional"', 'anti_windup = "clamp"',
         "controller.anti_windup: 'clamp' is not known; write 'none"),
        ('gains = "design"', 'gains = "best"',
         "controller.gains: 'best' is not known; write 'design', 'p"),
        ('gains = "design"', 'gains = {kind = "pi"}',
         "controller.gains.kind: 'pi' is not known; write o"),
        ('gains = "design"',
         'gains = {kind = "p-pi", position_gain = "3 Hz", velocity_gain = "1 N m s/rad"}',
         "controller.gains.position_gain: '3 Hz' has the wrong dimension; write a positive gain s"),
        ('inverse = "low-frequency"', 'inverse = true\nsnap = "1 N m s^4/rad"',
         "feedforward: has an inverse beside snap, which"),
        ('inverse = "low-frequency"', 'inverse = true\ninertia = "3 kg m^2"',
         "feedforward: has an inertia beside inverse, wh"),
        ('lead = "auto"', 'lead = "later"',
         "feedforward.lead: 'later' is not a number followed by a unit; w"),
        ('lead = "auto"', 'lead = "later"', "'1.5 ms' or 'auto'"),
        ('encoder_step = "1 mas"', "",
         "moves[0].settle_to: '3 count' is in counts of an encoder that is n"),
        ('settle_to = "50 mas"', 'settle_to = "50 mas"\nshaper = "ZV"',
         "moves[0].shaper: 'ZV' is not known; write 'none' or a table"),
        ('settle_to = "50 mas"',
         'settle_to = "50 mas"\nshaper = {kind = "ZV", modes = ["strcture"]}',
         "moves.next field.shaper: 'strcture' is no mode of this file; did you mean 'structure'?"),
        ('settle_to = "50 mas"', 'settle_to = "50 mas"\nshaper = {kind = "ZV"}',
         "moves[0].shaper: needs a mode to null: write e"),
        ('rate = "sidereal"', "", "tracking[0]: needs one command: write rate = "),
        ('rate = "sidereal"', 'rate = "siderial"', "such as '5 deg/s' or 'sidereal'"),
        ('after = "10 s"', 'after = "30 s"',
         "tracking[0]: counts errors after 30 s of 20 s; write a longer"),
        ('duration = "20 s"', "", "tracking[0]: goes on for ever; write duration = "),
        ('kind = "von_karman"', 'kind = "first_order"',
         "disturbances.wind: of kind 'first_order' has leng"),
        ("load_settling =", "load_setling =", "did you mean load_settling?"),
        ('{ max = "2 s" }', '{ most = "2 s" }',
         "requirements.load_settling: a table is not a bound; writ"),
        ('{ max = "2 s" }', '{ max = "2 m" }',
         "requirements.load_settling.max: '2 m' has the wrong dimen"),
        ('{ max = "2 s" }', '{ max = "2 s", min = "7 s" }',
         "requirements.load_settling: its min is above"),
        ("[requirements]", '[requirements."next fild"]', "did you mean next field?"),
        ("\nformat = 2", "\nformat = 3",
         "format: 3 is not known; write format = 2, or leave it out for a"),
        ("\nformat = 2", "\nformat = true", "format: true is not known; write format = 2"),
        ("\nformat = 2\n", "\n",
         "plant.viscous and 14 more: of format 2; write format = 2 at the top of"),
        ("\nformat = 2\n", "\nfromat = 2\n", "did you mean format?"),
    ],
)  # fmt: skip
def test_a_problem_is_one_line_with_key_and_remedy(write, old, new, line):
    text = TELESCOPE.replace("50 mas", "3 count") if "encoder" in old else TELESCOPE
    assert old in text
    path = write(text.replace(old, new, 1))
    with pytest.raises(ValueError, match=r"case\.toml: ") as refusal:
        servo_loop_of(load_scenario(path))
    lines = str(refusal.value).splitlines()
    assert all(each.startswith(f"{path}: ") for each in lines)
    assert sum(line in each for each in lines) == 1


def test_a_delay_without_sample_time_is_refused(write):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(write(TELESCOPE.replace(SAMPLED, 'delay = "2 ms"\n')))
    assert str(refusal.value).endswith(
        "case.toml: controller: has a delay of 0.002 s without a sample time, and a continuous "
        'controller computes at once; write sample_time = "1 ms" as well'
    )


def test_an_unstable_loop_and_moves_of_too_low_an_order_are_told_by_the_survey(write):
    weak = 'gains = {kp = "1 N m/rad", ki = "5 N m/(rad s)", kr = "0.1 N m s/rad"}'
    with pytest.raises(
        ValueError, match=r"case\.toml: the closed loop is UNSTABLE, with a pole at"
    ):
        survey_file(write(TELESCOPE.replace('gains = "design"', weak)))
    no_snap = TELESCOPE.replace('snap = "600 deg/s^4"', "")
    with pytest.raises(ValueError, match=r"case\.toml: move 'next field': snap of a trajectory of"):
        survey_file(write(no_snap))


def test_overrides_reach_the_keys_of_format_2(write):
    path = write(TELESCOPE)
    given = {
        "plant.modes.structure.frequency": "7 Hz",
        "controller.filters[0].frequency": "10 Hz",
        "tracking.stars.duration": "30 s",
        "requirements.load_settling.max": "3 s",
    }
    scenario = load_scenario(path, overrides=given)
    assert scenario.plant.modes[0].frequency == 7.0
    assert scenario.controller.filters[0].frequency == 10.0
    assert scenario.tracking[0].duration == 30.0
    assert scenario.requirements[0].most == 3.0
    with pytest.raises(ScenarioError, match=r"did you mean plant\.modes\.structure\?"):
        load_scenario(path, overrides={"plant.modes.strcture.frequency": "7 Hz"})
    with pytest.raises(ScenarioError, match=r"override plant\.sensor: 'shaft' is not known"):
        load_scenario(path, overrides={"plant.sensor": "shaft"})


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[requirements]", 'torque_file = {path = "t.csv"}\n[requirements]'),
        ('settle_to = "50 mas"',
         'settle_to = "50 mas"\ndisturbances = {torque_file = {path = "t.csv"}}'),
        ("[requirements]",
         'torque_spectrum = {frequencies = ["1 Hz"], densities = ["1 N^2 m^2/Hz"]}\n'
         "[requirements]"),
        ('rate = "sidereal"',
         'file = {path = "t.csv", sample_time = "1 ms", limits = "slew"}'),
    ],
)  # fmt: skip
def test_a_survey_names_its_file_once(write, old, new):
    assert old in TELESCOPE
    with pytest.raises(ValueError, match=r"case\.toml: ") as refusal:
        survey_file(write(TELESCOPE.replace(old, new, 1)))
    assert str(refusal.value).count("case.toml") == 1
