"""Thompson's longer moves on arrays: each is the scalar plan or, like it, none."""

from math import inf

import numpy as np
import pytest

from jounce.shaping.batches.swings import swings
from jounce.shaping.closed_form import swing_form


@pytest.mark.parametrize("order", range(3, 9))
@pytest.mark.parametrize("decades", [2.0, 8.0])
def test_every_one_is_the_scalar_plan(order, decades):
    rng = np.random.default_rng(order)
    bounds = 30.0 ** np.arange(order)[:, None] * 10.0 ** rng.uniform(
        -0.5 * decades, 0.5 * decades, (order, 150)
    )
    bounds[:-1][rng.random((order - 1, 150)) < 0.2] = inf
    bounds[0, :50] = inf
    distances = 10.0 ** rng.uniform(-3.0, 3.0, 150)
    with np.errstate(all="ignore"):
        found = swings(distances, list(bounds))
    nothing = 0
    for i, (distance, column) in enumerate(zip(distances.tolist(), bounds.T.tolist(), strict=True)):
        plan, text = swing_form(distance, column), f"swing_form({distance!r}, {column!r})"
        if plan is None:
            assert found.duration[i] == inf, text
            nothing += 1
            continue
        assert found.duration[i] == pytest.approx(plan.duration, rel=1e-14), text
        assert found.acceleration[i] == pytest.approx(plan.acceleration, rel=1e-14), text
        assert abs(found.hold[i] - plan.hold) <= 1e-14 * plan.duration, text
        for name in ("up", "across"):
            pair = [values[i] for values in getattr(found, name)]
            assert pair == pytest.approx(getattr(plan, name), rel=2e-14), text
    assert 10 < nothing < 140


def test_bounds_may_be_numbers():
    bounds = [2.0, 3.0, 40.0, 500.0]
    with np.errstate(all="ignore"):
        found = swings(np.array([0.1, 1.0]), [np.array(bound) for bound in bounds])
    expected = [swing_form(distance, bounds).duration for distance in (0.1, 1.0)]
    np.testing.assert_allclose(found.duration, expected, rtol=1e-14)
