"""Whole digital loops as FMU, SSP and C: what leaves is what the simulation runs."""

from dataclasses import replace

import control
import every_block
import numpy as np
import pytest
from firmware import driven
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu import SampledLoop, export_ssp, load_ssp
from jounce.fmu.exporting import export_c as writing
from jounce.fmu.exporting.delayed_axis import delayed_axis_block
from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    Inertia,
    InertiaFeedforward,
    LowPass,
    Ramp,
    Ripple,
    ServoLoop,
    Sine,
    TorqueSteps,
    chain_axis,
    inverse_feedforward,
    system_axis,
)
from jounce.plant.layout import at_rest
from jounce.shaping import JerkFilter, Limits, min_time_move

pytestmark = needs_compiler

DT = 1e-3
SHOWN = ("r", "y", "y_load", "e")


def move():
    limits = Limits(velocity=0.4, acceleration=2.5, jerk=60.0, snap=4000.0)
    return min_time_move(0.2, limits).shift(2.0)


def loop_of(axis, law=None, feedforward=None, **more):
    law = PID(900.0, 4000.0, 80.0, derivative_filter=3e-4) if law is None else law
    running = Controller(law, **{"sample_time": DT} | more)
    return ServoLoop(axis, running, feedforward)


def drive():
    axis = Axis(2.0, viscous=1.0, friction=Friction(0.8), torque_limit=8.0, encoder_step=1e-6)
    law = CascadedPI(40.0, 80.0, 0.02, velocity_filter=2e-4)
    ahead = Feedforward({1: 1.0, 2: 2.0}, lead=1.5e-3)
    return SampledLoop(move(), loop_of(axis, law, ahead, anti_windup=Clamp(2.0), delay=DT))


def chain():
    axis = chain_axis(
        [1.0, 0.4, 0.6], [6e4, 5e4], [0.5, 0.5], friction=Friction(0.4), sensor="load"
    )
    law = PID(400.0, 1000.0, 40.0, derivative_filter=1e-3)
    return SampledLoop(move(), loop_of(axis, law, Feedforward({2: 2.0, 4: 1e-5})))


def any_system():
    axis = system_axis(control.tf([1.0], [2.0, 0.4, 3.0]), torque_limit=12.0, constant_load=0.2)
    more = {"filters": [LowPass(200.0)], "delay": 0.3e-3, "anti_windup": "conditional"}
    return SampledLoop(move(), loop_of(axis, feedforward=Feedforward({0: 3.0, 2: 2.0}), **more))


def sampled_inertia():
    return SampledLoop(move(), loop_of(Inertia(2.0), feedforward=InertiaFeedforward(1.8)))


def cogging():
    """Return a loop that goes forwards over periods of ripple, with friction."""
    return SampledLoop(move(), loop_of(every_block.rippling_axis()))


def cogging_back():
    """Return one without friction that goes backwards, from 8 lines before 0 on."""
    axis = Axis(2.0, ripple=Ripple.sine(0.4, 0.05, phase_deg=20.0, points=7))
    return SampledLoop(move().scale(-1.0), loop_of(axis, delay=0.4e-3))


def damped_inverse():
    """Return a loop whose feedforward remembers three numbers of the command, and looks ahead."""
    modes = [FlexibleMode(f, 0.02, load_fraction=x, held=True) for f, x in ((20.0, 0.4), (55, 0.1))]
    axis = Axis(2.0, viscous=1.0, modes=modes, friction=Friction(0.5), sensor="both")
    ahead = replace(inverse_feedforward(axis), lead=1.2e-3)
    return SampledLoop(move(), loop_of(axis, feedforward=ahead, delay=0.7e-3))


LOOPS = (
    every_block.digital_loop,
    drive,
    damped_inverse,
    chain,
    any_system,
    sampled_inertia,
    cogging,
    cogging_back,
)


def close(made, response, relative, part=slice(1, None)):
    """Compare rows of SHOWN with a part of a response, relative to the largest position."""
    load = response.load
    seen = load if response.scene.axis.sensor != "motor" else response.position
    scale = np.abs(load).max()
    for own, row, expected in zip(
        SHOWN, made, (response.command, seen, load, response.error), strict=True
    ):
        np.testing.assert_allclose(row, expected[part], atol=relative * scale, err_msg=own)


def torques(response, delay, count):
    """Return the torque that acts at the end of each sample, before the next one's."""
    last = np.ceil(np.arange(1.0, count + 1.0) - delay / DT - 1e-9).astype(int) - 1
    _, holding = at_rest(response.scene.axis, response.scene.start)
    return np.where(last < 0, holding, response.run.samples[last, 2])


