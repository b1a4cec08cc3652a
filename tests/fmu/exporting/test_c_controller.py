"""The sampled controller in C, alone and in a loop with the inertia."""

import control
import numpy as np
import pytest
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu import SampledController
from jounce.plant import PID, Inertia, InertiaFeedforward, ServoLoop, design_pid

pytestmark = needs_compiler

DT = 0.01
GAINS = PID(kp=10.0, ki=20.0, kr=3.0)


def measured():
    return SampledController(GAINS, DT, InertiaFeedforward(2.0))


def differenced():
    return SampledController(GAINS, DT, rate="differenced")


def servo_controller():
    gains = design_pid(1.0, crossover_hz=4.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    return SampledController(gains, DT)


def unit_inertia():
    return Inertia(1.0)


@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize("make", [measured, differenced])
def test_it_is_the_controller_of_the_library(make, version):
    names = ["r", "r_acceleration", "y"] + (["r_rate", "y_rate"] if make is measured else [])
    rng = np.random.default_rng(1)
    given = {name: rng.normal(size=200) for name in names}
    host = Host(fmu_of(make, version)).run()
    [torque] = host.record([DT] * 200, "u", **given)
    host.close()
    inputs = [given["r"] - given["y"]]
    if make is measured:
        inputs.append(given["r_rate"] - given["y_rate"])
    digital = make().controller.sampled(DT, rate=make().rate)
    expected = control.forced_response(digital, DT * np.arange(200), np.array(inputs)).outputs
    if make().feedforward:
        expected = expected + make().feedforward.J_hat * given["r_acceleration"]
    assert np.abs(torque - expected).max() <= 1e-12 * np.abs(expected).max()


def test_between_samples_the_torque_is_held():
    host = Host(fmu_of(measured, "2.0")).run(r=1.0)
    host.step(DT)
    first = host.get("u")
    host.set(r=5.0)
    assert host.get("u") == first
    host.step(0.4 * DT)
    second = host.get("u")
    assert second != first
    host.set(r=-5.0)
    host.step(0.6 * DT)
    assert host.get("u") == second
    host.step(DT)
    assert host.get("u") != second
    host.close()


def test_gains_can_be_tuned():
    host = Host(fmu_of(measured, "3.0")).run()
    host.set(r=1.0, kp=7.0, ki=0.0, kr=0.0, J_hat=0.0)
    host.step(DT)
    assert host.get("u") == [7.0]
    assert "below its minimum 0" in host.refused(host.set, J_hat=-1.0)
    host.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_the_loop_is_the_sampled_loop(version):
    """Controller first, then the plant: no delay beside the hold."""
    controller = Host(fmu_of(servo_controller, version)).run(r=1.0)
    plant = Host(fmu_of(unit_inertia, version)).run()
    positions, steps = [], 300
    for _ in range(steps):
        y, y_rate = plant.get("y", "y_rate")
        positions.append(y)
        controller.set(y=y, y_rate=y_rate)
        controller.step(DT)
        plant.set(u=controller.get("u")[0])
        plant.step(DT)
    controller.close()
    plant.close()
    sampled = servo_controller()
    loop = ServoLoop(Inertia(1.0), sampled.controller).sampled_loop_transfer(DT)
    poles = loop.feedback().poles()
    assert np.abs(poles).max() < 1.0
    expected = _loop_response(sampled.controller, steps)
    np.testing.assert_allclose(positions, expected, rtol=0.0, atol=1e-12)
    assert abs(positions[-1] - 1.0) < 1e-2


def _loop_response(gains, steps):
    """Return y_k of the loop from its equations, each written out."""
    y, v, total, rows = 0.0, 0.0, 0.0, []
    for _ in range(steps):
        rows.append(y)
        total += DT * (1.0 - y)
        u = gains.kp * (1.0 - y) + gains.ki * total - gains.kr * v
        y, v = y + DT * v + 0.5 * DT**2 * u, v + DT * u
    return rows


def test_what_is_no_controller_is_refused():
    with pytest.raises(TypeError, match="expected PID"):
        SampledController(Inertia(1.0), DT)
    with pytest.raises(TypeError, match="expected InertiaFeedforward"):
        SampledController(GAINS, DT, 3.0)
    with pytest.raises(ValueError, match=r"dt = 0\.0"):
        SampledController(GAINS, 0.0)
    with pytest.raises(ValueError, match="'measured' or 'differenced'"):
        SampledController(GAINS, DT, rate="guessed")
