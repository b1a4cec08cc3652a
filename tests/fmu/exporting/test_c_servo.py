"""A whole servo loop as one FMU and as C: against a loop of matrix exponentials in Python."""

import numpy as np
import pytest
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from scipy.linalg import expm
from tiers import some

from jounce.fmu import SampledLoop, export_fmu
from jounce.plant import PID, FlexibleInertia, Inertia, InertiaFeedforward, ServoLoop
from jounce.shaping import JerkFilter, Limits, min_time_move

pytestmark = needs_compiler

DT = 0.002
SHOWN = ("r", "r_rate", "r_acceleration", "u", "y", "y_rate")


def move():
    return min_time_move(0.5, Limits(velocity=1.0, acceleration=5.0)).shift(2.0).delay(0.25)


def stiff():
    loop = ServoLoop(Inertia(2.0), PID(900.0, 600.0, 80.0), InertiaFeedforward(1.8))
    return SampledLoop(move(), loop, DT)


def flexible():
    plant = FlexibleInertia(2.0, frequency_hz=30.0, damping=0.02, load_fraction=0.3)
    loop = ServoLoop(plant, PID(900.0, 600.0, 80.0), InertiaFeedforward(2.0))
    return SampledLoop(move(), loop, DT, JerkFilter(20.0, 4))


def ramp():
    """Return a loop whose command is of order 1: its acceleration only the filter makes."""
    loop = ServoLoop(Inertia(2.0), PID(900.0, 600.0, 80.0), InertiaFeedforward(2.0))
    return SampledLoop(min_time_move(0.5, Limits(velocity=1.0)), loop, DT, JerkFilter(20.0, 3))


def shaped(sampled, count):
    """Return the command with its derivatives at samples 0 to count, behind the filter if any."""
    trajectory, behind = sampled.trajectory, sampled.jerk_filter
    if behind is not None:
        return behind.respond(trajectory, DT, duration=count * DT).states[:3]
    times = trajectory.start_time + DT * np.arange(count + 1)
    return np.array([trajectory(times, k) for k in range(3)])


def simulated(sampled, disturbance):
    """Return what is shown at the end of each sample, rows of SHOWN."""
    plant, gains = sampled.loop.plant.system(), sampled.loop.controller
    n, count = plant.nstates, len(disturbance)
    both = expm(DT * np.block([[plant.A, plant.B], [np.zeros((1, n + 1))]]))
    labels = list(plant.output_labels)
    c = plant.C[[labels.index("y"), labels.index("y_rate")]]
    r = shaped(sampled, count)
    x, integral, rows = np.zeros(n), 0.0, []
    x[list(plant.state_labels).index("y")] = r[0, 0]
    for k in range(count):
        (e, e_rate), acceleration = r[:2, k] - c @ x, r[2, k]
        integral += DT * e
        u = gains.kp * e + gains.ki * integral + gains.kr * e_rate
        u += sampled.loop.feedforward.J_hat * acceleration
        x = both[:n, :n] @ x + both[:n, n] * (u + disturbance[k])
        rows.append([*r[:, k + 1], u, *(c @ x)])
    return np.array(rows).T


@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize("make", [stiff, flexible, ramp])
def test_the_loop_is_that_of_matrix_exponentials(make, version):
    disturbance = np.random.default_rng(4).normal(size=800)
    expected = simulated(make(), disturbance)
    host = Host(fmu_of(make, version), start=make().trajectory.start_time).run()
    rows = host.record([DT] * 800, *SHOWN, d=disturbance)
    host.close()
    scale = np.abs(expected).max(axis=1, keepdims=True)
    smooth = [0, 1, 3, 4, 5] if make is stiff else range(6)  # an acceleration may jump at a sample
    assert (np.abs(rows - expected) <= 1e-9 * scale)[smooth].all()


@pytest.mark.parametrize("parts", [3, 7])
@pytest.mark.parametrize("make", [stiff, flexible])
def test_steps_of_any_length_give_the_same_motion(make, parts):
    start = make().trajectory.start_time
    expected = simulated(make(), np.ones(420))
    host = Host(fmu_of(make, "2.0"), start=start).run(d=1.0)
    fine = host.record([DT / parts] * (420 * parts), *SHOWN)[:, parts - 1 :: parts]
    host.close()
    host = Host(fmu_of(make, "2.0"), start=start).run(d=1.0)
    coarse = host.record([DT * parts] * (420 // parts), *SHOWN)
    host.close()
    scale = np.abs(expected).max(axis=1)
    for row in (0, 1, 4, 5):
        for found, step in ((fine, 1), (coarse, parts)):
            error = np.abs(found[row] - expected[row, step - 1 :: step])
            assert error.max() <= 1e-9 * scale[row]


def test_gains_can_be_tuned_and_states_started_elsewhere():
    host = Host(fmu_of(stiff, "3.0"), start=0.25)
    host.set(kp=0.0, ki=0.0, kr=0.0, J_hat=0.0)
    host.set(**{"state.y": 3.0, "state.y_rate": -1.0})
    host.run()
    rows = host.record([DT] * 100, "y", "u")
    host.close()
    np.testing.assert_allclose(rows[0], 3.0 - DT * np.arange(1, 101), rtol=1e-12)
    assert not rows[1].any()


def test_what_is_no_loop_is_refused(tmp_path):
    loop = stiff().loop
    with pytest.raises(ValueError, match="dt"):
        SampledLoop(move(), loop, 0.0)
    with pytest.raises(TypeError, match="expected a ServoLoop"):
        SampledLoop(move(), Inertia(1.0), DT)
    with pytest.raises(ValueError, match="puts out no acceleration"):
        SampledLoop(move(), loop, DT, JerkFilter(3.0, 2))
    with pytest.raises(ValueError, match="unit"):
        export_fmu(stiff(), tmp_path / "a.fmu", platforms=[], unit="furlong")
