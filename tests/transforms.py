"""Laplace transforms of motions in many digits, and motions to take them of."""

import mpmath
import numpy as np

from jounce.shaping import Limits, min_time_move


def transform_in_digits(digits, motion, s, from_end=False):
    """Return V(s) of the doubles that a motion is made of, integrated by parts in each piece."""
    with mpmath.workdps(digits):
        s, total, time = mpmath.mpc(s), mpmath.mpc(0), mpmath.mpf(0)
        for state, duration in zip(motion.states.tolist(), motion.durations.tolist(), strict=True):
            row, tau = [mpmath.mpf(x) for x in state], mpmath.mpf(duration)
            turned = mpmath.exp(-s * tau)
            for k in range(1, len(row)):
                end = mpmath.fsum(
                    row[j] * tau ** (j - k) / mpmath.factorial(j - k) for j in range(k, len(row))
                )
                total += mpmath.exp(-s * time) * (row[k] - end * turned) / s**k
            time += tau
        return complex(total * (mpmath.exp(s * time) if from_end else 1))


def random_move(order, seed):
    rng = np.random.default_rng((order, seed))
    bounds = [10.0 ** rng.uniform(0.0, k) for k in range(1, order + 1)]
    return min_time_move(
        float(rng.choice([-1.7, 1.7])), Limits.from_bounds(bounds), start=0.3, method="closed-form"
    )
