"""What is swept: bounds in units of the sine, whole periods, and what is refused."""

import numpy as np
import pytest

from jounce.analysis.frequency_view.describing_functions import describing_function
from jounce.analysis.frequency_view.sine_sweep import SAMPLES_PER_PERIOD, checked_sweep
from jounce.shaping import CommandFollower, JerkFilter, Limits, min_time_move

LIMITER, LIMITS = Limits(velocity=1.0), Limits(1.0, 2.0)
FOLLOWER = CommandFollower(LIMITS, dt=0.01)


def test_bounds_in_units_of_the_sine():
    sweep = checked_sweep(Limits(6.0, 12.0, jerk=24.0), [1.0, 3.0], 2.0)
    np.testing.assert_allclose(sweep.bounds, [[3.0, 1.0], [3.0, 1.0], [3.0, 1.0]])
    assert sweep.counts.tolist() == [SAMPLES_PER_PERIOD, SAMPLES_PER_PERIOD]
    assert checked_sweep(LIMITER, 1.0, 1.0).counts is None
    free = checked_sweep(Limits(acceleration=2.0), 1.0, 1.0).bounds
    assert free.tolist() == [1e100, 2.0]


def test_what_is_given_is_copied():
    sizes = np.array([1.0, 2.0])
    sweep = checked_sweep(LIMITER, sizes, [1.0, 1.0])
    sizes[:] = 9.0
    assert sweep.amplitude.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("shaper", "sizes", "omega", "told"),
    [
        (LIMITER, 0.0, 1.0, "amplitude = 0.0: expected positive"),
        (LIMITER, [1.0, -2.0], 1.0, "amplitude = -2.0: expected positive"),
        (LIMITER, np.nan, 1.0, "amplitude must be finite"),
        (LIMITER, 1.0, [1.0, np.inf], r"omega\[1\] = inf"),
        (LIMITER, 1.0, 0.0, "omega = 0.0: expected positive"),
        (LIMITER, [1.0, 2.0], [1.0, 2.0, 3.0], r"give amplitude\[:, None\] and omega"),
        (LIMITER, 1e200, 1.0, "more than 1e.100 times apart"),
        (Limits(velocity=(-1.0, 2.0)), 1.0, 1.0, "the same bounds in both directions"),
        (Limits(snap=1.0), 1.0, 1.0, "limits of order 4"),
        (FOLLOWER, 1.0, [1.0, 500.0], "omega = 500: a period is 1.25664 samples of dt = 0.01"),
        (FOLLOWER, 1.0, 1e-6, "expected 8 to 20000"),
        (CommandFollower(LIMITS, dt=0.01, period=9.0), 1.0, 1.0, "leave its period out"),
    ],
    ids=lambda value: str(value) if isinstance(value, str) else "",
)
def test_what_is_refused(shaper, sizes, omega, told):
    with pytest.raises(ValueError, match=told):
        describing_function(shaper, sizes, omega)


@pytest.mark.parametrize("shaper", [JerkFilter(1.0, 2), min_time_move(1.0, LIMITS), 3.0], ids=repr)
def test_other_shapers_are_refused(shaper):
    with pytest.raises(TypeError, match="expected Limits or a CommandFollower"):
        describing_function(shaper, 1.0, 1.0)


@pytest.mark.parametrize("samples", [6, 9, 20_002, 1.5])
def test_samples_that_are_refused(samples):
    with pytest.raises(ValueError, match=f"samples_per_period = {samples}: expected"):
        describing_function(LIMITS, 1.0, 1.0, samples_per_period=samples)


def test_a_follower_has_its_own_samples():
    with pytest.raises(ValueError, match="the follower has its own dt"):
        describing_function(FOLLOWER, 1.0, 1.0, samples_per_period=64)
