"""The explorer in a notebook: nouns become a scenario and come back, messages are answered."""

import asyncio
import time
import tomllib

import control
import pytest
from explored import EXAMPLES, NOTCH, written

from jounce.analysis import Move, loop_margins
from jounce.app import explore, load_scenario
from jounce.app.explorer.nouns import content_of
from jounce.app.explorer.state import started
from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    Inertia,
    InertiaFeedforward,
    LeadLag,
    LowPass,
    Notch,
    Ripple,
    ServoLoop,
    chain_axis,
)
from jounce.shaping import input_shaper

AXIS = Axis(
    2.0,
    viscous=3.0,
    modes=[FlexibleMode(61.0, 0.006, motor_shape=0.5, load_shape=-0.5)],
    friction=Friction(0.1, 0.2),
    torque_limit=50.0,
    current_lag=1e-4,
    encoder_step=1e-6,
    sensor="both",
)
FILTERS = [
    Notch(72.0, 75.0, zero_damping=0.05, pole_damping=0.5),
    LeadLag(20.0, 60.0),
    LowPass(400.0, 1),
]
LOOPS = {
    "ideal": ServoLoop(Inertia(3.0), PID(30.0, 40.0, 6.0), InertiaFeedforward(2.5)),
    "digital": ServoLoop(
        AXIS,
        Controller(
            PID(2000.0, 2e4, 60.0, derivative_filter=1e-3),
            filters=FILTERS,
            sample_time=2.5e-4,
            delay=2e-4,
            anti_windup=BackCalculation(0.1),
        ),
        Feedforward({1: 3.0, 2: 2.0}, friction=0.05, lead=3e-4),
    ),
    "cascade": ServoLoop(
        Axis(0.004, modes=[FlexibleMode(80.0, 0.02, load_fraction=0.3, held=True)]),
        Controller(CascadedPI(30.0, 0.8, reset_time=0.02), sample_time=5e-4),
    ),
    "chain": ServoLoop(
        chain_axis([1.0, 2.0], [500.0], [0.5]), PID(10.0, 5.0, 8.0, derivative_filter=1e-3)
    ),
    "transfer": ServoLoop(
        control.tf([1.0], [1.0, 0.4, 0.0]), PID(4.0, 1.0, 2.0, derivative_filter=0.01)
    ),
}


@pytest.mark.parametrize("unit", ["rad", "m"])
@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_becomes_a_scenario_and_comes_back(tmp_path, name, unit):
    state = started(tmp_path / "loop.toml", content_of(LOOPS[name], unit))
    before, after = (loop_margins(loop) for loop in (LOOPS[name], state.loop))
    assert after.phase_margin_deg == pytest.approx(before.phase_margin_deg, rel=1e-9)
    assert state.loop.controller_noun.anti_windup == LOOPS[name].controller_noun.anti_windup
    if name in ("ideal", "digital", "cascade"):
        assert state.loop.axis == LOOPS[name].axis
        assert state.loop.controller_noun == LOOPS[name].controller_noun
    if LOOPS[name].feedforward is not None:
        assert state.loop.feedforward_noun == LOOPS[name].feedforward_noun


@pytest.mark.parametrize(
    ("what", "says"),
    [
        (ServoLoop(Inertia(1.0), PID(1.0, 0.0, 1.0), Feedforward({6: 1.0})), "above snap"),
        (ServoLoop(Axis(1.0, ripple=Ripple.sine(0.1, 1.0)), PID(1.0, 0.0, 1.0)), "ripple"),
        (
            Move(
                name="m",
                distance=1.0,
                bounds=(1.0,),
                limits_name="a",
                settle_to=0.1,
                shapers=(input_shaper("ZV", 3.0),),
            ),
            "shapers",
        ),
    ],
)
def test_what_a_scenario_cannot_say_is_told(what, says):
    with pytest.raises(ValueError, match=says):
        content_of(what, "rad")


def test_other_kinds_are_refused():
    with pytest.raises(TypeError, match="int: expected a ServoLoop"):
        content_of(3, "rad")
    with pytest.raises(ValueError, match="unit = 'deg'"):
        content_of(LOOPS["ideal"], "deg")


def answered(explorer, *messages):
    """Give the widget messages as a page does; return the parts that it sends back."""
    sent = []
    explorer.widget.send = lambda content, buffers: sent.append((content, buffers))

    for message in messages:
        explorer.receive(message)
    last = time.monotonic() + 60.0
    while not any(content["part"] == "done" for content, _ in sent):
        assert time.monotonic() < last
        time.sleep(0.01)
    return {content["part"]: content for content, _ in sent}


@pytest.fixture
def _extra():
    pytest.importorskip("anywidget")
    pytest.importorskip("tomlkit")


@pytest.mark.usefixtures("_extra")
def test_a_loop_in_a_notebook_is_shaped_and_taken_back():
    explorer = explore(LOOPS["digital"])
    drag = {"id": 2, "kind": "drag", "handle": NOTCH, "gesture": "a", "frequency": 1.25}
    shown = answered(explorer, {"id": 1, "kind": "start", "link": "", "view": "loop"}, drag)
    assert explorer.loop.controller_noun.filters[0].zero_hz == pytest.approx(90.0)
    [row] = [r for r in shown["numbers"]["margins"] if r["name"] == "phase_margin_deg"]
    assert row["value"] == loop_margins(explorer.loop).phase_margin_deg
    assert shown["curves"]["model"]["frequency"] == {"$array": 0}
    assert tomllib.loads(explorer.text()) == explorer.session.state.content


@pytest.mark.usefixtures("_extra")
def test_messages_are_answered_that_come_from_loops_which_end():
    explorer = explore(LOOPS["ideal"])
    seen = []
    explorer.widget.send = lambda content, _: seen.append((content["part"], content["id"]))

    async def come(message):
        explorer.receive(message)

    for number in (1, 2):
        asyncio.run(come({"id": number, "kind": "start", "link": "", "view": "loop"}))
        last = time.monotonic() + 60.0
        while ("done", number) not in seen:
            assert time.monotonic() < last
            time.sleep(0.01)
    assert seen.count(("numbers", 1)) == seen.count(("numbers", 2)) == 1


@pytest.mark.usefixtures("_extra")
def test_a_move_and_a_scenario_are_explored_as_well(tmp_path):
    move = Move(name="m", distance=1.0, bounds=(1.0, (-2.0, 3.0)), limits_name="a", settle_to=0.1)
    explorer = explore(move, unit="m")
    assert explorer.scenario.moves[0].bounds == (1.0, (-2.0, 3.0))
    assert answered(explorer, {"kind": "view", "view": "move"})["move"]["shown"] == 0
    path = written(tmp_path, (EXAMPLES / "servo_drive.toml").read_text())
    for what in (path, str(path), load_scenario(path)):
        assert explore(what).scenario.title == "Servo drive with friction"


@pytest.mark.usefixtures("_extra")
def test_the_widget_is_the_page_itself():
    shown = explore(LOOPS["ideal"])._repr_mimebundle_()
    data = shown[0] if isinstance(shown, tuple) else shown
    assert "application/vnd.jupyter.widget-view+json" in data
