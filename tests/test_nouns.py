"""Every public noun can be shown, copied and sent to another process, as read-only as before."""

import copy
import dataclasses
import pickle
from types import MappingProxyType
from xml.etree import ElementTree

import control
import numpy as np
import pytest
from tiers import some

import jounce.analysis
import jounce.app
import jounce.plant
import jounce.shaping
from jounce.analysis import (
    Disturbances,
    MeasuredResponse,
    Mode,
    Requirement,
    Specification,
    Tracking,
    cascaded_lags,
    closed_responses,
    conformance,
    describing_function,
    estimate_frf,
    first_order_lag,
    fit_axis,
    frequency_response,
    loop_margins,
    measured_survey,
    multisine,
    null_by_size,
    periodic_response,
    repeated_margins,
    sensitivity_of_shapers,
    servo_margins,
    survey,
    tune_limits,
    tune_pid,
    vibration_map,
)
from jounce.app import LogUniform, Normal, Uniform, check_scenario, load_scenario, survey_file
from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleInertia,
    FlexibleMode,
    Friction,
    Inertia,
    InertiaFeedforward,
    LeadLag,
    LoopResponse,
    LowPass,
    Notch,
    Ramp,
    Ripple,
    SampledTorque,
    ServoLoop,
    Sine,
    Spectrum,
    TorqueSine,
    TorqueSteps,
    Wind,
    chain_axis,
    respond,
)
from jounce.shaping import (
    CommandFollower,
    JerkFilter,
    Limits,
    Trajectory,
    Transfer,
    certify,
    input_shaper,
    min_time_move,
    min_time_moves,
    min_time_transfer,
    min_time_transfers,
    s_curve_move,
    scan_move,
    synchronize,
    through,
    velocity_move,
)
from jounce.shaping.trajectory import Planned

LIMITS = Limits(velocity=1.0, acceleration=2.0, jerk=20.0)
LIMITER = Limits(velocity=1.0)
MOVE = min_time_move(3.0, LIMITS)
TIMES, STATES = MOVE.sample(0.1)
FILTER = JerkFilter(2.0, 3)
FOLLOWER = CommandFollower(LIMITS, dt=0.1, jerk_filter=FILTER)
LOOP = ServoLoop(Inertia(1.0), PID(1.0, 1.0, 2.0), InertiaFeedforward(1.0))
RESPONSE = LOOP.respond(MOVE, 0.1)  # after which the loop keeps its interconnection
SURVEY = survey_file(load_scenario("examples/telescope.toml"))
LINES = np.arange(1.0, 30.0)
FRF = MeasuredResponse(LINES, 10 / (1j * LINES), 1 / LINES, kind="loop")
PLANT_FRF = MeasuredResponse(LINES, -1 / LINES**2, kind="plant")
MULTISINE = multisine(0.01, 100, band_hz=(1.0, 40.0), torque=1.0)
TUNED = tune_limits(
    LOOP, 3.0, settle_to=0.1, velocity=1.0, acceleration=2.0, orders=(3,), shapers=()
)
MOVE(0.5), FOLLOWER.step((0.0,), 1.0)

