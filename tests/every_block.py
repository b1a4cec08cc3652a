"""One of every kind of block that leaves as an FMU."""

import control

from jounce.fmu import SampledController, SampledLoop
from jounce.plant import PID, FlexibleInertia, Inertia, InertiaFeedforward, ServoLoop
from jounce.shaping import CommandFollower, JerkFilter, Limits, min_time_move


def trajectory():
    return min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=10.0))


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
    )
}


def makers():
    """Return the functions that make them."""
    return list(BLOCKS.values())
