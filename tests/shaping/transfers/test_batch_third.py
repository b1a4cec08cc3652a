"""Order 3 on arrays: Thompson's cases, the scalar families, and identities."""

import numpy as np
import pytest
from batches import edge_transfers, stacked, unstacked
from references import assert_sound_transfer, least_duration, thompson_order_3
from strategies import TransferProblem, random_transfer

from jounce.shaping.transfers.batch_tasks import take
from jounce.shaping.transfers.batch_third import fastest, pieces
from jounce.shaping.transfers.planner import families

LIMITS = ((-1.0, 1.0), (-2.0, 2.0), (-2.0, 2.0))


@pytest.fixture(autouse=True)
def _as_in_a_batch():
    """Let what is not chosen divide by zero."""
    with np.errstate(all="ignore"):
        yield


def inside(seed, count=400):
    """Return problems that begin and end where their bounds can be kept."""
    rng = np.random.default_rng((40, seed))
    problems = [random_transfer(rng) for _ in range(count)]
    for problem in edge_transfers((41, seed), 3, count):
        states = (problem.start, problem.end)
        if all(low <= x <= high for state in states
               for x, (low, high) in zip(state[1:], problem.bounds, strict=False)):  # fmt: skip
            problems.append(problem.keeping())
    return problems


def of(problems):
    return stacked([problem.task for problem in problems])


def trajectory(problem, plan, i):
    """Return plan i of arrays as a trajectory."""
    (ahead, profiles, falls), (durations, states) = plan, pieces(*plan[:2])
    assert len(ahead.v0) == len(profiles.duration)
    sign = -1.0 if falls[i] else 1.0
    rows = sign * states[:, :, i] + [problem.start[0], 0.0, 0.0, 0.0]
    return problem.trajectory(list(zip(durations[:, i].tolist(), rows.tolist(), strict=True)))


# Against others


@pytest.mark.parametrize("seed", range(3))
def test_the_shortest_profile_is_the_shortest_of_both_families(seed):
    problems = inside(seed)
    _, profiles, _ = fastest(of(problems))
    for problem, found in zip(problems, profiles.duration.tolist(), strict=True):
        solutions = [p.duration for family in families(problem.task) for p in family.solutions()]
        assert found == pytest.approx(min(solutions), rel=1e-12, abs=1e-15), problem


def test_from_rest_to_rest_they_are_thompsons():
    rng = np.random.default_rng(42)
    numbers = (
        10.0 ** rng.uniform([-2.0, -1.0, -1.0, -1.0], [2.0, 1.0, 1.0, 1.0], (1000, 4))
    ).tolist()
    signs = rng.choice([-1.0, 1.0], 1000).tolist()
    problems = [
        TransferProblem((0.0,) * 3, (sign * x, 0.0, 0.0), tuple((-b, b) for b in bounds))
        for sign, (x, *bounds) in zip(signs, numbers, strict=True)
    ]
    _, profiles, falls = fastest(of(problems))
    cases = [thompson_order_3(*given) for given in numbers]
    assert {case.case for case in cases} == {"1", "2", "3", "4"}
    np.testing.assert_allclose(profiles.duration, [c.duration for c in cases], rtol=1e-12)
    np.testing.assert_allclose(profiles.p, [c.peaks[1] for c in cases], rtol=1e-9)
    np.testing.assert_allclose(profiles.q, [-c.peaks[1] for c in cases], rtol=1e-9)
    cruises = [case.case in "34" for case in cases]
    np.testing.assert_array_equal(profiles.cruise > 0.0, cruises)
    np.testing.assert_array_equal(falls, np.array(signs) < 0.0)


def test_no_motion_that_a_linear_program_finds_is_faster():
    """Between nodes it may exceed the velocity bounds by a little; long motions need more nodes."""
    problems = [random_transfer(np.random.default_rng((43, seed))) for seed in range(60)]
    _, profiles, _ = fastest(of(problems))
    [short] = np.nonzero(profiles.duration < 5.0)
    assert len(short) >= 2
    for i in short[:2]:
        found = float(profiles.duration[i])
        least = least_duration(problems[i], 1.2 * found, cells=40)
        assert 0.96 * least <= found <= 1.002 * least, problems[i]


# Identities


