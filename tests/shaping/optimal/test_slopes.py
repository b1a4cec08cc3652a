"""What each side of each bound costs, by the certificate, against moves planned anew."""

from math import inf

import pytest

from jounce.shaping import Limits, certify, min_time_transfer

CASES = {
    "no turning back, a lift": (0.0, 60.0, [None, (0, 20), (-4, 1), 10], [(2, 1), (2, 0)]),
    "acceleration that only brakes": (
        (0.0, 1.0), (0.6, 0.4), [None, 2, (-3, 0), 20], [(2, 1), (3, 1)]),
    "a run-up to a wall": (
        (0.0, 0.0), (0.17, 0.9), [(-0.1, 1.05), 2, (-3, 2), 20], [(0, 0), (2, 1)]),
    "the same the other way": (
        (0.0, 0.0), (-0.17, -0.9), [(-1.05, 0.1), 2, (-2, 3), 20], [(0, 1), (2, 0)]),
    "at full velocity from start to end": ((0.0, 2.0), (3.0, 2.0), [None, (0, 2), 3, 20], [(1, 1)]),
}  # fmt: skip
STEP = 2e-3


def limits_of(pairs):
    position, *bounds = pairs
    return Limits.from_bounds(bounds, position=position)


@pytest.mark.parametrize("name", CASES)
def test_slopes_are_those_of_the_duration(name):
    start, end, bounds, sides = CASES[name]
    limits = limits_of(bounds)
    transfer = min_time_transfer(start, end, limits, rtol=1e-6)
    proof = certify(transfer, limits, rtol=1e-6)
    assert proof.check()
    for k, side in sides:
        wider = [list(limits.bounds(j)) for j in range(limits.order + 1)]
        step = (STEP if side else -STEP) * max(abs(wider[k][side]), 0.1)
        wider[k][side] += step
        changed = min_time_transfer(start, end, limits_of(wider), rtol=1e-6).duration
        slope = (changed - transfer.duration) / step
        assert proof.slopes[k][side] == pytest.approx(slope, rel=0.03), (k, side)


def test_sensitivities_are_the_sum_over_both_sides():
    limits = Limits(velocity=(0, 3), acceleration=(-4, 1), jerk=20, snap=300)
    proof = certify(min_time_transfer(0.0, 1.0, limits), limits)
    for k, share in enumerate(proof.sensitivities, start=1):
        pairs = zip(proof.slopes[k], limits.bounds(k), strict=True)
        assert share == pytest.approx(sum(s * b for s, b in pairs) / proof.lower_bound, abs=1e-12)


@pytest.mark.parametrize("distance", [1.0, -1.0])
@pytest.mark.parametrize("bounds", [[(-1, 1.5), 6, (-60, 40)], [(-9, 0.3), None, None, 384]])
def test_halves_and_the_whole_say_the_same(bounds, distance):
    """The half horizon's multipliers against those of the whole, for which a wall far away does."""
    limits = Limits.from_bounds(bounds)
    far = Limits.from_bounds(bounds, position=(-50.0, 50.0))
    move = min_time_transfer(0.0, distance, limits)
    half, whole = certify(move, limits), certify(move, far, rtol=1e-5)
    assert whole.gap < 1e-4
    for one, other in zip(half.slopes, whole.slopes, strict=True):
        assert one == pytest.approx(other, rel=0.02, abs=2e-3)


def test_nothing_proven_has_no_slopes():
    limits = Limits.from_bounds([None, None, None, None, (-inf, 5.0)])
    move = min_time_transfer(0.0, 1.0, Limits(crackle=5.0))
    assert certify(move, limits).slopes == ((0.0, 0.0),) * 6
