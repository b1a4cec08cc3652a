"""Co-simulations against exactly sampled loops, their delays, and what is refused."""

import csv
from contextlib import ExitStack
from dataclasses import replace

import control
import numpy as np
import pytest
from handmade_fmus import INERTIA, PD, Model, fmu

from jounce.fmu.cosimulation.cosimulate import cosimulate
from jounce.fmu.exporting.export import export_fmu
from jounce.fmu.exporting.loop_blocks import SampledController
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.plant import PID, Inertia, InertiaFeedforward, zero_order_hold
from jounce.shaping import Limits, min_time_move

VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
DT = 0.001
MOVE = min_time_move(1.0, Limits(velocity=2.0, acceleration=20.0, jerk=400.0))
GAINS = {"kp": 40.0, "kd": 10.0}
LINKS = [
    ("move.position", "controller.r"),
    ("plant.y", "controller.y"),
    ("plant.y_rate", "controller.y_rate"),
    ("controller.u", "plant.u"),
]


@pytest.fixture
def plant(tmp_path):
    with load_fmu(fmu(tmp_path)) as loaded:
        yield loaded


@pytest.fixture
def controller(tmp_path):
    with load_fmu(fmu(tmp_path, PD, "3.0"), parameters=GAINS) as loaded:
        yield loaded


def native_controller():
    return control.ss(
        [], [], [], [[40.0, -40.0, -10.0]], DT, inputs=["r", "y", "y_rate"], outputs=["u"]
    )


def exact(steps, delay=0):
    """Return y at t_0 … t_N and u over each step of the sampled loop, from its recursion."""
    held = zero_order_hold(Inertia(2.0).system(), DT)
    command = MOVE(DT * np.arange(steps + 1))
    x, late = np.zeros(2), [0.0] * delay
    positions, torques = [], []
    for k in range(steps):
        positions.append(x[0])
        late.append(40.0 * (command[k] - x[0]) - 10.0 * x[1])
        torques.append(late.pop(0))
        x = held.A @ x + held.B[:, 0] * torques[-1]
    return np.array([*positions, x[0]]), np.array(torques)


def check(run, expected, tolerance=1e-10):
    positions, torques = expected
    peak = np.abs(torques).max()
    np.testing.assert_allclose(run["plant.y"], positions, rtol=0, atol=tolerance)
    np.testing.assert_allclose(run["plant.u"][:-1], torques, rtol=0, atol=tolerance * peak)


# Orders and their delays


def test_gauss_seidel_is_the_sampled_loop(plant, controller):
    run = cosimulate(
        {"move": MOVE, "controller": controller, "plant": plant}, LINKS, dt=DT, duration=1.0
    )
    check(run, exact(1000))
    assert dict(run.delays) == {
        "move.position -> controller.r": 1,
        "plant.y -> controller.y": 1,
        "plant.y_rate -> controller.y_rate": 1,
        "controller.u -> plant.u": 0,
    }
    assert dict(run.loops) == {"controller -> plant -> controller": 0}
    np.testing.assert_array_equal(run["controller.u"][1:], run["plant.u"][:-1])
    np.testing.assert_array_equal(run["move.position"], [*run["controller.r"][:-1], 1.0])
    assert run["plant.u"][-1] == run["plant.u"][-2]
    assert (run.time[0], run.time[-1], run.time.size) == (0.0, 1.0, 1001)


def test_jacobi_has_one_sample_of_delay_more(plant, controller):
    run = cosimulate(
        {"move": MOVE, "controller": controller, "plant": plant},
        LINKS, dt=DT, duration=1.0, order="jacobi",
    )  # fmt: skip
    check(run, exact(1000, delay=1))
    assert set(run.delays.values()) == {1}
    assert dict(run.loops) == {"controller -> plant -> controller": 1}
    assert "loop controller -> plant -> controller: 1 samples beyond" in str(run)