def test_all_structures_occur():
    """Else the random problems of this file prove little."""
    _, profiles, falls = fastest(of(inside(0)))
    holds, dwells, cruises = (getattr(profiles, name) > 0.0 for name in ("hold", "dwell", "cruise"))
    for some in (
        ~holds & ~dwells & ~cruises & (profiles.p > -profiles.q),
        ~holds & ~dwells & ~cruises & (profiles.p < -profiles.q),
        holds & ~dwells & ~cruises,
        dwells & ~holds & ~cruises,
        holds & dwells & ~cruises,
        cruises & ~holds & ~dwells,
        cruises & holds & dwells,
        falls,
    ):
        assert np.count_nonzero(some) > 5
    assert len({(p, q) for p, q in zip(np.sign(profiles.p), np.sign(profiles.q), strict=True)}) >= 3


@pytest.mark.parametrize("seed", range(2))
def test_the_pieces_are_sound(seed):
    problems = inside(seed)
    plan = fastest(of(problems))
    durations, _ = pieces(*plan[:2])
    assert (durations >= 0.0).all()
    total = plan[1].duration
    np.testing.assert_allclose(durations.sum(axis=0), total, rtol=1e-11, atol=1e-14)
    for i in range(0, len(problems), 2):
        if total[i] > 1e-6:
            assert_sound_transfer(problems[i], trajectory(problems[i], plan, i))


@pytest.mark.parametrize("seed", range(2))
def test_the_opposite_takes_as_long(seed):
    problems = inside(seed)
    _, profiles, _ = fastest(of(problems))
    _, other, _ = fastest(of([problem.mirrored() for problem in problems]))
    np.testing.assert_array_equal(other.duration, profiles.duration)


@pytest.mark.parametrize("seed", range(2))
def test_backwards_in_time_it_takes_as_long(seed):
    problems = inside(seed)
    _, profiles, _ = fastest(of(problems))
    _, back, _ = fastest(of([problem.backwards() for problem in problems]))
    for problem, one, other in zip(problems, profiles.duration, back.duration, strict=True):
        assert other == pytest.approx(one, rel=1e-9, abs=1e-12), problem


def test_neighbours_do_not_matter():
    tasks = of(inside(5, 60))
    together = fastest(tasks)[1]
    for i in range(len(tasks.v0)):
        alone = fastest(take(tasks, slice(i, i + 1)))[1]
        assert [field[0] for field in alone] == [field[i] for field in together], unstacked(tasks)[
            i
        ]


# By hand


def test_by_hand():
    """Within 1, 2 and 2, from (0, 0): published forms; from v = −1 to 1 the ramp of 2 s."""
    cases = {
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)): 0.0,
        ((0.0, 0.0, 0.0), (0.0625, 0.0, 0.0)): 1.0,  # (32·x/jerk)^(1/3)
        ((0.0, -1.0, 0.0), (0.0, 1.0, 0.0)): 2.0,
        ((0.0, -0.5, 0.0), (0.0, 0.5, 0.0)): 2.0 * 0.5**0.5,
        ((0.0, 1.0, 0.0), (3.0, 1.0, 0.0)): 3.0,
        ((0.0, -1.0, 0.0), (-3.0, -1.0, 0.0)): 3.0,
        ((0.0, 0.0, 1.0), (1.0 / 24.0 + 1.0 / 8.0, 0.5 + 0.25, 2.0)): 0.5,  # nothing but jerk
    }
    problems = [TransferProblem(start, end, LIMITS) for start, end in cases]
    _, profiles, _ = fastest(of(problems))
    assert profiles.duration == pytest.approx(list(cases.values()), rel=1e-12, abs=1e-15)


def test_an_end_that_cannot_be_reached_takes_for_ever():
    """Up to −0.9 the acceleration can be built up to √0.4 from −1; at 0.9 it can be kept."""
    ends = [(2.0, -0.9, a) for a in (0.4**0.5 * 0.999999, 0.4**0.5 * 1.000001, 2.0)]
    problems = [TransferProblem((0.0, 0.0, 0.0), end, LIMITS) for end in ends]
    _, profiles, _ = fastest(of(problems))
    assert np.isinf(profiles.duration).tolist() == [False, True, True]


def test_no_tasks():
    tasks, profiles, falls = fastest(take(of(inside(0, 2)), slice(0, 0)))
    assert (unstacked(tasks), len(profiles.duration), len(falls)) == ([], 0, 0)
