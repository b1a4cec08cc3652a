"""A slow jerk beside a fast one: nothing jumps, and no other way is faster, in exact fractions."""

from fractions import Fraction
from math import inf

import mpmath
import numpy as np
import pytest
from tiers import some

from jounce.core import transfer, velocity_transfer


def after(state, t):
    """Return position, velocity and acceleration after a time, exactly."""
    x, v, a, j = map(Fraction, state)
    t = Fraction(t)
    return x + (v + (a / 2 + j * t / 6) * t) * t, v + (a + j * t / 2) * t, a + j * t


def turns(state, duration):
    """Return the times in a piece at which velocity or acceleration are zero, to rounding."""
    _, v, a, j = map(float, state)
    roots = [*np.roots([j / 2, a, v]), *np.roots([j, a])]
    return [t.real for t in roots if 0.0 < t.real < duration]


def jumps(motion):
    """Return the largest jumps of position, velocity and acceleration, each of its own scale."""
    _, states, durations, end = motion.arrays()
    states, durations = states.tolist(), durations.tolist()
    seen, gaps = [list(map(Fraction, end[:3].tolist()))], [[Fraction(0)] * 3]
    for i, (state, duration) in enumerate(zip(states, durations, strict=True)):
        following = states[i + 1] if i + 1 < len(states) else end.tolist()
        seen += [after(state, t) for t in [0.0, *turns(state, duration), duration]]
        gaps.append([abs(x - Fraction(y)) for x, y in zip(seen[-1], following[:3], strict=True)])
    x, v, a = zip(*seen, strict=True)
    scales = max(x) - min(x), max(map(abs, v)), max(map(abs, a))
    return [float(max(gap) / scale) if scale else float(max(gap))
            for gap, scale in zip(zip(*gaps, strict=True), scales, strict=True)]  # fmt: skip


def uneven(rng, decades):
    """Return a problem with bounds by up to so many decades apart, some of them absent."""
    bounds = [(-x, y) for x, y in 10.0 ** (decades * rng.uniform(-0.5, 0.5, (3, 2)))]
    for k in range(2):
        if rng.uniform() < 0.3:
            bounds[k] = (-inf, inf)
    (low, high), (brake, power), _ = bounds
    values = rng.choice([-1.0, 0.0, 1.0], 5) * 10.0 ** rng.uniform(-4.0, 1.0, 5)
    v0, v1 = np.clip(values[:2], low, high).tolist()
    a0, a1 = np.clip(values[2:4], brake, power).tolist()
    distance = float(values[4] * 10.0 ** rng.uniform(-4.0, 5.0))
    bounds = tuple(float(x) for pair in bounds for x in pair)
    return (0.0, v0, a0), (distance, v1, a1 * float(rng.integers(2))), bounds


def test_hold_fall_and_creep_by_three_equations():
    """At 1 for t, down by -2e4 for u, up by 5e-4 for w: at rest after 1e-4, to 40 digits."""
    motion = transfer((0.0, 0.0, 1.0), (1e-4, 0.0, 0.0), (-1.0, 1.0, -1.0, 1.0, -2e4, 5e-4))
    with mpmath.workdps(40):
        fall, rise = mpmath.mpf(-2e4), mpmath.mpf(5e-4)

        def missing(t, u, w):
            v, x, a = t + u + fall * u**2 / 2, t**2 / 2, 1 + fall * u
            x += t * u + u**2 / 2 + fall * u**3 / 6
            return (a + rise * w, v + a * w + rise * w**2 / 2,
                    x + v * w + a * w**2 / 2 + rise * w**3 / 6 - mpmath.mpf(1e-4))  # fmt: skip

        times = mpmath.findroot(missing, (2.57e-4, 5.0e-5, 1.0625), tol=1e-60)
    assert motion.duration == pytest.approx(float(sum(times)), rel=1e-14)
    assert max(jumps(motion)) <= 1e-14


@pytest.mark.parametrize("decades", some([3.0, 8.0, 12.0, 16.0], 2))
def test_nothing_jumps(decades):
    rng = np.random.default_rng(int(decades))
    planned = 0
    for _ in range(300):
        problem = uneven(rng, decades)
        for plan in (transfer, velocity_transfer):
            motion = plan(*problem)
            if not isinstance(motion, int):  # an end that leads out of its bounds has none
                planned += 1
                assert max(jumps(motion)) <= 1e-11, (plan, problem)
    assert planned > 400


def leads_out(v, a, bounds):
    """Tell whether a state passes a bound of the velocity whatever follows."""
    low, high, _, _, fall, rise = bounds
    return not low <= v + a * abs(a) / 2.0 / (rise if a < 0.0 else -fall) <= high


@pytest.mark.parametrize("decades", [3.0, 8.0, 12.0, 16.0])
def test_backwards_in_time_it_takes_as_long(decades):
    """y(t) = x(0) - x(-t) has the same velocities and jerks, and the opposite accelerations."""
    rng = np.random.default_rng(50 + int(decades))
    tried = 0
    for _ in range(300):
        start, (x, v, a), bounds = uneven(rng, decades)
        low, high, brake, power, fall, rise = bounds
        motion = transfer(start, (x, v, a), bounds)
        if isinstance(motion, int) or leads_out(*start[1:], bounds):
            continue
        mirrored = (low, high, -power, -brake, fall, rise)
        back = transfer((0.0, v, -a), (x, start[1], -start[2]), mirrored)
        assert back.duration == pytest.approx(motion.duration, rel=1e-10), (start, x, v, a, bounds)
        tried += 1
    assert tried > 200


@pytest.mark.parametrize("decades", [3.0, 8.0, 12.0, 16.0])
def test_a_wider_bound_never_takes_longer(decades):
    rng = np.random.default_rng(100 + int(decades))
    for _ in range(200):
        start, end, bounds = uneven(rng, decades)
        motion = transfer(start, end, bounds)
        if isinstance(motion, int) or leads_out(*start[1:], bounds):
            continue
        for k in range(6):
            wider = tuple(b * (1.7 if i == k else 1.0) for i, b in enumerate(bounds))
            assert transfer(start, end, wider).duration <= motion.duration * (1.0 + 1e-10), (
                start, end, bounds, k)  # fmt: skip


def test_full_deceleration_that_takes_ages_to_get_rid_of_is_not_used():
    """Too near a target, from just above a lowered bound, with a slow way back from braking."""
    bounds = (-1799.0, 4.858856576365824e-4, -inf, inf, -5e8, 1.2e-11)
    start = (0.0, bounds[1] * (1.0 + 1e-6), 0.0)
    motion = transfer(start, (0.15, 0.0, 0.0), bounds)
    inside = transfer((0.0, bounds[1], 0.0), (0.15, 0.0, 0.0), bounds)
    assert motion.duration == pytest.approx(inside.duration, rel=1e-3)
