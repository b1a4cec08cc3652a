"""What a closed form loses at most, told without a program; and certificates in words."""

import math

import pytest

from jounce.shaping import Limits, certify, min_time_move, min_time_transfer, proven_excess

BOUNDS = {
    "order 2": [2.0, 9.0],
    "order 3, uneven": [(-1.0, 3.0), (-4.0, 8.0), (-90.0, 60.0)],
    "order 4": [1.5, 6.0, 60.0, 900.0],
    "order 4, uneven": [2.0, (-4.0, 8.0), 60.0, (-900.0, 2000.0)],
    "no turning back": [(0.0, 2.0), 6.0, 60.0, 900.0],
    "snap and crackle alone": [None, None, None, 500.0, 9000.0],
    "order 11": [*[None] * 8, 4.0**8 * math.factorial(8), None, 4.0**12 * math.factorial(10)],
}


@pytest.mark.parametrize("name", BOUNDS)
@pytest.mark.parametrize("distance", [1.0, -1.0])
def test_it_is_more_than_what_is_proven_to_be_lost(name, distance):
    limits = Limits.from_bounds(BOUNDS[name])
    if distance < 0.0 and 0.0 in limits.lower:
        limits = limits.mirror()
    move = min_time_move(distance, limits, method="closed-form")
    most, proof = proven_excess(move, limits), certify(move, limits)
    lost = move.duration / proof.lower_bound - 1.0
    assert most < 0.6
    assert lost <= most + proof.rtol
    if limits.order <= 3:
        assert most <= 1e-12


@pytest.mark.parametrize("order", [4, 5, 6, 9])
def test_a_perfect_spline_loses_nothing(order):
    limits = Limits.from_bounds([*[None] * (order - 1), 3.0])
    assert proven_excess(min_time_move(2.0, limits), limits) <= 1e-12
    uneven = Limits.from_bounds([*[None] * (order - 1), (-4.0, 2.0)])
    least = min_time_move(2.0, uneven, rtol=1e-6).duration
    most = proven_excess(min_time_move(2.0, uneven, method="closed-form"), uneven)
    closed = min_time_move(2.0, uneven, method="closed-form").duration
    assert closed / least - 1.0 <= most + 1e-6


def test_what_is_refused():
    limits = Limits(velocity=2.0, acceleration=9.0, jerk=60.0)
    with pytest.raises(ValueError, match="proven_excess takes moves from rest to rest; certify"):
        proven_excess(min_time_transfer((0.0, 0.5), 1.0, limits), limits)
    with pytest.raises(ValueError, match="exceeds a limit by 100 %"):
        proven_excess(min_time_move(1.0, limits), Limits(velocity=1.0, acceleration=9.0, jerk=60.0))
    assert proven_excess(min_time_move(0.0, limits), limits) == 0.0


def test_a_certificate_says_in_words_what_it_proves():
    limits = Limits(velocity=1.5, acceleration=6.0, jerk=60.0, snap=900.0)
    slow = min_time_move(1.0, limits, method="closed-form").stretch(1.25)
    told = str(certify(slow, limits))
    assert "% more than the minimum time, which is proven to be at least 1.0" in told
    assert told.startswith(f"{slow.duration:.10g}: at most 2")
    upward = Limits.from_bounds([None, None, None, None, (-math.inf, 5.0)])
    nothing = certify(min_time_move(1.0, Limits(crackle=5.0)), upward)
    assert str(nothing).endswith("nothing is proven of the minimum time")
