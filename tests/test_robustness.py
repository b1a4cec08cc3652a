"""The edge grid: nothing crashes, no promise is broken, nothing is refused without reason."""

import os

import pytest
from edge_grid import OUTCOMES, count, problems

from jounce.shaping import InfeasibleError, min_time_transfer, min_time_transfers

EVERY = 1 if os.environ.get("JOUNCE_TIER") == "slow" else 37


@pytest.mark.slow
def test_the_edge_grid():
    found, wrong = count(EVERY)
    print(dict(found))
    assert not wrong, "\n".join(wrong)
    assert sum(found.values()) >= 60_000 / EVERY
    assert all(found[name] > 0 for name in OUTCOMES[:3])


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
