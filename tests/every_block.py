"""One of every kind of block that leaves as an FMU."""

import control

from jounce.fmu import DigitalController, SampledController, SampledLoop, SampledShaper
from jounce.fmu.exporting.delayed_axis import delayed_axis_block
from jounce.fmu.exporting.inverse_block import inverse_trajectory_block
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
    LowPass,
    Notch,
    Ripple,
    ServoLoop,
    inverse_feedforward,
)
from jounce.shaping import CommandFollower, JerkFilter, Limits, input_shaper, min_time_move


def trajectory():
    return min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=10.0))


def shaped_trajectory():
    return input_shaper("ZVD", 3.0, 0.05).shape(trajectory())


def sampled_shaper():
    return SampledShaper(input_shaper("EI", [3.0, 7.0], 0.05), 0.004)


def follower():
    return CommandFollower(Limits(velocity=1.0, acceleration=(-2.0, 1.0)), dt=0.01)


def filtered_follower():
    limits = Limits(acceleration=2.0)
    return CommandFollower(limits, dt=0.01, period=360.0, jerk_filter=JerkFilter(4.0, 3))


def jerk_filter():
    return JerkFilter(2.0, 4)


def inertia():
    return Inertia(2.0)


def flexible_inertia():
    return FlexibleInertia(2.0, frequency_hz=10.0, damping=0.01, load_fraction=0.3)


def controller():
    return SampledController(PID(1.0, 2.0, 3.0), 1e-3, InertiaFeedforward(2.0))


def differencing_controller():
    return SampledController(PID(1.0, 2.0, 3.0), 1e-3, rate="differenced")


def transfer_function():
    return control.tf([1.0, 2.0], [1.0, 3.0, 5.0, 0.0], inputs=["u"], outputs=["y"])


def gain():
    names = {"inputs": ["a <b>", 'c"&%#??/'], "outputs": ["sum", "ü"]}
    return control.ss([], [], [], [[2.0, 0.0], [0.0, 3.0]], **names)


def discrete_system():
    return control.ss([[0.5, 1.0], [0.0, 0.2]], [[0.0], [1.0]], [[1.0, 0.0]], [[2.0]], 0.1)


def servo_loop():
    loop = ServoLoop(flexible_inertia(), PID(90.0, 60.0, 20.0), InertiaFeedforward(2.0))
    return SampledLoop(trajectory(), loop, 1e-3, jerk_filter())


def linear_axis():
    mode = FlexibleMode(40.0, 0.01, load_fraction=0.3)
    return Axis(2.0, modes=[mode], viscous=0.5, current_lag=2e-4)


def sticking_axis():
    mode = FlexibleMode(40.0, 0.01, load_fraction=0.3)
    more = {"torque_limit": 6.0, "current_lag": 2e-4, "constant_load": 0.3}
    return Axis(2.0, modes=[mode], viscous=0.5, friction=Friction(0.6, 0.9), **more)


def rippling_axis():
    """Return one whose ripple has lines of different lengths."""
    mode = FlexibleMode(40.0, 0.01, load_fraction=0.3)
    ripple = Ripple([0.003, 0.008, 0.011, 0.017], [0.3, -0.5, 0.4, 0.1], period=0.02)
    more = {"torque_limit": 6.0, "current_lag": 2e-4, "friction": Friction(0.6, 0.9)}
    return Axis(2.0, modes=[mode], viscous=0.5, ripple=ripple, **more)


def limited_axis():
    return Axis(2.0, spring=1.0, torque_limit=6.0, sensor="load")


def delayed_axis():
    """Return an axis as it stands in an SSP, behind a delay of more than a sample."""
    running = Controller(PID(1.0, 1.0, 1.0), sample_time=1e-3, delay=1.4e-3)
    return delayed_axis_block(limited_axis(), running, "delayed_axis", "1", position=0.0)


def inverse_trajectory():
    """Return a motion with what the inverse of a damped axis remembers of it, as in an SSP."""
    dynamics = inverse_feedforward(flexible_inertia()).dynamics
    return inverse_trajectory_block(trajectory(), dynamics, "inverse_trajectory", "1")


def digital_pid():
    """Return a PID with filters, as it is given alone."""
    law = PID(900.0, 4000.0, 80.0, derivative_filter=3e-4)
    filters = [Notch(40.0, zero_damping=0.05, pole_damping=0.6), LowPass(300.0)]
    return Controller(law, filters=filters, sample_time=1e-3, anti_windup="conditional")


def digital_cascade():
    law = CascadedPI(30.0, 80.0, 0.02, velocity_filter=3e-4)
    running = Controller(law, sample_time=1e-3, anti_windup=Clamp(2.0), delay=1e-3)
    ahead = Feedforward({1: 0.5, 4: 1e-5}, position={2: 1e-5}, lead=1.5e-3)
    more = {"torque_limit": 5.0, "encoder_step": 1e-5, "two_encoders": True, "holding": 0.3}
    return DigitalController(running, ahead, **more)


def digital_loop():
    """Return a loop that sticks, saturates and computes for longer than a sample."""
    axis = Axis(
        2.0,
        modes=[FlexibleMode(40.0, 0.01, load_fraction=0.3)],
        friction=Friction(0.6, 0.9),
        torque_limit=5.5,
        encoder_step=1e-5,
        constant_load=0.3,
        sensor="both",
    )
    filters = [Notch(40.0, zero_damping=0.05, pole_damping=0.6)]
    running = Controller(
        PID(900.0, 4000.0, 80.0, derivative_filter=3e-4),
        filters=filters,
        sample_time=1e-3,
        delay=1.4e-3,
        anti_windup=BackCalculation(0.05),
    )
    ahead = Feedforward({2: 2.0, 3: 1e-3}, friction=0.5, lead=1.9e-3)
    return SampledLoop(trajectory().shift(0.25), ServoLoop(axis, running, ahead))


def axis_servo():
    """Return a PID that is run once a sample on an axis."""
    loop = ServoLoop(linear_axis(), PID(900.0, 600.0, 80.0), InertiaFeedforward(2.0))
    return SampledLoop(trajectory(), loop, 1e-3)


BLOCKS = {
    make.__name__: make
    for make in (
        trajectory,
        follower,
        filtered_follower,
        jerk_filter,
        inertia,
        flexible_inertia,
        controller,
        differencing_controller,
        transfer_function,
        gain,
        discrete_system,
        servo_loop,
        shaped_trajectory,
        sampled_shaper,
        linear_axis,
        sticking_axis,
        rippling_axis,
        limited_axis,
        delayed_axis,
        inverse_trajectory,
        digital_pid,
        digital_cascade,
        digital_loop,
        axis_servo,
    )
}


def makers():
    """Return the functions that make them."""
    return list(BLOCKS.values())
