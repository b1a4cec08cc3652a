"""The drive of a sweep knows the plant and the delay of the file, not those of the point."""

import pytest
from swept_axis import AXIS

from jounce.analysis import residual_vibration
from jounce.analysis.planned_moves import planned
from jounce.app import load_scenario, survey_file, sweep
from jounce.app.scenario_loop import servo_loop_of
from jounce.plant import (
    PID,
    Axis,
    FlexibleMode,
    Inertia,
    ServoLoop,
    inverse_feedforward,
    low_frequency_feedforward,
)
from jounce.shaping import Limits, input_shaper, min_time_move

FREQUENCIES = ["9 Hz", "12 Hz", "15 Hz"]
GAINS = '{ kp = "218 N m/rad", ki = "597 N m/(rad s)", kr = "22 N m s/rad" }'
GIVEN = AXIS.replace('"design"', GAINS)


def axis_of(inertia, frequency):
    return Axis(inertia, modes=[FlexibleMode(frequency, 0.02, load_fraction=0.3, held=True)])


@pytest.fixture
def file(tmp_path):
    """Return what writes a scenario."""

    def written(text):
        path = tmp_path / "axis.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return written


@pytest.mark.parametrize(
    ("said", "find"),
    [("true", inverse_feedforward), ('"low-frequency"', low_frequency_feedforward)],
)
def test_an_inverse_is_of_the_file_s_plant(file, said, find):
    text = GIVEN.replace("settle_to", 'settle_to = "0.05 deg" #').replace(
        "[requirements]", f"[feedforward]\ninverse = {said}\n[requirements]"
    )
    text = text.replace("jerk =", 'snap = "90000 deg/s^4"\njerk =')
    keys = {"plant.modes.top.frequency": FREQUENCIES}
    found = sweep(file(text), keys, figures=["peak_load_error"], workers=1)
    law, deg = PID(218.0, 597.0, 22.0), 0.017453292519943295
    move = min_time_move(90.0 * deg, Limits(*(x * deg for x in (1e9, 90.0, 900.0, 90000.0))))
    for k, frequency in enumerate((9.0, 12.0, 15.0)):
        loop = ServoLoop(axis_of(2.0, frequency), law, find(axis_of(2.0, 12.0)))
        error = loop.respond(move, dt=1e-3, duration=6.0).load_error
        expected = abs(error).max() / deg
        assert found.values("peak_load_error")[k] == pytest.approx(expected, rel=1e-3, abs=1e-9)


def test_a_shaper_nulls_the_file_s_mode(file):
    text = GIVEN + '[shaper]\nkind = "ZV"\nmodes = ["top"]\n'
    found = sweep(
        file(text), {"plant.modes.top.frequency": FREQUENCIES}, figures=["left_over"], workers=1
    )
    shaper = input_shaper("ZV", 12.0, 0.02)
    for point in range(3):
        (held,) = found.case(point).scenario.moves[0].shapers
        assert held.times == pytest.approx(shaper.times)
    low, exact, high = found.values("left_over")
    anew = sweep(
        file(text), {"plant.modes.top.frequency": FREQUENCIES}, hold_gains=False, workers=1
    )
    (true,) = anew.case(0).scenario.moves[0].shapers
    assert true.times == pytest.approx(input_shaper("ZV", 9.0, 0.02).times)
    assert (
        exact
        == sweep(
            file(text),
            {"plant.inertia": ["2 kg m^2"]},
            figures=["left_over"],
            workers=1,
            hold_gains=False,
        ).values("left_over")[0]
    )
    assert low != high


@pytest.mark.parametrize("number", [1, 2])
def test_the_inertia_fed_forward_is_the_file_s(file, number):
    text = GIVEN
    if number == 1:
        text = text.replace("format = 2", "").partition("[requirements]")[0]
        text = text[: text.index("[[plant.modes]]")] + text[text.index("[controller]") :]
    inertias = ["1.8 kg m^2", "2 kg m^2", "2.2 kg m^2"]
    path = file(text)
    found = sweep(path, {"plant.inertia": inertias}, figures=["peak_error"], workers=1)
    for point, inertia in enumerate((1.8, 2.0, 2.2)):
        scenario = found.case(point).scenario
        assert (scenario.inertia, scenario.feedforward_inertia) == (inertia, 2.0)
        told = {"plant.inertia": inertias[point], "feedforward.inertia": "2 kg m^2"}
        alone = survey_file(path, overrides=told).moves[0].configured.peak_error
        assert found.values("peak_error")[point] == alone / 0.017453292519943295
    wrong = found.values("peak_error")
    assert min(wrong[0], wrong[2]) > 2.0 * wrong[1]