@pytest.mark.parametrize("own", ["controller", "plant", "both", "neither"])
def test_native_blocks_are_as_good_as_fmus(plant, controller, own):
    blocks = {
        "move": MOVE,
        "controller": native_controller() if own in ("controller", "both") else controller,
        "plant": Inertia(2.0).system() if own in ("plant", "both") else plant,
    }
    check(cosimulate(blocks, LINKS, dt=DT, duration=0.5), exact(500))
    plant.reset()
    controller.reset()
    if own in ("plant", "both"):
        blocks["plant"] = zero_order_hold(Inertia(2.0).system(), DT)
    run = cosimulate(blocks, LINKS, dt=DT, duration=0.5, order="jacobi")
    check(run, exact(500, delay=1))


def test_an_order_by_name(plant, controller):
    """With the plant first the controller's torque comes a step later, and sees a newer y."""
    blocks = {"move": MOVE, "controller": controller, "plant": plant}
    run = cosimulate(blocks, LINKS, dt=DT, duration=0.1, order=["plant", "controller", "move"])
    assert run.order == ("plant", "controller", "move")
    assert run.delays["controller.u -> plant.u"] == 1
    assert run.delays["plant.y -> controller.y"] == 0
    assert dict(run.loops) == {"plant -> controller -> plant": 0}
    assert run["plant.u"][0] == 0.0
    np.testing.assert_array_equal(run["controller.y"][:-1], run["plant.y"][1:])


def test_a_digital_pid_and_a_continuous_plant_as_python_control_has_them():
    pid = PID(40.0, 100.0, 8.0).sampled(DT, rate="differenced")
    plant = Inertia(2.0).transfer()
    loop = control.feedback(pid * zero_order_hold(plant, DT))
    time = DT * np.arange(501)
    expected = control.forced_response(loop, time, MOVE(time))
    run = cosimulate(
        {"pid": pid, "plant": plant, "move": MOVE},
        [("move.position", "pid.e"), ("-plant.y", "pid.e"), ("pid.u_feedback", "plant.u")],
        dt=DT, duration=0.5,
    )  # fmt: skip
    np.testing.assert_allclose(run["plant.y"], expected.outputs, rtol=0, atol=1e-11)


def test_several_sources_signs_numbers_and_targets(plant):
    gain = control.ss([], [], [], [[2.0, 0.0], [0.0, 3.0]], DT, inputs=["a", "b"],
                      outputs=["c", "d"])  # fmt: skip
    run = cosimulate(
        {"gain": gain, "plant": plant},
        [(1.5, "gain.a"), (-4, "gain.b"), ("gain.c", "plant.u"), ("-gain.d", "plant.u"),
         (0.5, "plant.u")],
        dt=DT, duration=2 * DT,
    )  # fmt: skip
    assert run["plant.u"].tolist() == [15.5] * 3
    plant.reset()
    run = cosimulate({"move": MOVE, "gain": gain}, {"move.velocity": ["gain.a", "gain.b"]}, dt=DT,
                     duration=0.2)  # fmt: skip
    np.testing.assert_allclose(run["gain.c"][1:], 2.0 * run["move.velocity"][:-1], rtol=1e-15)
    np.testing.assert_allclose(run["move.velocity"], MOVE(run.time, 1), rtol=1e-15)


def test_a_held_input_that_jumps_shows_at_the_steps_end():
    lead = control.tf([1.0, 2.0], [1.0, 1.0], inputs="u", outputs="y")
    run = cosimulate({"lead": lead}, [(1.0, "lead.u")], dt=0.1, duration=0.3)
    expected = 2.0 - np.exp(-run.time)
    np.testing.assert_allclose(run["lead.y"][1:], expected[1:], rtol=1e-13)
    assert run["lead.y"][0] == 0.0


def test_fmus_go_on_from_where_they_stand(plant):
    links = [(1.0, "plant.u")]
    first = cosimulate({"plant": plant}, links, dt=DT, duration=0.5)
    second = cosimulate({"plant": plant}, links, dt=DT, duration=0.5)
    assert (first.time[-1], second.time[0], plant.time) == (0.5, 0.5, 1.0)
    assert first["plant.y"][-1] == second["plant.y"][0]
    np.testing.assert_allclose(second["plant.y"][-1], 0.25, rtol=1e-12)
    loose = cosimulate({"plant": plant}, [], dt=DT, duration=DT)
    assert loose["plant.u"].tolist() == [1.0, 1.0]


