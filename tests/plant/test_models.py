"""Models of bare numbers beside python-control's systems."""

import subprocess
import sys
from pathlib import Path

import control
import numpy as np
import pytest

from jounce.analysis import loop_margins
from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Controller,
    FlexibleMode,
    Inertia,
    LowPass,
    Notch,
    ServoLoop,
)
from jounce.plant.models import Rational, StateModel

MODE = FlexibleMode(6.0, 0.01, load_fraction=0.5)
LOW = LowPass(60.0)
NOTCH = Notch(9.0, zero_damping=0.05, pole_damping=0.5)
FAST = {"sample_time": 1e-3, "delay": 1.5e-3}
LAW = PID(400.0, 700.0, 90.0, derivative_filter=2e-3)
LOOPS = {
    "ideal": ServoLoop(Inertia(1.0), PID(28.0, 38.0, 5.4)),
    "flexible": ServoLoop(Axis(2.0, modes=MODE, viscous=1.0), PID(40.0, 70.0, 25.0)),
    "digital": ServoLoop(
        Axis(2.0, modes=MODE, current_lag=1e-3), Controller(LAW, filters=NOTCH, **FAST)
    ),
    "two encoders": ServoLoop(
        Axis(2.0, modes=MODE, sensor="both"), Controller(CascadedPI(8.0, 30.0, 0.3), **FAST)
    ),
    "filtered": ServoLoop(Axis(2.0, viscous=1.0), Controller(LAW, filters=LOW)),
    "continuous, two encoders": ServoLoop(
        Axis(2.0, modes=MODE, sensor="both"), Controller(CascadedPI(4.0, 30.0, 0.3))
    ),
}
OMEGA = np.geomspace(0.1, 900.0, 200)


def values(system):
    points = 1j * OMEGA
    return system(np.exp(points * system.dt) if system.isdtime(strict=True) else points)


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_numbers_are_those_of_the_systems(loop):
    model, system = loop.open_model(), loop.loop_transfer()
    np.testing.assert_allclose(values(model), values(system), rtol=1e-9)
    np.testing.assert_allclose(np.sort(abs(model.poles())), np.sort(abs(system.poles())), atol=1e-5)
    for name in ("S", "T", "PS", "CS"):
        bare, whole = (getattr(f(), name) for f in (loop.sensitivity_models, loop.sensitivity))
        np.testing.assert_allclose(values(bare), values(whole), rtol=1e-9)
    of_loop, of_system = loop_margins(loop), loop_margins(system)
    assert of_loop.phase_margin_deg == pytest.approx(of_system.phase_margin_deg, rel=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_a_state_model_is_what_control_makes_of_it(seed):
    rng = np.random.default_rng(seed)
    n, direct = int(rng.integers(1, 6)), float(seed % 2)
    matrices = (
        *(rng.standard_normal((n, n)) - 2.0 * np.eye(n), rng.standard_normal((n, 1))),
        *(rng.standard_normal((1, n)), np.array([[direct]])),
    )
    model, system = StateModel(*matrices), control.ss(*matrices)
    points = 1j * np.geomspace(0.01, 100.0, 20)
    np.testing.assert_allclose(model(points), system(points), rtol=1e-10)
    assert model(1j) == pytest.approx(system(1j))
    closed = system.feedback()
    np.testing.assert_allclose(
        np.sort_complex(model.feedback().poles()), np.sort_complex(closed.poles())
    )
    zeros = model.zeros()
    for zero in system.zeros()[abs(system.zeros()) < 1e6]:
        assert abs(zeros - zero).min() < 1e-6 * (1.0 + abs(zero))
    np.testing.assert_allclose((3.0 * model)(points), 3.0 * system(points), rtol=1e-10)


def test_a_quotient_is_what_control_makes_of_it():
    above, below = np.array([1.0, 3.0]), np.array([2.0, 1.0, 5.0])
    model, system = Rational(above, below), control.tf(above, below)
    assert model(2j) == pytest.approx(system(2j))
    np.testing.assert_allclose(
        np.sort(model.feedback().poles()), np.sort(system.feedback().poles())
    )
    np.testing.assert_allclose((2.0 * model).zeros(), system.zeros())


@pytest.mark.parametrize("example", ["telescope", "servo_drive"])
def test_a_check_needs_no_python_control(example):
    code = (
        "import sys; sys.modules.update(control=None, scipy=None, matplotlib=None); "
        "from jounce.app.command_line import main; main()"
    )
    path = Path(__file__).parents[2] / "examples" / f"{example}.toml"
    command = [sys.executable, "-c", code, "survey", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "phase margin" in done.stdout
