"""A servo loop as an SSP: valid, read back by FMPy, reproducible, and refused where it is wrong."""

import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import control
import fmpy.ssp.simulation
import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd
from fmus import needs_compiler

from jounce.fmu import CompilerError, SampledController, load_ssp
from jounce.fmu.cosimulation.cosimulate import cosimulate
from jounce.fmu.exporting import compile
from jounce.fmu.exporting.dispatch import block_of
from jounce.fmu.exporting.ssp import SSD, export_ssp, export_ssp_of
from jounce.fmu.importing.load import load_fmu
from jounce.fmu.importing.reading import inspect_fmu
from jounce.plant import PID, FlexibleInertia, Inertia, InertiaFeedforward, ServoLoop
from jounce.shaping import JerkFilter, Limits, min_time_move

DT = 1.0 / 128.0
MOVE = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=20.0), start=3.0)
LOOP = ServoLoop(Inertia(2.0), PID(kp=90.0, ki=60.0, kr=20.0), InertiaFeedforward(2.0))
FLEXIBLE = ServoLoop(FlexibleInertia(2.0, 20.0, 0.01), LOOP.controller)


@pytest.fixture
def export(tmp_path):
    """Export sources only, unless told otherwise; give the path."""

    def call(name="loop.ssp", trajectory=MOVE, loop=LOOP, **options):
        path = tmp_path / name
        export_ssp(path, trajectory, loop, **{"dt": DT, "platforms": [], "unit": "rad"} | options)
        return path

    return call


def inside(path, name, where):
    """Return the path of a file in an archive, unpacked."""
    with zipfile.ZipFile(path) as archive:
        return Path(archive.extract(name, where))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("behind", [None, JerkFilter(5.0, 4)], ids=["plain", "filtered"])
@pytest.mark.parametrize("loop", [LOOP, FLEXIBLE], ids=["rigid", "flexible"])
def test_fmpy_reads_a_valid_system(export, tmp_path, version, behind, loop):
    path = export(loop=loop, jerk_filter=behind, fmi_version=version)
    read = read_ssd(str(path), validate=True)  # against the schema of SSP 1.0
    found = {component.name: component for component in read.system.elements}
    names = ["controller", "plant", *(["filter"] if behind else []), "shaper"]
    assert list(found) == names
    linked = {
        (c.startElement, c.startConnector, c.endElement, c.endConnector)
        for c in read.system.connections
    }
    inputs = {(n, c.name) for n in names for c in found[n].connectors if c.kind == "input"}
    assert {link[2:] for link in linked} == inputs, "every input has a source"
    assert len(linked) == len(inputs)
    for name, component in found.items():
        fmu = inspect_fmu(inside(path, component.source, tmp_path))
        assert fmu.fmi_version == version
        assert fmu.model_identifier == name
        assert fmu.default_experiment.step_size == DT
        signals = fmu.of_causality("input", "output")
        assert [(c.name, c.kind) for c in component.connectors] == [
            (v.name, v.causality) for v in signals
        ]


def test_connectors_have_the_units_of_the_fmus(export, tmp_path):
    path = export(loop=FLEXIBLE, unit="mm")
    root = ElementTree.fromstring(zipfile.ZipFile(path).read(SSD))
    spaces = {
        "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
        "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    }
    defined = {e.get("name"): e for e in root.findall("ssd:Units/ssc:Unit", spaces)}
    assert defined["mm/s"].find("ssc:BaseUnit", spaces).attrib == {
        "factor": "0.001",
        "m": "1",
        "s": "-1",
    }
    for component in root.iter(f"{{{spaces['ssd']}}}Component"):
        fmu = inspect_fmu(inside(path, component.get("source"), tmp_path))
        for connector in component.iter(f"{{{spaces['ssd']}}}Connector"):
            unit = connector.find("ssc:Real", spaces).get("unit")
            assert unit == fmu.variable(connector.get("name")).unit
            assert unit in defined
    units = {c.get("name"): c.find("ssc:Real", spaces).get("unit")
             for c in root.iter(f"{{{spaces['ssd']}}}Connector")}  # fmt: skip
    assert [units[n] for n in ("u", "y", "y_rate", "y_load", "twist")] == [
        "N",
        "mm",
        "mm/s",
        "mm",
        "mm",
    ]


def test_the_experiment_lasts_as_long_as_the_motion(export):
    move = min_time_move(1.0, Limits(acceleration=2.0))
    slow = JerkFilter(1.0, 3)
    for options, least in (
        ({}, move.duration),
        ({"jerk_filter": slow}, move.duration + slow.settling_time(1e-6)),
        ({"duration": 5.0}, 5.0),
    ):
        text = zipfile.ZipFile(export(trajectory=move, **options)).read(SSD).decode()
        stop = float(re.search(r'stopTime="([^"]+)"', text)[1])
        assert least <= stop < least + DT
        assert stop / DT == round(stop / DT)


def test_the_same_system_is_the_same_file(export):
    assert export("a.ssp").read_bytes() == export("b.ssp").read_bytes()


@needs_compiler
def test_fmpy_simulates_it_as_a_loop_with_one_delay(export, monkeypatch):
    monkeypatch.setattr(compile, "_FLAGS", [f.replace("-O2", "-O0") for f in compile._FLAGS])
    move = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=20.0))
    path = export(trajectory=move, platforms=["host"])
    found = fmpy.ssp.simulation.simulate_ssp(str(path), stop_time=200 * DT, step_size=DT)
    time = DT * np.arange(200)
    fed = [move(time, k) for k in range(3)]
    expected = control.forced_response(sampled_loop(late=True), time, np.array(fed)).outputs[0]
    # what a row of FMPy tells of the plant is its state at the end of the step
    assert np.abs(found["plant.y"][:-1] - expected[1:]).max() <= 1e-9