NOUNS = [
    Uniform("1 Hz", "2 Hz"),
    LogUniform(1.0, 2.0),
    Normal("6 Hz", "200 mHz"),
    measured_survey(FRF),
    LIMITS,
    Limits(np.array([1.0, 2.0]), (-1.0, 2.0), np.array([[-3.0, 1.0], [-4.0, 5.0]])),
    MOVE,
    Trajectory([0.0, 1.0], [[0.0, 1.0, 0.0]]),
    Transfer(MOVE, LIMITS),
    velocity_move(1.0, acceleration=2.0, acceleration_jerk=20.0),
    min_time_transfer((0.0, 2.0), 1.0, LIMITS),
    min_time_transfers([[0.0], [1.0]], [3.0], LIMITS),
    min_time_moves([1.0, 2.0], Limits(velocity=(-1.0, 2.0), jerk=np.array([1.0, 2.0]))),
    min_time_moves([1.0, 2.0], Limits(velocity=1.0, snap=2.0)),
    s_curve_move(1.0, velocity=1.0, acceleration=2.0, acceleration_jerk=20.0),
    synchronize([(0.0, 1.0, LIMITS), (2.0, 3.0, LIMITS)]),
    synchronize([(0.0, 3.0), (2.0, 6.0)], "straight-line", resultant=LIMITS),
    through([0.0, 1.0, 0.5], LIMITS),
    through([(0.0, 0.0), (1.0, 0.5), (0.5, 1.0)], LIMITS, corner=0.1),
    through([0.0, 1.0, 0.5], LIMITS).passage,
    certify(MOVE, LIMITS),
    tune_pid(FlexibleInertia(2.0, 20.0, 0.01), sample_time=1e-3),
    TUNED,
    TUNED.best,
    scan_move(1.0, 0.5, LIMITS, lines=2),
    FILTER,
    FILTER.respond(MOVE, 0.1),
    FOLLOWER,
    FOLLOWER.run([1.0, 2.0]),
    LOOP,
    RESPONSE,
    LOOP.deviations(Wind("first_order", 1.0, corner_hz=2.0)),
    input_shaper("ZV", 2.0),
    Inertia(1.0),
    FlexibleInertia(1.0, 2.0, 0.1),
    InertiaFeedforward(1.0),
    PID(1.0, 2.0, 3.0),
    Friction(1.0, 2.0),
    Ripple.sine(1.0, 0.1),
    Axis(2.0, ripple=Ripple([0.0, 0.5], [1.0, -1.0], 1.0)),
    FlexibleMode(6.0, 0.01, load_fraction=0.5),
    Axis(2.0, modes=[FlexibleMode(6.0, load_fraction=0.5)], friction=Friction(1.0)),
    chain_axis([1.0, 2.0], [3.0]),
    CascadedPI(1.0, 2.0, 3.0),
    BackCalculation(1.0),
    Clamp(1.0),
    Notch(1.0, zero_damping=0.1, pole_damping=0.5),
    LeadLag(1.0, 2.0),
    LowPass(1.0),
    Controller(PID(1.0, 2.0, 3.0), filters=LowPass(1.0), sample_time=0.1, delay=0.1),
    Feedforward({2: 1.0}, position={"jerk": 2.0}),
    Ramp(1.0),
    Ripple.sine(1.0, 0.1),
    Axis(2.0, ripple=Ripple([0.0, 0.5], [1.0, -1.0], 1.0)),
    Sine(1.0, 2.0),
    Ramp(1.0) + Sine(1.0, 2.0),
    TorqueSteps([1.0], [2.0]),
    SampledTorque([1.0], [2.0]),
    TorqueSine(1.0, 2.0),
    Wind("first_order", 1.0, corner_hz=2.0),
    Spectrum([1.0, 2.0], [3.0, 4.0]),
    Spectrum(np.arange(1.0, 1000.0), np.ones(999)),
    Disturbances((TorqueSine(1.0, 2.0),), (1e-6,)),
    loop_margins(LOOP.loop_transfer()),
    FRF,
    closed_responses(FRF),
    loop_margins(FRF),
    MULTISINE,
    repeated_margins({"one": FRF}),
    fit_axis(PLANT_FRF, modes=0),
    estimate_frf(MULTISINE.values, MULTISINE.repeated(2), MULTISINE.repeated(2), 0.01, period=100),
    servo_margins([1.0, 2.0], PID(1.0, 1.0, 2.0)),
    SURVEY,
    SURVEY.scenario,
    survey(LOOP, SURVEY.scenario.moves[:1]),
    SURVEY.labels,
    SURVEY.scenario.moves[0],
    Specification(1.0, 45.0, 12.0),
    Mode("first", 8.0),
    Tracking("sidereal", Ramp(1.0), 2.0),
    Requirement("load_settling", most=2.0),
    SURVEY.moves[0],
    check_scenario("examples/telescope.toml"),
    conformance(TIMES, STATES[0], LIMITS, resolution=1e-6),
    frequency_response(MOVE, [1.0, 2.0]),
    cascaded_lags(MOVE, [1.0, 2.0]),
    vibration_map(LIMITS, [1.0], [2.0]),
    null_by_size(LIMITS, [1.0, 2.0], 3.0),
    sensitivity_of_shapers({"ZV": input_shaper("ZV", 2.0)}, 2.0),
    describing_function(LIMITER, 1.0, [1.0, 2.0]),
    periodic_response(LIMITER, 1.0, 1.0),
    first_order_lag(describing_function(LIMITER, 2.0, [1.0, 2.0])),
]
NAMES = [f"{type(noun).__name__} {i}" for i, noun in enumerate(NOUNS)]
COPIES = {
    "copy": copy.copy,
    "deep copy": copy.deepcopy,
    "pickle of a copy": lambda noun: pickle.loads(pickle.dumps(copy.deepcopy(noun))),
    **{
        f"pickle {protocol}": lambda noun, protocol=protocol: pickle.loads(
            pickle.dumps(noun, protocol)
        )
        for protocol in some(range(pickle.HIGHEST_PROTOCOL + 1), 2)
    },
}


@pytest.mark.parametrize("noun", NOUNS, ids=NAMES)
def test_a_noun_is_told_in_some_lines(noun):
    told = repr(noun)
    assert len(told) < 1000
    assert told.count("\n") < 6
    assert told.startswith((type(noun).__name__, "<"))