@pytest.mark.parametrize("make", some(LOOPS, 4), ids=lambda make: make.__name__)
def test_firmware_that_steps_with_the_samples_is_the_simulation_to_the_last_bits(
    make, tmp_path, monkeypatch
):
    monkeypatch.setattr(writing, "measure", lambda *_: None)
    sampled, count = make(), 1000
    moved = np.zeros((2, count))
    moved[0, 300:] = 1.5
    moved[1, 600:] = -1.0
    made = driven(
        sampled, tmp_path / "c", dict(zip(("d", "d_load"), moved, strict=True)), (*SHOWN, "u")
    )
    pushes = [TorqueSteps([0.3], [1.5]), TorqueSteps([0.6], [-1.0], on="load")]
    response = sampled.loop.respond(sampled.trajectory, DT, duration=count * DT, disturbance=pushes)
    close(made[:-1], response, 3e-15)
    delay = sampled.loop.controller_noun.delay
    np.testing.assert_allclose(made[-1], torques(response, delay, count), rtol=0.0, atol=1e-11)


def late():
    """Return a loop whose motion begins later than the run."""
    sampled = drive()
    return SampledLoop(sampled.trajectory.delay(0.25), sampled.loop)


@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize(
    "make", [every_block.digital_loop, late, cogging], ids=["PID", "P-PI", "ripple"]
)
def test_the_fmu_is_the_simulation_whatever_the_steps(make, version):
    sampled = make()
    start, lasting = sampled.trajectory.start_time, 0.8
    host = Host(fmu_of(make, version), start=start).run()
    made = host.record(np.full(800, DT), *SHOWN)
    whole = sampled.loop.respond(sampled.trajectory, DT, duration=lasting)
    close(made, whole, 3e-15)
    host.close()
    rng = np.random.default_rng(2)
    ends = np.sort(np.append(rng.uniform(0.0, lasting, 700), lasting))
    host = Host(fmu_of(make, version), start=start).run()
    made = host.record(np.diff(np.append(0.0, ends)), *SHOWN)
    host.close()
    close(made, sampled.loop.respond(sampled.trajectory, times=start + ends), 1e-12, slice(None))
    assert len(whole.friction_events) > 0


def test_gains_limit_and_start_may_be_changed():
    host = Host(fmu_of(drive, "3.0"))
    host.set(torque_limit=2.0, kp=60.0, **{"state.y": 2.001})
    host.run()
    made = host.record(np.full(400, DT), "u")
    assert np.abs(made).max() == 2.0
    host.close()


def ahead():
    """Return the loop of two encoders whose feedforward looks ahead, without delay."""
    sampled = every_block.digital_loop()
    running = replace(sampled.loop.controller, delay=0.0)
    return SampledLoop(sampled.trajectory, replace(sampled.loop, controller=running))


@pytest.mark.parametrize("make", [every_block.digital_loop, every_block.sticking_axis])
@pytest.mark.parametrize("version", VERSIONS)
def test_it_goes_on_from_a_snapshot_to_the_last_bit(make, version):
    host = Host(fmu_of(make, version)).run()
    loose = {"d": 1.5} if make is every_block.digital_loop else {"u": 3.0}
    host.set(**loose)
    fmu, old = host.fmu, version == "2.0"
    lengths = np.random.default_rng(4).uniform(1e-4, 3e-3, 400)
    host.record(lengths[:200], "y")
    kept, time = (fmu.getFMUstate if old else fmu.getFMUState)(), host.time
    first = host.record(lengths[200:], "y", "y_load")
    (fmu.setFMUstate if old else fmu.setFMUState)(kept)
    host.time = time
    np.testing.assert_array_equal(host.record(lengths[200:], "y", "y_load"), first)
    assert np.ptp(first[0]) > 0.0
    (fmu.freeFMUstate if old else fmu.freeFMUState)(kept)
    host.close()


def slow_computer():
    """Return a loop on friction whose torques act three samples and a fraction later."""
    running = loop_of(Axis(2.0, friction=Friction(0.8), torque_limit=8.0), delay=3.3 * DT)
    return SampledLoop(move(), running)


SSPS = (
    damped_inverse,
    any_system,
    chain,
    ahead,
    sampled_inertia,
    drive,
    every_block.digital_loop,
    slow_computer,
)