def sampled_loop(*, late, dt=DT):
    """Return r, r_rate, r_acceleration -> y, the torque held, and one sample late or not."""
    plant = control.c2d(LOOP.plant.system(), dt)
    gains = LOOP.controller
    own = gains.kp + dt * gains.ki
    controller = control.ss(
        [[1.0]],
        [[dt, 0.0, 0.0, -dt, 0.0]],
        [[gains.ki]],
        [[own, gains.kr, LOOP.feedforward.J_hat, -own, -gains.kr]],
        dt,
        inputs=["r", "r_rate", "r_acceleration", "y", "y_rate"],
        outputs="torque",
    )
    wire = ([[0.0]], [[1.0]], [[1.0]], [[0.0]]) if late else ([], [], [], [[1.0]])
    delay = control.ss(*wire, dt, inputs="torque", outputs="u")
    inputs = ["r", "r_rate", "r_acceleration"]
    return control.interconnect(
        [control.ss(plant, inputs="u", outputs=["y", "y_rate"], name="plant"), delay, controller],
        inputs=inputs,
        inplist=inputs,
        outputs=["y"],
        outlist=["y"],
    )


@needs_compiler
@pytest.mark.parametrize("behind", [None, JerkFilter(5.0, 4)], ids=["plain", "filtered"])
def test_in_the_order_of_the_file_it_is_the_sampled_loop(export, tmp_path, monkeypatch, behind):
    monkeypatch.setattr(compile, "_FLAGS", [f.replace("-O2", "-O0") for f in compile._FLAGS])
    dt = DT / 8.0
    path = export(platforms=["host"], jerk_filter=behind, dt=dt)
    read = read_ssd(str(path))
    blocks = {
        c.name: load_fmu(inside(path, c.source, tmp_path), dt=dt) for c in read.system.elements
    }
    links = [
        (f"{c.startElement}.{c.startConnector}", f"{c.endElement}.{c.endConnector}")
        for c in read.system.connections
    ]
    try:
        found = cosimulate(blocks, links, dt=dt, duration=1024 * dt)
    finally:
        for fmu in blocks.values():
            fmu.close()
    assert set(found.loops.values()) == {0}
    shown = [found[f"controller.{name}"] for name in ("r", "r_rate", "r_acceleration")]
    shown[0] = shown[0] - 3.0
    closed = sampled_loop(late=False, dt=dt)
    expected = 3.0 + control.forced_response(closed, found.time, np.array(shown)).outputs[0]
    assert np.abs(found["plant.y"] - expected).max() <= 1e-9
    exact = LOOP.respond(MOVE, dt, duration=1024 * dt, jerk_filter=behind)
    ahead = slice(None, -1)  # at the end the input of the last step is told again
    # the filter takes the move's acceleration as constant within each step
    allowed = 1e-12 if behind is None else dt**2 * MOVE.peak(2)
    assert np.abs(found["controller.r"] - exact.command)[ahead].max() <= allowed


@needs_compiler
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_what_left_comes_back_as_the_sampled_loop(export, monkeypatch, version):
    """Parameters and gains written into the file, and what they do, are those of the loop."""
    monkeypatch.setattr(compile, "_FLAGS", [f.replace("-O2", "-O0") for f in compile._FLAGS])
    path = export(platforms=["host"], fmi_version=version)
    with load_ssp(path) as system:
        assert (system.name, system.dt, system.notes) == ("servo_loop", DT, ())
        found = system.run()
        assert system.blocks["plant"].parameters["J"] == 2.0
    assert found.time[-1] >= MOVE.end_time > found.time[-2]
    assert dict(found.loops) == {"controller -> plant -> controller": 0}
    fed = [found[f"controller.{name}"] for name in ("r", "r_rate", "r_acceleration")]
    inputs = np.array([fed[0] - 3.0, *fed[1:]])
    closed = sampled_loop(late=False)
    expected = 3.0 + control.forced_response(closed, found.time, inputs).outputs[0]
    assert np.abs(found["plant.y"] - expected).max() <= 1e-9
    np.testing.assert_array_equal(found["plant.y"][:1], 3.0)
    shaped = [MOVE(found.time[:-1], k) for k in range(3)]
    np.testing.assert_allclose(np.array(fed)[:, :-1], shaped, rtol=0, atol=1e-12)