def test_what_waits_for_a_delay_waits_for_the_file_s(file):
    clock = 'sample_time = "1 ms"\ndelay = "1 samples"\n'
    text = GIVEN.replace("[limits.drive]", f"{clock}[limits.drive]")
    text += '[feedforward]\nlead = "auto"\n'
    delays = ["1 samples", "3 samples"]
    found = sweep(file(text), {"controller.delay": delays}, figures=["peak_error"], workers=1)
    leads = [servo_loop_of(found.case(k).scenario).feedforward_noun.lead for k in (0, 1)]
    assert leads == pytest.approx([1.5e-3, 1.5e-3])


def test_a_scenario_can_believe_in_another_plant(file):
    text = AXIS + '[believed]\ninertia = "1.5 kg m^2"\n'
    scenario = load_scenario(file(text))
    loop, alone = servo_loop_of(scenario), servo_loop_of(scenario.as_believed)
    assert (scenario.inertia, scenario.feedforward_inertia) == (2.0, 1.5)
    assert len(loop.plant.modes) == 1
    assert alone.plant == Inertia(1.5)
    assert loop.controller_noun == alone.controller_noun
    assert loop.feedforward_noun == alone.feedforward_noun
    assert scenario.as_believed.believed_told == ()
    [told] = survey_file(scenario).heading[1:]
    assert told.endswith("are made for [believed]")


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ('[believed]\ninertia = "2 m"\n', "believed.inertia: '2 m' has the wrong dimension"),
        ("[believed]\n", "believed: has nothing to move"),
        ('[believed]\nfrf = "a.csv"\n', "believed: a measured plant is what it is"),
    ],
)
def test_a_plant_that_cannot_be_believed_is_refused(file, said, told):
    with pytest.raises(ValueError, match=told):
        load_scenario(file(AXIS + said))


def test_a_shaper_is_made_for_the_mode_that_the_file_has_outside_of_the_plant(file):
    text = GIVEN + (
        '[shaper]\nkind = "ZV"\nmodes = ["rope"]\n'
        '[[modes]]\nname = "rope"\nfrequency = "0.5 Hz"\ndamping = "1 %"\n'
    )
    keys = {"modes.rope.frequency": ["0.45 Hz", "0.5 Hz"], "modes[0].damping": ["1 %", "2 %"]}
    path, asked = file(text), ["residual_vibration"]
    found = sweep(path, keys, figures=asked, workers=1)
    deg, times = 0.017453292519943295, input_shaper("ZV", 0.5, 0.01).times
    for point, (frequency, damping) in enumerate([(0.45, 0.01), (0.45, 0.02), (0.5, 0.01)]):
        scenario = found.case(point).scenario
        assert scenario.moves[0].shapers[0].times == pytest.approx(times)
        left = residual_vibration(planned(scenario.moves[0]), frequency, damping)
        assert found.values(asked[0])[point] == pytest.approx(left / deg, abs=1e-9)
    assert found.values(asked[0])[2] < 1e-9 < 1.0 < found.values(asked[0])[0]
    alone = survey_file(path, overrides=dict(found.case(1).overrides)).moves[0]
    assert found.values(asked[0])[1] == alone.residual_vibration["rope"] / deg
    anew = sweep(path, keys, figures=asked, workers=1, hold_gains=False)
    assert anew.values(asked[0]) == pytest.approx(0.0, abs=1e-9)


def test_what_is_left_ringing_in_no_mode_is_no_figure(file):
    with pytest.raises(ValueError, match=r"'residual_vibration': .* give modes=…"):
        sweep(file(GIVEN), {"plant.inertia": ["2 kg m^2"]}, figures=["residual_vibration"])
