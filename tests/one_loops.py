"""Loops whose margins are known."""

import functools
import math

import control
import numpy as np

from jounce.analysis.margins import loop_margins

S = control.tf("s")


def exact_pid(inertia=1.0):
    """Return kr, kp, ki for 1 Hz, 45° and 12 dB exactly."""
    crossover, angle, factor = 2 * np.pi, np.pi / 4, 10 ** (12 / 20)
    kp = inertia * crossover**2 * math.cos(angle)
    kr = inertia * crossover * math.sin(angle) / (1 - math.cos(angle) / factor)
    return kr, kp, kr * kp / (inertia * factor)


def pid_loop(kr, kp, ki, inertia=1.0):
    return control.tf([kr, kp, ki], [inertia, 0, 0, 0])


def delayed_pid(delay=0.01, order=4):
    return pid_loop(*exact_pid()) * control.tf(*control.pade(delay, order))


def evaluate(loop, omega):
    """L(jω) by the coefficients, without the factors the margins are computed from."""
    s = 1j * np.asarray(omega)
    return np.polyval(loop.num_array[0, 0], s) / np.polyval(loop.den_array[0, 0], s)


def closed_loop_poles(loop, factor=1.0):
    return np.roots(np.polyadd(loop.den_array[0, 0], factor * loop.num_array[0, 0]))


def flexible_loop():
    """PID on five modes of damping ratio 0.001, with a roll-off: order 14 in modal form."""
    blocks = [(np.zeros((2, 2)) + np.diag([1.0], 1), 1.0)]
    for omega in (9.0, 21.0, 34.0, 55.0, 80.0):
        blocks.append((np.array([[0, 1], [-(omega**2), -2e-3 * omega]]), 0.2))
    plant = sum(control.ss(a, [[0], [gain]], [[1, 0]], 0) for a, gain in blocks)
    kr, kp, ki = exact_pid()
    return plant * control.ss((kr * S**2 + kp * S + ki) / (S * (S / 400 + 1)))


def random_loop(rng):
    """Return a random transfer function of order 1 to 8, over three decades."""
    order = rng.integers(1, 9)
    poles, zeros = random_roots(rng, order), random_roots(rng, rng.integers(0, order))
    den = np.real(np.poly(np.concatenate([poles, np.zeros(rng.integers(0, 2))])))
    num = np.atleast_1d(np.real(np.poly(zeros)))
    level = abs(np.prod(poles)) / abs(np.prod(zeros))
    return control.tf(num * level * 10 ** rng.uniform(-2, 1.5), den)


def random_roots(rng, count):
    roots = []
    while len(roots) < count:
        size = 10 ** rng.uniform(-1.5, 1.5)
        if count - len(roots) > 1 and rng.random() < 0.6:
            zeta = 10 ** rng.uniform(-2.5, 0)
            pole = size * complex(-zeta, math.sqrt(1 - zeta**2))
            roots += [pole, pole.conjugate()]
        else:
            roots.append(-size)
    return np.array(roots)


STABLE_RANDOM = [
    loop
    for loop in (random_loop(np.random.default_rng(seed)) for seed in range(150))
    if np.all(closed_loop_poles(loop).real < -1e-6)
]


@functools.cache
def stable_random_margins():
    return [(loop, loop_margins(loop)) for loop in STABLE_RANDOM]
