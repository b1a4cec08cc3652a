"""The edge grid: nothing crashes, no promise is broken, nothing is refused without reason."""

import os

import pytest
from edge_grid import LIMITS, OUTCOMES, count, problems, problems_of

from jounce.shaping import InfeasibleError, min_time_transfer, min_time_transfers

SLOW = os.environ.get("JOUNCE_TIER") == "slow"
EVERY = 1 if SLOW else 14


@pytest.mark.slow
def test_the_edge_grid():
    found, wrong = count(problems(EVERY))
    print(dict(found))
    assert not wrong, "\n".join(wrong)
    assert sum(found.values()) >= 60_000 / EVERY
    assert all(found[name] > 0 for name in OUTCOMES[:3])


@pytest.mark.slow
@pytest.mark.skipif(not SLOW, reason="half a million problems; JOUNCE_TIER=slow")
@pytest.mark.parametrize("limits", LIMITS, ids=str)
def test_the_fine_edge_grid(limits):
    found, wrong = count(problems_of(limits, fine=True))
    assert not wrong, "\n".join(wrong[:20])
    assert sum(found.values()) >= 9 ** (2 * limits.order - 1)


@pytest.mark.slow
def test_the_batch_comes_to_the_same():
    for start, end, limits in problems(10 * EVERY):
        duration = min_time_transfers(start, end, limits).duration[0]
        try:
            expected = min_time_transfer(start, end, limits).duration
        except InfeasibleError:
            assert duration != duration, (start, end, limits)
        else:
            assert duration == pytest.approx(expected, rel=1e-11), (start, end, limits)