@pytest.mark.parametrize("noun", [n for n in NOUNS if hasattr(n, "_repr_html_")])
def test_a_result_is_a_small_table_in_a_notebook(noun):
    html = noun._repr_html_()
    assert len(html) < 8000
    root = ElementTree.fromstring(f"<all>{html}</all>")
    rows = root.findall("table/tr")
    assert rows
    for name, value in rows:
        assert name.tag == "th"
        assert 0 < len(value.text) < 200
    moves = isinstance(noun, Trajectory | Planned)
    assert len(root.findall(".//{*}polyline")) == moves


def test_tables_tell_what_results_are():
    html = SURVEY._repr_html_()
    for part in ("phase margin", "45 deg", "60 arcsec step", "settled"):
        assert part in html
    assert "-1 … 1" in LIMITS._repr_html_()
    assert "acceleration" in LIMITS._repr_html_()
    kinds = {type(noun) for noun in NOUNS if hasattr(noun, "_repr_html_")}
    assert {Limits, Trajectory, Transfer, type(SURVEY), type(loop_margins(LOOP))} <= kinds


def test_every_public_noun_is_here():
    modules = jounce.shaping, jounce.plant, jounce.analysis, jounce.app
    public = [getattr(module, name) for module in modules for name in module.__all__]
    nouns = {noun for noun in public if dataclasses.is_dataclass(noun)}
    assert nouns <= {type(noun) for noun in NOUNS}


def parts(value, path="it"):
    """Yield every part of a noun, by its path."""
    yield path, value
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from parts(getattr(value, field.name), f"{path}.{field.name}")
    elif isinstance(value, tuple | list):
        for i, part in enumerate(value):
            yield from parts(part, f"{path}[{i}]")
    elif isinstance(value, dict | MappingProxyType):
        for name, part in value.items():
            yield from parts(part, f"{path}[{name!r}]")


@pytest.mark.parametrize("noun", NOUNS, ids=NAMES)
def test_a_copy_is_equal_and_as_read_only_as_the_noun_itself(noun):
    for way in COPIES.values():
        assert_copied(noun, way)


def assert_copied(noun, way):
    """Assert that a way to copy a noun changes none of its parts."""
    kept, copied = dict(parts(noun)), dict(parts(way(noun)))
    assert list(kept) == list(copied)
    for path, value in kept.items():
        other = copied[path]
        assert type(other) is type(value), path
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(other, value, err_msg=path)
            assert not other.flags.writeable, path
        elif not dataclasses.is_dataclass(value) and not isinstance(value, tuple | list | dict):
            same = value == other or value != value or isinstance(value, MappingProxyType)
            assert same, (path, value, other)
    assert repr(way(noun)) == repr(noun)


@pytest.mark.parametrize("noun", NOUNS, ids=NAMES)
def test_nothing_in_a_noun_can_be_written_to(noun):
    for path, value in parts(noun):
        if isinstance(value, np.ndarray):
            assert not value.flags.writeable, path
            with pytest.raises(ValueError, match="read-only"):
                value[...] = 0
        assert not isinstance(value, list | dict | set), path
        if dataclasses.is_dataclass(value):
            for field in dataclasses.fields(value):
                with pytest.raises(dataclasses.FrozenInstanceError):
                    setattr(value, field.name, None)


def test_a_noun_leaves_the_arrays_it_is_made_of_as_they_are():
    times = np.arange(3.0)
    response = LoopResponse(times, *np.zeros((3, 3, 3)))
    assert times.flags.writeable
    assert not response.time.flags.writeable
    assert not dataclasses.replace(response, time=times + 1.0).time.flags.writeable


@pytest.mark.parametrize("noun", NOUNS, ids=NAMES)
def test_every_noun_shows_itself(noun):
    assert repr(noun).startswith(type(noun).__name__)
    assert str(noun)


@pytest.mark.parametrize("way", list(COPIES.values())[1:], ids=list(COPIES)[1:])
def test_a_copied_trajectory_cannot_be_written_to_and_goes_on(way):
    copied = way(MOVE)
    for name in ("breaks", "states", "durations", "end_state"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(copied, name)[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        copied.breaks = MOVE.breaks
    np.testing.assert_array_equal(copied.evaluate(TIMES), MOVE.evaluate(TIMES))
    np.testing.assert_array_equal(way(LOOP).respond(way(MOVE), 0.1).outputs, RESPONSE.outputs)
    lag = control.tf([1.0], [1.0, 1.0])
    np.testing.assert_array_equal(
        respond(lag, copied, 0.1).outputs, respond(lag, MOVE, 0.1).outputs
    )