def test_a_long_run_loses_no_step(tmp_path):
    clock = Model("clock", inputs=(), states=1, step="x[0] += 1.0; y[0] = x[0];")
    with load_fmu(fmu(tmp_path, clock)) as ticking:
        run = cosimulate({"clock": ticking}, [], dt=DT, duration=100.0)
    np.testing.assert_array_equal(run["clock.y"], np.arange(100_001))


@VERSIONS
def test_a_loop_of_exported_blocks(tmp_path, version):
    """Shaper, digital PID with feedforward, plant: all FMUs, against python-control."""
    pid = PID(40.0, 100.0, 8.0)
    blocks = {
        "controller": SampledController(pid, DT, InertiaFeedforward(1.5)),
        "plant": Inertia(2.0),
        "move": MOVE,
    }
    links = [
        ("move.position", "controller.r"),
        ("move.velocity", "controller.r_rate"),
        ("move.acceleration", "controller.r_acceleration"),
        *LINKS[1:],
    ]
    with ExitStack() as stack:
        loaded = {}
        for name, block in blocks.items():
            path = tmp_path / f"{name}.fmu"
            export_fmu(block, path, fmi_version=version, platforms=["x86_64-linux"])
            loaded[name] = stack.enter_context(load_fmu(path))
        run = cosimulate(loaded, links, dt=DT, duration=1.0)
    time = DT * np.arange(1001)
    held = zero_order_hold(Inertia(2.0).system(), DT)
    loop = control.feedback(held * pid.sampled(DT), control.ss([], [], [], np.eye(2), DT))
    fed = control.feedback(held, -pid.sampled(DT), sign=1)
    expected = (
        control.forced_response(loop, time, [MOVE(time), MOVE(time, 1)]).outputs[0]
        + control.forced_response(fed, time, 1.5 * MOVE(time, 2)).outputs[0]
    )
    np.testing.assert_allclose(run["plant.y"], expected, rtol=0, atol=1e-10)
    assert dict(run.loops) == {"controller -> plant -> controller": 0}


# Results


def test_the_csv_file_holds_every_digit(plant, controller, tmp_path):
    run = cosimulate(
        {"move": MOVE, "controller": controller, "plant": plant}, LINKS, dt=DT, duration=0.05
    )
    path = tmp_path / "run.csv"
    path.write_text("old")
    run.to_csv(path)
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["time", *run.signals]
    table = np.array(rows[1:], dtype=float)
    np.testing.assert_array_equal(table[:, 0], run.time)
    np.testing.assert_array_equal(table[:, 1:].T, list(run.signals.values()))
    with pytest.raises(OSError, match="none"):
        run.to_csv(tmp_path / "none" / "run.csv")
    assert {entry.suffix for entry in tmp_path.iterdir()} == {".csv", ".fmu"}


def test_results_are_read_only_and_know_their_names(plant):
    run = cosimulate({"plant": plant}, [], dt=DT, duration=DT)
    assert run.outputs == ("plant.y", "plant.y_rate")
    with pytest.raises(ValueError, match="read-only"):
        run["plant.y"][0] = 1.0
    with pytest.raises(FmuError, match=r"no signal 'plant\.z': did you mean 'plant\.y'"):
        run["plant.z"]


def test_a_progress_bar_on_demand(capfd):
    lag = control.tf([1], [1, 1], inputs="u", outputs="y")
    for wanted, length in ((True, 1), (False, 0), (None, 0)):
        cosimulate({"lag": lag}, [(1.0, "lag.u")], dt=DT, duration=0.1, progress=wanted)
        assert ("co-simulation" in capfd.readouterr().err) == bool(length)


# What is refused


