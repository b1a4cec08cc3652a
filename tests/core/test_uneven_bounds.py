"""Bounds that differ by many decades: pieces, run on in exact fractions, follow one another."""

from fractions import Fraction
from math import inf, sqrt

import numpy as np
import pytest
from tiers import some

from jounce.core import transfer


def piece_at(piece, t):
    """Return position, velocity and acceleration after a time under constant jerk."""
    x, v, a, j = piece
    return x + (v + (a / 2 + j * t / 6) * t) * t, v + (a + j * t / 2) * t, a + j * t


def turns_of(piece, duration):
    """Return the ends of a piece, and where its velocity is zero to 1e-9 in between."""
    _, v, a, j = map(float, piece)
    turns = [t.real for t in np.roots([j / 2, a, v]) if 0.0 < t.real < duration]
    return map(Fraction, [0.0, *turns, duration])


def largest_jump(motion):
    """Return the largest jump of the position as a part of its excursion."""
    _, states, durations, end = motion.arrays()
    pieces = [[*map(Fraction, row), *[Fraction(0)] * (4 - len(row))] for row in states.tolist()]
    way, jump = [Fraction(end[0])], Fraction(0)
    for i, (piece, duration) in enumerate(zip(pieces, durations.tolist(), strict=True)):
        following = pieces[i + 1][0] if i + 1 < len(pieces) else way[0]
        jump = max(jump, abs(piece_at(piece, Fraction(duration))[0] - following))
        way.extend(piece_at(piece, t)[0] for t in turns_of(piece, duration))
    excursion = max(way) - min(way)
    return float(jump / excursion) if excursion else 0.0


@pytest.mark.parametrize("weak", [1e-15, 1e-12, 1e-6])
@pytest.mark.parametrize("end", [0.0, -0.497, -0.4999])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_bound_that_takes_no_part_lends_no_room(weak, end, sign):
    """From velocity -1 to rest at `end`: up to w, where 1/2 + end = w²/2 (1 + 1/weak), and down."""
    bounds = (-inf, inf, -weak, 1.0) if sign > 0.0 else (-inf, inf, -1.0, weak)
    motion = transfer((0.0, -sign), (sign * end, 0.0), bounds)
    w = sqrt(2.0 * (0.5 + end) / (1.0 + 1.0 / weak))
    assert motion.duration == pytest.approx(1.0 + w + w / weak, rel=1e-13)
    assert largest_jump(motion) <= 1e-15


def uneven(rng, decades):
    """Return an order-2 problem: signs of all kinds, and bounds by up to so many decades apart."""
    start, end = rng.choice([-1.0, 0.0, 1.0], 2) * 10.0 ** rng.uniform(-3.0, 1.0, 2)
    distance = rng.choice([-1.0, 0.0, 1.0]) * 10.0 ** rng.uniform(-6.0, 6.0)
    low, ratio = 10.0 ** rng.uniform(-3.0, 3.0), 10.0 ** rng.uniform(-decades, decades)
    bounds = -inf, inf, -low, low * ratio
    return (0.0, float(start)), (float(distance), float(end)), tuple(map(float, bounds))


@pytest.mark.parametrize("decades", some([3.0, 12.0, 6.0], 2))
def test_random_uneven_accelerations(decades):
    rng = np.random.default_rng(int(decades))
    for _ in range(700):
        problem = uneven(rng, decades)
        assert largest_jump(transfer(*problem)) <= 1e-12, problem


@pytest.mark.parametrize("decades", [3.0, 6.0, 12.0])
def test_velocities_of_one_sign(decades):
    """Beside the least distance there is: passing it by takes the other bound, and its time."""
    rng = np.random.default_rng(100 + int(decades))
    for _ in range(300):
        (x, v0), (_, v1), bounds = uneven(rng, decades)
        v0, v1 = abs(v0) + 1e-3, abs(v1) + 2e-3
        least = (v1 - v0) * (v1 + v0) / 2.0 / bounds[3 if v1 > v0 else 2]
        distance = least * (1.0 - 10.0 ** rng.uniform(-9.0, -1.0))
        problem = (x, v0), (distance, v1), bounds
        assert largest_jump(transfer(*problem)) <= 1e-12, problem