def test_blocks_of_ones_own_are_connected_by_name(tmp_path):
    path = tmp_path / "own.ssp"
    lag = control.tf([1.0], [0.1, 1.0], inputs="u", outputs="v")
    made = export_ssp_of(
        path,
        {"first": lag, "second": control.tf([1.0], [1.0, 0.0], inputs="v", outputs="w")},
        [("first.v", "second.v")],
        dt=0.01,
        duration=2.0,
        platforms=[],
        name="chain",
    )
    assert made.components == ("first", "second")
    read = read_ssd(str(path), validate=True)
    assert read.name == "chain"
    (link,) = read.system.connections
    assert (link.startElement, link.endElement) == ("first", "second")


@pytest.mark.parametrize(
    ("links", "words"),
    [
        (["a.v"], ["connection 'a.v'", "a pair"]),
        ([("a.v", "b.x")], ["no input 'b.x'", "b.u"]),
        ([("a.u", "b.u")], ["no output 'a.u'", "a.v"]),
        ([("a.v", "b.u"), ("b.v", "b.u")], ["'b.u'", "two sources"]),
        ([("a.v", "c.r")], ["'a.v' is in 1", "'c.r' in m", "one unit"]),
    ],
    ids=["text", "sink", "source", "twice", "units"],
)
def test_wrong_connections_are_refused(tmp_path, links, words):
    lag = control.tf([1.0], [0.1, 1.0], inputs="u", outputs="v")
    axis = block_of(SampledController(LOOP.controller, DT), name="c", unit="m")
    blocks = {"a": lag, "b": lag, "c": axis}
    with pytest.raises(ValueError, match=re.escape(words[0])) as error:
        export_ssp_of(tmp_path / "x.ssp", blocks, links, dt=DT, duration=1.0)
    assert all(word in str(error.value) for word in words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"trajectory": min_time_move(1.0, Limits(velocity=1.0))}, ValueError, "acceleration"),
        ({"jerk_filter": JerkFilter(5.0, 2)}, ValueError, "order 3 or more"),
        ({"jerk_filter": 5.0}, TypeError, "JerkFilter"),
        ({"loop": LOOP.plant}, TypeError, "expected a ServoLoop"),
        ({"trajectory": 1.0}, TypeError, "expected a Trajectory"),
        ({"dt": 0.0}, ValueError, "dt = 0"),
        ({"dt": np.nan}, ValueError, "dt = nan"),
        ({"dt": 1e-320}, ValueError, "steps"),
        ({"platforms": "host"}, TypeError, "expected a list"),
        ({"duration": -1.0}, ValueError, "duration"),
        ({"unit": "kg"}, ValueError, "unit of position"),
        ({"fmi_version": "1.0"}, ValueError, "'2.0' or '3.0'"),
        ({"platforms": ["vax"]}, ValueError, "vax"),
        ({"name": "no/such.ssp"}, FileNotFoundError, "create it first"),
    ],
    ids=lambda value: None if isinstance(value, type | str) else next(iter(value)),
)
def test_what_cannot_be_exported_is_refused_and_leaves_nothing(
    export, tmp_path, options, error, words
):
    with pytest.raises(error, match=words):
        export(**options)
    assert not list(tmp_path.iterdir())


def test_a_system_needs_components_with_names_of_c(tmp_path):
    for blocks, words in (({}, "at least one"), ({"1st": Inertia(1.0)}, "C identifier")):
        with pytest.raises(ValueError, match=words):
            export_ssp_of(tmp_path / "x.ssp", blocks, [], dt=DT, duration=1.0, platforms=[])
    assert not list(tmp_path.iterdir())


def test_a_filter_makes_up_for_a_jump_of_the_velocity(export):
    path = export(
        trajectory=min_time_move(1.0, Limits(velocity=1.0)), jerk_filter=JerkFilter(5.0, 3)
    )
    read = read_ssd(str(path), validate=True)
    assert ("shaper", "velocity") in {
        (c.startElement, c.startConnector) for c in read.system.connections
    }


def test_a_compiler_that_fails_leaves_the_old_file(export, monkeypatch):
    path = export()
    before = path.read_bytes()

    def fail(*_, **__):
        raise CompilerError("no")

    monkeypatch.setattr("jounce.fmu.exporting.export.build", fail)
    with pytest.raises(CompilerError):
        export(platforms=["x86_64-linux"])
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]
