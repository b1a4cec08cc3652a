"""Halves integrated in fractions, repaired ends simulated again, whole moves mirrored."""

from fractions import Fraction
from math import factorial, inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references import BOUND, CONTINUITY, joint_gaps
from strategies import MAGNITUDES, bound_lists

from jounce.shaping import Limits, min_time_move
from jounce.shaping.optimal.half_motion import Half, merged, whole_move

SEEDS = st.integers(0, 10**6)
FEW = settings(max_examples=max(10, settings.default.max_examples // 2))
FREE = np.full(12, np.nan)


def random_half(order: int, runs: int, seed: int) -> Half:
    rng = np.random.default_rng((order, runs, seed))
    durations = rng.dirichlet(np.ones(runs)).astype(np.longdouble)
    return Half(durations, rng.normal(size=runs), order)


def integrated(half: Half) -> list[list[Fraction]]:
    """Return the states at the start of each run and at the end, exactly."""
    n = half.order
    state, states = [Fraction(0)] * n, []
    for duration, u in zip(half.durations, half.inputs, strict=True):
        full = [*state, Fraction(float(u))]
        states.append(full)
        tau = Fraction(*duration.as_integer_ratio())
        state = [
            sum(full[j] * tau ** (j - k) / factorial(j - k) for j in range(k, n + 1))
            for k in range(n)
        ]
    states.append([*state, Fraction(float(half.inputs[-1]))])
    return states


def terms(half: Half, states, k: int) -> float:
    """Return the largest sum of what derivative k is added up from in a run: its rounding."""
    powers = range(half.order + 1 - k)
    return max(
        sum(abs(state[k + j]) * float(h) ** j / factorial(j) for j in powers)
        for h, state in zip(half.durations, states, strict=False)
    )


def half_of(move) -> Half:
    """Return the first half of a symmetric move, cut at its middle."""
    middle = 0.5 * move.duration
    begun = move.breaks[:-1] < middle * (1.0 - 1e-9)
    durations = move.durations[begun].astype(np.longdouble)
    durations[-1] = middle - durations[:-1].sum()
    return Half(durations, move.states[begun, -1].copy(), move.order)


def closed_form(bounds, distance: float = 1.0):
    return min_time_move(distance, Limits.from_bounds(bounds), method="closed-form")


def odd_ends(order: int):
    ends = np.full(order + 1, np.nan)
    ends[2:order:2] = 0.0
    return ends


# Simulation


@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize("seed", range(3))
def test_states_are_those_of_exact_arithmetic(order, seed):
    half = random_half(order, 6, seed)
    states, exact = half.states(), integrated(half)
    assert states.shape == (order + 1, 7)
    for k in range(order + 1):
        size = max(abs(float(state[k])) for state in exact)
        for found, state in zip(states[k], exact, strict=True):
            assert abs(float(found) - float(state[k])) <= 2e-15 * size, (k, float(state[k]))


@FEW
@given(bound_lists(4, 7))
def test_the_half_of_a_move_ends_half_way(bounds):
    move = closed_form(bounds)
    end = half_of(move).states()[:, -1]
    assert float(end[0]) == pytest.approx(0.5, rel=1e-9)
    for k in range(2, move.order, 2):
        assert abs(float(end[k])) <= 1e-8 * move.peak(k)


# Merging


@given(st.lists(st.sampled_from([-2.0, -1.0, 0.0, 1.0]), min_size=1, max_size=20), SEEDS)
def test_merging_equal_inputs_is_the_same_motion_in_fewest_runs(inputs, seed):
    lengths = np.random.default_rng(seed).uniform(0.1, 1.0, len(inputs))
    nodes = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    half = merged(nodes, np.array(inputs), 5, 0.0)
    changes = np.flatnonzero(np.diff(inputs)) + 1
    assert half.inputs.tolist() == [inputs[i] for i in [0, *changes]]
    assert float(half.durations.sum()) == pytest.approx(1.0, rel=1e-15)
    cells = Half(np.diff(nodes.astype(np.longdouble)), np.array(inputs), 5)
    np.testing.assert_allclose(
        np.asarray(half.states()[:5, -1], float),
        np.asarray(cells.states()[:5, -1], float),
        rtol=0,
        atol=1e-15,
    )


def test_a_tolerance_joins_what_differs_by_less():
    nodes = np.array([0.0, 0.2, 0.5, 1.0])
    inputs = np.array([1.0, 1.0 - 1e-9, -1.0])
    few, many = (merged(nodes, inputs, 4, tolerance) for tolerance in (1e-8, 1e-10))
    assert few.durations.astype(float).tolist() == [0.5, 0.5]
    assert few.inputs.tolist() == [1.0, -1.0]
    assert many.inputs.tolist() == inputs.tolist()


# Repair


@FEW
@given(bounds=bound_lists(4, 6), seed=SEEDS)
def test_a_disturbed_half_is_repaired_where_it_moves_few_switches(bounds, seed):
    """Ends are met by switches alone: the inputs and the time stay as they are."""
    move = closed_form(bounds)
    good = half_of(move)
    shift = np.random.default_rng(seed).uniform(-1.0, 1.0, len(good.durations) - 1)
    shift *= 1e-7 * float(good.durations.min())
    durations = good.durations.copy()
    durations[:-1] += shift
    durations[1:] -= shift
    ends = odd_ends(move.order)
    sizes = np.array([move.peak(k) for k in range(move.order + 1)])
    repaired = Half(durations, good.inputs, move.order).repaired(ends, sizes)
    assert repaired is not None
    np.testing.assert_array_equal(repaired.inputs, good.inputs)
    assert float(repaired.durations.sum()) == pytest.approx(float(durations.sum()), rel=1e-15)
    assert (repaired.durations > 0.0).all()
    states = integrated(repaired)
    for k in range(2, move.order, 2):
        assert abs(float(states[-1][k])) <= 1e-12 * terms(repaired, states, k), k


@given(st.integers(4, 7), SEEDS)
def test_any_end_near_by_is_reached(order, seed):
    rng = np.random.default_rng(seed)
    runs = 2 * order
    durations = rng.uniform(0.5, 1.0, runs).astype(np.longdouble) / runs
    half = Half(durations, (-1.0) ** np.arange(runs) * rng.uniform(0.5, 1.0, runs), order)
    states = np.asarray(half.states(), float)
    sizes = np.abs(states).max(axis=1)
    ends = states[:, -1] + 1e-9 * sizes * rng.uniform(-1.0, 1.0, order + 1)
    ends[rng.random(order + 1) < 0.5] = np.nan
    ends[order] = np.nan
    repaired = half.repaired(ends, sizes)
    assert repaired is not None
    last = integrated(repaired)[-1]
    for k in np.flatnonzero(np.isfinite(ends)):
        assert abs(float(last[k]) - ends[k]) <= 1e-14 * sizes[k], k


def test_free_ends_need_no_repair():
    half = random_half(5, 6, 1)
    repaired = half.repaired(FREE[:6], np.ones(6))
    assert repaired is not None
    np.testing.assert_array_equal(repaired.durations, half.durations)


def test_an_end_out_of_reach_is_none():
    half = random_half(4, 6, 1)
    ends = np.array([np.nan, np.nan, 1e3, np.nan, np.nan])
    assert half.repaired(ends, np.ones(5)) is None


# The whole move


def odd_half(order: int, seed: int) -> Half | None:
    """Return a random half whose even derivatives vanish at the end."""
    rng = np.random.default_rng((order, seed))
    durations = rng.dirichlet(np.full(2 * order, 5.0))
    inputs = rng.normal(size=2 * order)
    last = 1.0 - np.cumsum(durations)
    before = np.concatenate([[1.0], last[:-1]])
    even = range(2, order, 2)
    rows = [(before ** (order - k) - last ** (order - k)) / factorial(order - k) for k in even]
    inputs -= np.linalg.pinv(np.array(rows)) @ (np.array(rows) @ inputs)
    half = Half(durations.astype(np.longdouble), inputs, order)
    end = half.states()[0, -1]
    if end < 0.0:
        half = Half(half.durations, -inputs, order)
    return half.repaired(odd_ends(order), np.ones(order + 1)) if abs(end) > 1e-6 else None


HALVES = [
    pytest.param(half, id=f"order {order}, seed {seed}")
    for order in range(3, 9)
    for seed in range(3)
    if (half := odd_half(order, seed)) is not None
]


def assert_odd_about_its_middle(move):
    assert float(move(0.5 * move.duration)) == pytest.approx(
        0.5 * float(move.end_state[0]), rel=1e-12
    )
    mirrored = move.reverse().mirror().shift(float(move.end_state[0]))
    t = np.linspace(0.0, 1.0, 97) * move.duration
    for k in range(move.order):
        np.testing.assert_allclose(mirrored(t, k), move(t, k), rtol=0, atol=1e-11 * move.peak(k))


@pytest.mark.parametrize("half", HALVES)
@pytest.mark.parametrize("distance", [1.0, 3e-7])
def test_a_whole_move_is_odd_at_rest_and_at_a_bound(half, distance):
    n = half.order
    limits = Limits.from_bounds([distance * 10.0**k for k in range(n)])
    move = whole_move(half, distance, 1.0, limits)
    assert (move.start_time, move.order) == (0.0, n)
    np.testing.assert_array_equal(move.states[0, :n], 0.0)
    np.testing.assert_array_equal(move.end_state, [distance, *[0.0] * n])
    assert max(joint_gaps(move)) <= CONTINUITY
    assert_odd_about_its_middle(move)
    shares = [move.peak(k) / bound for k, bound in enumerate(limits.upper, start=1)]
    assert max(shares) == pytest.approx(1.0, rel=BOUND)
    # each run of the half is a piece of the move, but for the one through the middle of odd n
    pieces = 2 * len(half.inputs) - (1 if n % 2 else 0)
    assert len(move.states) == pieces


@pytest.mark.parametrize("half", HALVES)
def test_a_shape_has_one_duration_under_its_limits_in_any_unit(half):
    """The half's own time and distance units do not matter."""
    limits = Limits.from_bounds([10.0**k for k in range(half.order)])
    move = whole_move(half, 1.0, 1.0, limits)
    for time, size in ((1e3, 1.0), (1e-6, 1.0), (1.0, 1e6)):
        unit = Half(half.durations, half.inputs * size, half.order)
        other = whole_move(unit, 1.0, time, limits)
        assert other.duration == pytest.approx(move.duration, rel=1e-13)
        np.testing.assert_allclose(other.states, move.states, rtol=1e-12, atol=1e-14)


@FEW
@given(bounds=bound_lists(4, 7), distance=MAGNITUDES)
def test_the_half_of_a_closed_form_gives_it_back(bounds, distance):
    scaled = [b and b * distance for b in bounds]
    limits, move = Limits.from_bounds(scaled), closed_form(scaled, distance)
    ends, sizes = odd_ends(move.order), [move.peak(k) for k in range(move.order + 1)]
    half = half_of(move).repaired(ends, np.array(sizes))
    assert half is not None
    again = whole_move(half, distance, 1.0, limits)
    assert again.duration == pytest.approx(move.duration, rel=1e-9)
    assert again.violation(limits) <= 1e-10  # a cruise among the runs costs digits


@pytest.mark.parametrize("cruise", [1e-6, 0.3, 100.0])
@pytest.mark.parametrize("order", [4, 5, 6])
def test_a_cruise_goes_on_at_the_velocity_of_the_half(order, cruise):
    bounds = [0.2, *[10.0**k for k in range(1, order)]]
    limits = Limits.from_bounds(bounds)
    whole = closed_form(bounds, 100.0)
    ramp = half_of(whole)
    ramp = Half(ramp.durations[:-1], ramp.inputs[:-1], order)
    move = whole_move(ramp, 50.0, 1.0, limits, cruise)
    assert_odd_about_its_middle(move)
    assert max(joint_gaps(move)) <= CONTINUITY
    assert move.violation(limits) <= BOUND
    cruising = (move.states[:, 2:] == 0.0).all(axis=1) & (move.states[:, 1] > 0.0)
    np.testing.assert_allclose(move.states[cruising, 1], move.peak(1), rtol=1e-14)
    share = cruise / (cruise + float(ramp.durations.sum()))
    assert move.durations[cruising].sum() == pytest.approx(share * move.duration, rel=1e-12)


def test_each_side_of_a_bound_is_kept():
    half = HALVES[0].values[0]
    pairs = [(-1.0, 2.0), (-3.0, 40.0), (-inf, 50.0)]
    limits = Limits.from_bounds(pairs)
    move = whole_move(half, 1.0, 1.0, limits)
    assert move.violation(limits) <= BOUND
    shares = [
        side / bound
        for k in range(1, 4)
        for side, bound in zip(move.extremes(k), limits.bounds(k), strict=True)
    ]
    assert max(shares) == pytest.approx(1.0, rel=1e-9)
