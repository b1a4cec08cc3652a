"""Digital controllers as FMU and C: plain Python and the simulation to the last bit."""

from dataclasses import replace
from math import floor, inf

import every_block
import numpy as np
import pytest
from firmware import driven
from fmus import VERSIONS, Host, fmu_of, needs_compiler

from jounce.fmu import DigitalController
from jounce.fmu.exporting import export_c as writing
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
    LeadLag,
    LowPass,
    Notch,
    ServoLoop,
)
from jounce.plant.layout import at_rest
from jounce.plant.run import on_breaks
from jounce.shaping import Limits, min_time_move

pytestmark = needs_compiler

DT = 1e-3
SAMPLES = 20_000


def sectioned():
    return [Notch(40.0, zero_damping=0.05, pole_damping=0.6), LeadLag(10.0, 60.0), LowPass(300.0)]


KINDS = {
    "PID": DigitalController(every_block.digital_pid()),
    "P-PI": every_block.digital_cascade(),
    "all of a PID": DigitalController(
        Controller(
            PID(900.0, -4000.0, 80.0, derivative_filter=2e-4),
            filters=sectioned(),
            sample_time=DT,
            anti_windup=BackCalculation(0.03),
        ),
        Feedforward({0: 0.1, 1: 0.5, 2: 2.0, 5: 1e-4}, position={1: 0.01, 3: 1e-3}, friction=0.4),
        torque_limit=40.0,
        encoder_step=1e-2,
    ),
    "conditional": DigitalController(
        Controller(PID(90.0, 400.0, 8.0), sample_time=DT, anti_windup="conditional"),
        torque_limit=4.0,
    ),
    "clamp": DigitalController(
        Controller(CascadedPI(3.0, 8.0, 0.2), sample_time=DT, anti_windup=Clamp(0.5)),
        Feedforward({1: 0.5}, lead=0.5 * DT, friction=0.2),
        torque_limit=4.0,
    ),
}


def read(step, position):
    return step * floor(position / step + 0.5) if step else position


def plain(digital, command, ahead, measured, motor):
    """Return e, w and u of samples in plain Python, in the order that the reference names."""
    c, f, law = digital.controller, digital.feedforward, digital.controller.law
    count = len(command)
    gains, position = f.torque_gains(count - 1), f.position_gains(count - 1)
    integral, past, rate = 0.0, None, 0.0
    memory = [[0.0, 0.0] for _ in c.sections]
    rows = []
    for r, r_ahead, y, y_motor in zip(command.T, ahead.T, measured, motor, strict=True):
        reference = sum((float(p * x) for p, x in zip(position, r, strict=True)), 0.0)
        y, y_motor = read(digital.encoder_step, y), read(digital.encoder_step, y_motor)
        e = reference - y
        signal = reference - y_motor if isinstance(law, PID) else y_motor
        past = signal if past is None else past
        rate = (c.rate_filter * rate + signal - past) / (c.rate_filter + c.sample_time)
        past = signal
        if isinstance(law, PID):
            inside, ki = e, law.ki
            integral += c.sample_time * inside
            w = law.kp * e + ki * integral + law.kr * rate
        else:
            inside = law.position_gain * e + law.velocity_feedforward * r[1] - rate
            ki = law.integral_gain
            integral += c.sample_time * inside
            w = law.velocity_gain * inside + ki * integral
        for (b0, b1, b2, a1, a2), kept in zip(c.sections, memory, strict=True):
            out = b0 * w + kept[0]
            kept[:] = b1 * w - a1 * out + kept[1], b2 * w - a2 * out
            w = out
        w += sum((float(g * x) for g, x in zip(gains, r_ahead, strict=True)), 0.0)
        w += f.friction * np.sign(r_ahead[1])
        u = min(max(w, -digital.torque_limit), digital.torque_limit)
        if c.anti_windup == "conditional" and u != w and w * inside > 0.0:
            integral -= c.sample_time * inside
        elif isinstance(c.anti_windup, BackCalculation):
            integral += c.sample_time / c.anti_windup.tracking_time * (u - w) / ki
        elif isinstance(c.anti_windup, Clamp):
            most = c.anti_windup.integral_limit / abs(ki)
            integral = min(max(integral, -most), most)
        rows.append((e, w, u))
    return np.array(rows).T


def names(digital):
    own = ["r", "r_rate", "r_acceleration", "r_jerk", "r_snap", "r_crackle"][: digital.order + 1]
    return own, [f"{name}_ahead" for name in own] if digital.feedforward.lead else own


