"""What is proven of a move is the same in any unit of length and time."""

from functools import cache
from math import ldexp

import pytest
from tiers import some

from jounce.shaping import Limits, binding_limits, certify, min_time_move

BOUNDS = (2.0, 10.0, 100.0, 2000.0)
POWERS = [(0, 300), (333, -133), (-333, 133), (-666, 0)]


@cache
def planned(order, length, time, even=1.0):
    """Return a move over 1 in units of 2^length and 2^time, and its limits."""
    bounds = [ldexp(b, length - k * time) for k, b in enumerate(BOUNDS[:order], start=1)]
    limits = Limits.from_bounds((-b * (even if k % 2 else 1.0), b) for k, b in enumerate(bounds))
    return min_time_move(ldexp(1.0, length), limits), limits


@cache
def proof(order, length, time, even):
    """Return the certificate of such a move."""
    return certify(*planned(order, length, time, even))


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize(("length", "time"), some(POWERS, 2))
@pytest.mark.parametrize("even", [1.0, 1.5])
def test_a_certificate_is_the_same_in_any_units(order, length, time, even):
    if order == 4 and (abs(time) > 200 or even != 1.0):
        length, time, even = length // 2, time // 3, 1.0  # snap would leave the range
    move, limits = planned(order, length, time, even)
    here, there = (proof(order, *units, even) for units in ((0, 0), (length, time)))
    assert there.lower_bound == pytest.approx(ldexp(here.lower_bound, time), rel=1e-9)
    assert there.sensitivities == pytest.approx(here.sensitivities, abs=1e-6)
    assert there.duration == move.duration
    assert binding_limits(move, limits) == binding_limits(*planned(order, 0, 0, even))


@pytest.mark.parametrize("size", [1e-300, 1e-100, 1e100, 1e300])
def test_a_move_of_three_equal_parts_is_bound_by_jerk_alone_at_any_scale(size):
    """Without other bounds the jerk is at its bound all along, and T³ = 32·R/J."""
    limits = Limits(jerk=size)
    move = min_time_move(size, limits)
    assert certify(move, limits).lower_bound == pytest.approx(32.0 ** (1.0 / 3.0), rel=1e-6)
    assert set(binding_limits(move, limits)) == {(3,)}
