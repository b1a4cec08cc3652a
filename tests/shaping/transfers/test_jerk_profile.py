"""One profile of bounded jerk: distance and pieces against integration in small steps."""

import numpy as np
import pytest

from jounce.shaping.transfers.jerk_profile import Profile, pieces, ramp, travelled
from jounce.shaping.transfers.task import Task, taylor

SEEDS = range(6)


def random_profile(seed, cruise=0.0):
    """Return a task and a profile that ends with some velocity, v_max where it cruises."""
    rng = np.random.default_rng(seed)
    rise, fall = rng.uniform(0.5, 3.0, 2)
    a0, p, q, a1 = -0.3, *rng.uniform(0.5, 2.0, 1), *rng.uniform(-2.0, -0.5, 1), 0.2
    hold, dwell = rng.uniform(0.1, 1.0, 2)
    v0 = rng.normal()
    top = v0 + (p * p - a0 * a0) / (2 * rise) + p * hold + p * p / (2 * fall)
    v1 = top - q * q / (2 * fall) + q * dwell + (a1 * a1 - q * q) / (2 * rise)
    task = Task(0.0, v0, a0, v1, a1, -np.inf, top, q, p, fall, rise)
    duration = (p - a0) / rise + hold + (p - q) / fall + cruise + dwell + (a1 - q) / rise
    return task, Profile(duration, p, hold, cruise, q, dwell)


def integrated(task, profile, steps=200_000):
    """Return distance and final velocity by the midpoint rule, jerk by jerk."""
    p, q, hold, cruise = profile.p, profile.q, profile.hold, profile.cruise
    spans = [
        ((p - task.a0) / task.rise, task.rise),
        (hold, 0.0),
        (p / task.fall, -task.fall),
        (cruise, 0.0),
        (-q / task.fall, -task.fall),
        (profile.dwell, 0.0),
        ((task.a1 - q) / task.rise, task.rise),
    ]
    edges = np.cumsum([0.0, *(time for time, _ in spans)])
    time = np.linspace(0.0, edges[-1], steps + 1)
    middle = 0.5 * (time[1:] + time[:-1])
    jerk = np.array([value for _, value in spans])[np.searchsorted(edges[1:-1], middle)]
    step = edges[-1] / steps
    a = task.a0 + np.concatenate([[0.0], np.cumsum(jerk * step)])
    v = task.v0 + np.concatenate([[0.0], np.cumsum(0.5 * (a[1:] + a[:-1]) * step)])
    return float((0.5 * (v[1:] + v[:-1]) * step).sum()), float(v[-1])


@pytest.mark.parametrize("seed", SEEDS)
def test_distance_and_final_velocity(seed):
    task, profile = random_profile(seed)
    distance, v1 = integrated(task, profile)
    assert travelled(task, profile)[0] == pytest.approx(distance, abs=1e-3)
    assert task.v1 == pytest.approx(v1, abs=1e-3)


@pytest.mark.parametrize("cruise", [0.0, 0.7])
@pytest.mark.parametrize("seed", SEEDS)
def test_pieces_join_from_start_to_end(seed, cruise):
    task, profile = random_profile(seed, cruise)
    distance = travelled(task, profile)[0] + task.v_max * cruise
    rows = pieces(task, profile, 2.0, 2.0 + distance)
    assert rows[0][1][:3] == (2.0, task.v0, task.a0)
    assert sum(time for time, _ in rows) == pytest.approx(profile.duration, rel=1e-13)
    following = [row for _, row in rows[1:]] + [(2.0 + distance, task.v1, task.a1)]
    for (time, row), after in zip(rows, following, strict=True):
        assert taylor(row, time)[:3] == pytest.approx(after[:3], abs=1e-12), (seed, cruise)


def test_a_ramp_of_acceleration():
    assert ramp(1.0, 0.0, 2.0, 1.0) == pytest.approx((2.0 + 8.0 / 6.0, 3.0))
    assert ramp(0.0, 1.0, 1.0, 5.0) == (0.0, 0.0)
