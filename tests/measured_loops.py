"""Random sampled loops with light modes, and what measuring them would give."""

from dataclasses import replace

import control
import numpy as np

from jounce.plant import PID, Axis, Controller, FlexibleMode, LowPass, Notch, zero_order_hold


def random_loop(rng):
    """Return a sampled plant, its digital controller and the controller's crossover in Hz."""
    rate = float(rng.choice([1000, 2000, 4000, 8000]))
    crossover = rate / rng.uniform(60.0, 300.0)
    modes = [
        FlexibleMode(
            crossover * rng.uniform(1.5, 12.0),
            10 ** rng.uniform(-2.5, -1.5),
            motor_shape=1.0,
            load_shape=1.0,
        )
        for _ in range(rng.integers(0, 4))
    ]
    modes = [
        replace(mode, motor_shape=10 ** rng.uniform(-0.65, 0.0) * rng.choice([-1, 1]))
        for mode in modes
        if mode.frequency_hz < 0.35 * rate
    ]
    viscous = 0.5 * crossover * rng.choice([0.0, 1.0])
    axis = Axis(1.0, viscous=viscous, modes=modes, sensor="load")
    plant = zero_order_hold(axis.transfer(), 1.0 / rate, delay=rng.uniform(0.2, 1.5) / rate)
    notches = [
        Notch(mode.frequency_hz * rng.uniform(0.98, 1.02), zero_damping=0.05, pole_damping=0.5)
        for mode in modes
        if rng.random() < 0.7
    ]
    omega = 2 * np.pi * crossover
    law = PID(omega / 3, omega**2 / 24, 1.0, derivative_filter=1 / (12 * omega))
    controller = Controller(law, filters=[LowPass(6 * crossover), *notches], sample_time=1.0 / rate)
    place = np.exp(2j * np.pi * crossover / rate)
    size = 1.0 / abs(plant(place) * of_one_error(controller)(place))
    law = replace(law, kp=law.kp * size, ki=law.ki * size, kr=law.kr * size)
    return plant, replace(controller, law=law), crossover


def of_one_error(controller):
    """Return a digital controller from one error, k(z)."""
    both = controller.sampled()
    b, d = (np.sum(part, axis=1, keepdims=True) for part in (both.B, both.D))
    return control.ss(both.A, b, both.C, d, both.dt)


def complex_noise(rng, count):
    """Return complex normal numbers of variance 1."""
    return (rng.normal(size=count) + 1j * rng.normal(size=count)) / np.sqrt(2)