@pytest.mark.parametrize(
    ("links", "match"),
    [
        ([("controler.u", "plant.u")], "no output 'controler.u': did you mean 'controller.u'"),
        ([("controller.u", "plant.v")], "no input 'plant.v': did you mean 'plant.u'"),
        ([("plant.u", "controller.y")], "'plant.u' is an input; a connection goes from"),
        ([("plant.y", "controller.u")], "'controller.u' is an output; a connection goes from"),
        ([("plant.y", "controller.y")], "'controller.r' is connected to nothing"),
        (["controller.u"], "expected a pair"),
        ([("a", "b", "c")], "expected a pair"),
        ([(np.nan, "plant.u")], "source of plant.u = nan"),
        ([("", "plant.u")], "no output ''"),
    ],
    ids=str,
)
def test_connections_that_are_refused(plant, links, match):
    with pytest.raises(ValueError, match=match):
        cosimulate({"controller": native_controller(), "plant": plant}, links, dt=DT, duration=1.0)


def test_algebraic_loops_are_named():
    def gain(inputs, outputs):
        return control.ss([], [], [], np.ones((1, len(inputs))), DT, inputs=inputs, outputs=outputs)

    blocks = {"a": gain(["x"], ["y"]), "b": gain(["x"], ["y"]), "c": gain(["x"], ["y"])}
    links = {"a.y": "b.x", "b.y": ["a.x", "c.x"]}
    with pytest.raises(
        FmuError, match=r"algebraic loop (a\.y -> b\.y -> a\.y|b\.y -> a\.y -> b\.y)"
    ):
        cosimulate(blocks, links, dt=DT, duration=1.0)
    blocks["b"] = control.ss([[0.5]], [[1.0]], [[1.0]], 0, DT, inputs=["x"], outputs=["y"])
    cosimulate(blocks, links, dt=DT, duration=10 * DT)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"duration": 0.0015}, "1.5 steps of dt"),
        ({"duration": 0.0}, "duration = 0"),
        ({"duration": 1e-4}, "0.1 steps"),
        ({"duration": 1e9}, "expected a whole number, 1 to"),
        ({"dt": -1.0}, "dt = -1"),
        ({"order": "parallel"}, "expected 'gauss-seidel', 'jacobi' or"),
        ({"order": ["plant", "plan"]}, "order: no block 'plan': did you mean 'plant'"),
        ({"order": ["plant", "plant"]}, "each of plant once"),
    ],
    ids=str,
)
def test_arguments_that_are_refused(plant, options, match):
    with pytest.raises(ValueError, match=match):
        cosimulate({"plant": plant}, [], **{"dt": DT, "duration": 1.0, **options})


def test_blocks_that_are_refused(plant, tmp_path):
    with pytest.raises(FmuError, match="no blocks"):
        cosimulate({}, [], dt=DT, duration=1.0)
    with pytest.raises(FmuError, match=r"block name 'a\.b'"):
        cosimulate({"a.b": plant}, [], dt=DT, duration=1.0)
    with pytest.raises(TypeError, match="block 'plant' is a str: expected an Fmu"):
        cosimulate({"plant": "plant.fmu"}, [], dt=DT, duration=1.0)
    with pytest.raises(FmuError, match="load the file twice"):
        cosimulate({"a": plant, "b": plant}, [], dt=DT, duration=1.0)
    with pytest.raises(FmuError, match=r"sampled every 0\.002"):
        cosimulate({"a": control.tf([1], [1, 0.5], 0.002)}, [], dt=DT, duration=1.0)
    same = control.tf([1], [1, 1], inputs="y", outputs="y")
    with pytest.raises(FmuError, match="y is an input and an output"):
        cosimulate({"a": same}, [], dt=DT, duration=1.0)
    late = load_fmu(fmu(tmp_path, replace(INERTIA, name="late")), start_time=1.0)
    with late, pytest.raises(FmuError, match="a at 0, b at 1"):
        cosimulate({"a": plant, "b": late}, [], dt=DT, duration=1.0)


def test_an_unstable_loop_is_told(plant):
    wild = control.ss([[1e3]], [[1.0]], [[1.0]], 0, DT, inputs=["y"], outputs=["u"])
    links = {"plant.y": "wild.y", "wild.u": "plant.u"}
    with pytest.raises(FmuError, match=r"wild\.u.* left the range|input is not finite"):
        cosimulate({"wild": wild, "plant": plant}, [*links.items(), (1.0, "plant.u")], dt=DT,
                   duration=1.0)  # fmt: skip