@pytest.mark.parametrize("make", some(SSPS, 2), ids=lambda make: make.__name__)
def test_the_ssp_is_the_simulation_in_its_own_order(make, tmp_path):
    sampled = make()
    made = export_ssp(tmp_path / "loop.ssp", sampled.trajectory, sampled.loop, platforms=["host"])
    assert set(made.components) - {"ahead"} == {"controller", "plant", "shaper"}
    assert ("ahead" in made.components) == (sampled.loop.feedforward_noun.lead > 0.0)
    response = sampled.loop.respond(sampled.trajectory, DT, duration=0.8)
    with load_ssp(made.path) as system:
        y = system.run(0.8)["plant.y"]
    expected = seen(sampled, response)
    np.testing.assert_allclose(y, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def seen(sampled, response):
    return response.position if sampled.loop.axis.sensor == "motor" else response.load


REFUSED = {
    "a ramp": (lambda: SampledLoop(Ramp(1.0), loop_of(Axis(2.0))), "Ramp: a command without end"),
    "a sine": (lambda: SampledLoop(Sine(1.0, 2.0), loop_of(Axis(2.0))), "give a planned motion"),
    "another dt": (
        lambda: SampledLoop(move(), loop_of(Axis(2.0)), 2e-3),
        r"dt = 0\.002 for a controller with sample_time = 0\.001: leave dt out",
    ),
    "a jerk filter": (
        lambda: SampledLoop(move(), loop_of(Axis(2.0)), None, JerkFilter(20.0, 4)),
        "a jerk filter in front of a digital loop: shape the command by limits instead",
    ),
    "too low an order": (
        lambda: SampledLoop(move(), loop_of(Axis(2.0), feedforward=Feedforward({5: 1.0}))),
        "of order 4 is a train of impulses: use limits up to crackle at least",
    ),
    "no dt": (
        lambda: SampledLoop(move(), ServoLoop(Axis(2.0), PID(1.0, 1.0, 1.0))),
        "dt is missing: give the sample time",
    ),
    "a continuous limit": (
        lambda: SampledLoop(move(), ServoLoop(Axis(2.0, torque_limit=1.0), PID(1.0, 1.0, 1.0)), DT),
        r"a continuous controller with a torque limit cannot leave.*sample_time=1e-3",
    ),
    "continuous friction": (
        lambda: SampledLoop(
            move(), ServoLoop(Axis(2.0, friction=Friction(1.0)), PID(1.0, 1.0, 1.0)), DT
        ),
        r"a continuous controller with friction cannot leave",
    ),
    "continuous ripple": (
        lambda: SampledLoop(
            move(),
            ServoLoop(Axis(2.0, ripple=Ripple.sine(0.1, 1.0)), PID(1.0, 1.0, 1.0)),
            DT,
        ),
        r"a continuous controller with ripple cannot leave",
    ),
    "a continuous cascade": (
        lambda: SampledLoop(move(), ServoLoop(Inertia(2.0), CascadedPI(1.0, 1.0)), DT),
        r"a continuous controller with a cascade cannot leave",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_leave_is_named_with_a_remedy(name):
    make, message = REFUSED[name]
    with pytest.raises((ValueError, TypeError), match=message) as refused:
        make()
    assert "\n" not in str(refused.value)


def delayed_mass():
    running = Controller(PID(1.0, 1.0, 1.0), sample_time=0.1, delay=0.22)
    return delayed_axis_block(Axis(2.0, torque_limit=4.0), running, "plant", "rad", position=1.0)


def test_a_torque_acts_later_by_the_delay_whatever_the_steps():
    """On a free mass, pushed 2.2 samples later by torques of 5, 3 and 0, held in between."""
    host = Host(fmu_of(delayed_mass, "3.0")).run(u=5.0)
    shown = host.record([0.1], "u_acting", "y")
    for push, steps in ((3.0, [0.04, 0.06]), (0.0, [0.05, 0.02, 0.03, 0.3])):
        host.set(u=push)
        shown = np.append(shown, host.record(steps, "u_acting", "y"), axis=1)
    ends = np.cumsum([0.1, 0.04, 0.06, 0.05, 0.02, 0.03, 0.3])
    on = np.clip(ends[:, None] - [0.22, 0.32], 0.0, 0.1)  # 4 (limited), then 3, each for a sample
    far = np.maximum(ends[:, None] - [0.32, 0.42], 0.0)
    moved = np.array([2.0, 1.5]) * (0.5 * on**2 + on * far)
    np.testing.assert_allclose(shown[1], 1.0 + moved.sum(axis=1), rtol=1e-14)
    np.testing.assert_array_equal(shown[0], [0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 0.0])
    host.close()
