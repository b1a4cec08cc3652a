"""Order 2 on arrays: Thompson's cases, the scalar families, and identities."""

import numpy as np
import pytest
from batches import edge_transfers, stacked, unstacked
from references import thompson_order_2
from strategies import TransferProblem, random_transfer

from jounce.shaping.transfers.batch_second import fastest, pieces
from jounce.shaping.transfers.batch_tasks import take
from jounce.shaping.transfers.planner import families
from jounce.shaping.transfers.task import taylor


@pytest.fixture(autouse=True)
def _as_in_a_batch():
    """Let what is not chosen divide by zero."""
    with np.errstate(all="ignore"):
        yield


def inside(seed, count=500):
    """Return problems whose starts and ends are within their bounds."""
    rng = np.random.default_rng((30, seed))
    problems = edge_transfers((31, seed), 2, count)
    problems += [random_transfer(rng, 2) for _ in range(count)]
    return [p for p in problems if all(low <= state[1] <= high for state in (p.start, p.end)
                                       for low, high in p.bounds[:1])]  # fmt: skip


def of(problems):
    return stacked([problem.task for problem in problems])


@pytest.mark.parametrize("seed", range(3))
def test_the_shortest_profile_is_the_shortest_of_both_families(seed):
    problems = inside(seed)
    _, profiles, _ = fastest(of(problems))
    for problem, found in zip(problems, profiles.duration.tolist(), strict=True):
        solutions = [p.duration for family in families(problem.task) for p in family.solutions()]
        assert found == pytest.approx(min(solutions), rel=1e-12, abs=1e-15), problem


def test_from_rest_to_rest_they_are_thompsons():
    rng = np.random.default_rng(32)
    distances, velocities, powers = 10.0 ** rng.uniform(-2.0, 2.0, (3, 1000))
    signs = rng.choice([-1.0, 1.0], 1000)
    problems = [
        TransferProblem((0.0, 0.0), (x, 0.0), ((-v, v), (-a, a)))
        for x, v, a in zip((signs * distances).tolist(), velocities, powers, strict=True)
    ]
    _, profiles, falls = fastest(of(problems))
    numbers = np.array([distances, velocities, powers]).T.tolist()
    cases = [thompson_order_2(*given) for given in numbers]
    np.testing.assert_allclose(profiles.duration, [c.duration for c in cases], rtol=1e-13)
    np.testing.assert_allclose(profiles.peak, [c.peaks[0] for c in cases], rtol=1e-13)
    np.testing.assert_array_equal(profiles.cruise > 0.0, [c.case == "cruise" for c in cases])
    np.testing.assert_array_equal(falls, signs < 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_the_pieces_lead_to_the_end_within_the_bounds(seed):
    problems = inside(seed)
    ahead, profiles, falls = fastest(of(problems))
    durations, states = pieces(ahead, profiles)
    assert (durations >= 0.0).all()
    np.testing.assert_allclose(durations.sum(axis=0), profiles.duration, rtol=1e-13, atol=1e-15)
    for i, problem in enumerate(problems):
        sign = -1.0 if falls[i] else 1.0
        rows = [(float(time), tuple(float(sign * x) for x in row))
                for time, row in zip(durations[:, i], states[:, :, i], strict=True)]  # fmt: skip
        if profiles.duration[i] > 0.0:
            assert_leads(problem, rows)


def assert_leads(problem, rows):
    """Assert that pieces lead from start to end, continuously and within the bounds."""
    task = problem.task
    speed = max(abs(row[1]) for _, row in rows)
    scale = abs(task.distance) + speed * sum(time for time, _ in rows) + 1e-300
    ends = [taylor(row, time) for time, row in rows]
    following = [row for _, row in rows[1:]] + [(task.distance, task.v1)]
    assert rows[0][1][:2] == (0.0, task.v0), problem
    for end, begin in zip(ends, following, strict=True):
        assert end[0] == pytest.approx(begin[0], abs=1e-12 * scale), problem
        assert end[1] == pytest.approx(begin[1], abs=1e-12 * max(speed, abs(task.v1))), problem
    for time, (_, v, a) in rows:
        if time > 0.0:
            assert task.a_min <= a <= task.a_max, problem
            assert task.v_min * (1.0 + 1e-12) <= v <= task.v_max * (1.0 + 1e-12), problem


def test_by_hand():
    """From 1 to 1 over x: peak √(1 + x), or −√(1 − x) the other way round."""
    distances = [0.75, 3.0, 0.0, -1.0, -3.0]
    problems = [TransferProblem((0.0, 1.0), (x, 1.0), ((-3.0, 3.0), (-1.0, 1.0)))
                for x in distances]  # fmt: skip
    ahead, profiles, falls = fastest(of(problems))
    expected = [2.0 * (1.75**0.5 - 1.0), 2.0, 0.0, 2.0 * (2.0**0.5 + 1.0), 6.0]
    assert profiles.duration == pytest.approx(expected, rel=1e-14)
    assert profiles.peak == pytest.approx([1.75**0.5, 2.0, 1.0, 2.0**0.5, 2.0], rel=1e-14)
    assert falls.tolist() == [False, False, False, True, True]
    assert ahead.v0.tolist() == [1.0, 1.0, 1.0, -1.0, -1.0]


@pytest.mark.parametrize("seed", range(2))
def test_mirrored_and_backwards(seed):
    problems = inside(seed)
    _, profiles, _ = fastest(of(problems))
    _, mirrored, _ = fastest(of([p.mirrored() for p in problems]))
    np.testing.assert_array_equal(mirrored.duration, profiles.duration)
    _, back, _ = fastest(of([p.backwards() for p in problems]))
    np.testing.assert_allclose(back.duration, profiles.duration, rtol=1e-9, atol=1e-12)


def test_already_there():
    tasks = of([TransferProblem((2.0, v), (2.0, v), ((-1.0, 1.0), (-1.0, 2.0)))
                for v in (0.0, 1.0, -1.0, 0.3)])  # fmt: skip
    _, profiles, _ = fastest(tasks)
    assert profiles.duration.tolist() == [0.0] * 4
    assert not pieces(tasks, profiles)[0].any()


def test_no_tasks():
    tasks, profiles, falls = fastest(take(of(inside(0)), slice(0, 0)))
    assert (unstacked(tasks), len(profiles.duration), len(falls)) == ([], 0, 0)
