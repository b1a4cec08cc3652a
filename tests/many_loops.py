"""Loops by the hundred, and their margins compared."""

import dataclasses
import math

import numpy as np

from jounce.analysis.margins.many_margins import ManyMargins, many_loop_margins
from jounce.plant import design_pid

NAMES = [field.name for field in dataclasses.fields(ManyMargins)][1:]
GAINS = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)


def random_roots(rng, count, *, right=0.0, lightest=-2.5, decades=1.5):
    roots = []
    while len(roots) < count:
        size = 10 ** rng.uniform(-decades, decades)
        side = 1 if rng.random() < right else -1
        if count - len(roots) > 1 and rng.random() < 0.6:
            zeta = 10 ** rng.uniform(lightest, 0)
            root = size * complex(side * zeta, math.sqrt(1 - zeta**2))
            roots += [root, root.conjugate()]
        else:
            roots.append(side * size)
    return np.array(roots)


def random_loop(seed, **kinds):
    """Return numerator and denominator of order 1 to 8.

    Some have roots in the right half plane, resonances of damping ratio 1e-5, up to three
    integrators, as many zeros as poles, or gain of the other sign.
    """
    rng = np.random.default_rng(seed)
    order, kind = rng.integers(1, 9), rng.integers(0, 6)
    lightest = -5 if kind == 2 else -2.5
    poles = random_roots(rng, order, right=0.2 * (kind == 1), lightest=lightest, **kinds)
    most = order + (kind != 3)
    right = 0.3 * (kind == 4)
    zeros = random_roots(rng, rng.integers(0, most), right=right, lightest=lightest, **kinds)
    integrators = np.zeros(rng.integers(0, 4 if kind == 5 else 2))
    den = np.real(np.poly(np.concatenate([poles, integrators])))
    num = np.atleast_1d(np.real(np.poly(zeros)))
    level = abs(np.prod(poles)) / abs(np.prod(zeros)) * 10 ** rng.uniform(-2, 2.5)
    return num * level * (1 if rng.random() < 0.9 else -1), den


def random_delayed_loop(seed):
    """Return numerator and denominator, |L| < 1 as ω → ∞, and a delay."""
    num, den = random_loop(seed)
    if num.size == den.size:
        num = num * min(1.0, 0.5 * abs(den[0] / num[0]))
    return num, den, 10 ** np.random.default_rng(seed).uniform(-4, 1)


def stacked(rows):
    """Return polynomials of different degree as one array, with zeros in front."""
    width = max(row.size for row in rows)
    return np.array([np.concatenate([np.zeros(width - row.size), row]) for row in rows])


def together(loops):
    nums, dens, *delays = zip(*loops, strict=True)
    return many_loop_margins(stacked(nums), stacked(dens), delay=delays[0] if delays else 0.0)


def assert_same(actual, expected, names=NAMES, rtol=1e-9, message=""):
    for name in names:
        values = [float(getattr(result, name)) for result in (actual, expected)]
        np.testing.assert_allclose(*values, rtol=rtol, err_msg=f"{name} {message}")


def evaluate(loop, omega):
    num, den, delay = loop
    s = 1j * np.asarray(omega)
    return np.polyval(num, s) / np.polyval(den, s) * np.exp(-s * delay)