@pytest.mark.parametrize("name", KINDS)
def test_the_firmware_is_plain_python_over_many_random_samples_to_the_last_bit(
    name, tmp_path, monkeypatch
):
    monkeypatch.setattr(writing, "measure", lambda *_: None)
    digital = replace(KINDS[name], holding=0.0)
    rng = np.random.default_rng(3)
    own, later = names(digital)
    scale = np.array([0.3, 1.0, 3.0, 20.0, 100.0, 500.0])[: digital.order + 1, None]
    size = np.repeat(10.0 ** rng.uniform(-7.0, 0.0, SAMPLES // 200), 200)
    command = size * scale * rng.normal(size=(digital.order + 1, SAMPLES))
    command[1, ::7] = 0.0  # friction is not fed to what stands still
    ahead = command if later is own else size * scale * rng.normal(size=command.shape)
    y = command[0] + 0.05 * size * rng.normal(size=SAMPLES)
    motor = y + 0.01 * size * rng.normal(size=SAMPLES) if digital.two_encoders else y
    inputs = dict(zip(own, command, strict=True)) | dict(zip(later, ahead, strict=True))
    inputs |= {"y": y} | ({"y_motor": motor} if digital.two_encoders else {})
    made = driven(digital, tmp_path / "c", inputs, ("e", "u_asked", "u"))
    expected = plain(digital, command, ahead, y.tolist(), motor.tolist())
    np.testing.assert_array_equal(made, expected)
    limited = np.abs(expected[2]) == digital.torque_limit
    assert digital.torque_limit == inf or 0.01 < limited.mean() < 0.99


def real_loop():
    """Return a loop that sticks, slides and saturates; its load carries the encoder."""
    axis = Axis(
        2.0,
        modes=[FlexibleMode(40.0, 0.01, load_fraction=0.3)],
        viscous=0.5,
        friction=Friction(0.6, 0.9),
        torque_limit=5.5,
        current_lag=2e-4,
        encoder_step=1e-5,
        constant_load=0.3,
    )
    running = Controller(
        PID(900.0, 4000.0, 80.0, derivative_filter=3e-4),
        filters=sectioned()[:1],
        sample_time=DT,
        delay=0.4e-3,
        anti_windup="conditional",
    )
    return ServoLoop(axis, running, Feedforward({1: 0.5, 2: 2.0}, friction=0.5))


def move():
    return min_time_move(2.0, Limits(velocity=0.5, acceleration=2.5, jerk=60.0)).shift(0.3)


def real_controller():
    return DigitalController.of(real_loop(), move())


@pytest.mark.parametrize("version", VERSIONS)
def test_the_fmu_is_the_simulation_over_many_samples_to_the_last_bit(version):
    rng = np.random.default_rng(5)
    loop, count = real_loop(), SAMPLES
    response = loop.respond(move(), DT, duration=count * DT, noise=2e-5 * rng.normal(size=count))
    run = response.run
    times = DT * np.arange(float(count))
    y = run.at(times)[1] @ run.seen_row + run.scene.noise
    assert np.count_nonzero(run.seen_row) == 1  # so that sums have no order
    rows = [move()(on_breaks(move(), times), k) for k in range(3)]
    host = Host(fmu_of(real_controller, version)).run()
    inputs = dict(zip(("r", "r_rate", "r_acceleration"), rows, strict=True)) | {"y": y}
    made = host.record(np.full(count, DT), "e", "u_asked", "u", **inputs)
    host.close()
    np.testing.assert_array_equal(made, run.samples.T)
    assert 10 < np.sum(np.abs(made[2]) == 5.5) < count // 2
    assert len(response.friction_events) > 2
    assert made[2, 0] > at_rest(loop.axis, 0.3)[1] - 0.5


def test_gains_may_be_tuned_while_it_runs():
    host = Host(fmu_of(every_block.digital_pid, "3.0")).run()
    host.set(r=1e-3)
    host.step(DT)
    [before] = host.get("u")
    host.set(kp=0.0, ki=0.0, kr=0.0)
    for _ in range(200):
        host.step(DT)
    assert before > 0.0
    assert abs(host.get("u")[0]) < 1e-6 * before
    message = host.refused(host.set, rate_filter=-1.0)
    assert "is below its minimum" in message
    host.close()


def test_what_is_continuous_or_out_of_range_is_refused():
    with pytest.raises(ValueError, match=r"a continuous controller cannot leave.*sample_time=1e-3"):
        DigitalController(Controller(PID(1.0, 1.0, 1.0)))
    with pytest.raises(ValueError, match=r"torque_limit = 0\.0: expected a positive torque"):
        replace(KINDS["PID"], torque_limit=0.0)
    with pytest.raises(ValueError, match=r"encoder_step = -1\.0: expected a number ≥ 0"):
        replace(KINDS["PID"], encoder_step=-1.0)
    with pytest.raises(TypeError, match=r"controller = PID.*expected a Controller"):
        DigitalController(PID(1.0, 1.0, 1.0))
