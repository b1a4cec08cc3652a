"""Evaluation in the core against exact fractions, on every way through."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from tiers import some

from jounce.core import Pieces

ORDERS = [1, 2, 3, 4, 5, 6, 7, 12, 40]


def arrays(order, pieces=5, seed=7):
    rng = np.random.default_rng(seed + order)
    durations = rng.uniform(0.1, 2.0, pieces)
    breaks = np.concatenate([[-2.0], -2.0 + np.cumsum(durations)])
    return breaks, rng.normal(size=(pieces, order + 1)), durations, rng.normal(size=order + 1)


def exact(motion, coasting, t, k):
    """Return derivative k at t and the sum of the magnitudes of its terms, in fractions."""
    breaks, states, durations, end = motion
    piece = int(np.count_nonzero(breaks <= t))
    origin = Fraction(breaks[max(piece - 1, 0)])
    tau = Fraction(t) - origin
    if 1 <= piece <= len(states):
        state, tau = states[piece - 1], min(tau, Fraction(durations[piece - 1]))
    else:
        state = (states[0] if piece == 0 and len(states) else end).copy()
        state[coasting + 1 :] = 0.0
    terms = [Fraction(x) * tau**j / factorial(j) for j, x in enumerate(state[k:])]
    return sum(terms), sum(map(abs, terms))


@pytest.mark.parametrize("order", some(ORDERS, 5))
def test_every_derivative_is_exact_to_rounding(order):
    motion, coasting = arrays(order), min(1, order - 1)
    times = np.random.default_rng(order).uniform(-3.0, motion[0][-1] + 1.0, 30)
    values = Pieces(*motion, coasting).up_to(times, order, None)
    for i, t in enumerate(times):
        for k in range(order + 1):
            value, size = exact(motion, coasting, t, k)
            assert abs(Fraction(values[k, i]) - value) <= Fraction(2 * order + 3, 2**53) * size


@pytest.mark.parametrize("order", ORDERS)
def test_few_many_sorted_and_unsorted_times_get_the_same_bits(order):
    piecewise = Pieces(*arrays(order), 0)
    rng = np.random.default_rng(8)
    times = np.sort(rng.uniform(-4.0, 8.0, 5_000))
    shuffled = rng.permutation(times.size)
    whole = piecewise.up_to(times, order, None)
    for k in range(order + 1):
        one_by_one = [piecewise.at(float(t), k) for t in times]
        np.testing.assert_array_equal(whole[k], one_by_one)
        np.testing.assert_array_equal(piecewise.at(times, k), one_by_one)
        np.testing.assert_array_equal(piecewise.at(times[shuffled], k), whole[k, shuffled])
    np.testing.assert_array_equal(piecewise.up_to(times[shuffled], order, None), whole[:, shuffled])


@pytest.mark.parametrize("coasting", [-1, 0, 1, 2])
@pytest.mark.parametrize("pieces", [0, 1, 5])
def test_at_breaks_the_value_is_that_just_after_and_outside_it_coasts(coasting, pieces):
    motion = arrays(3, pieces)
    times = np.concatenate([motion[0], motion[0] + 1e-3, motion[0][[0, -1]] + [-0.5, 0.5]])
    values = Pieces(*motion, coasting).at(times, 0)
    for t, found in zip(times, values, strict=True):
        value, size = exact(motion, coasting, t, 0)
        assert abs(Fraction(found) - value) <= size / 2**50


def test_no_piece_is_run_past_its_duration():
    states = np.array([[0.0, 1.0], [5.0, 1.0]])
    breaks, short = np.array([0.0, 1.0, 2.0]), np.array([0.5, 1.0])
    assert Pieces(breaks, states, short, np.zeros(2), 0).at(0.75, 0) == 0.5


def test_pieces_without_length_are_passed_over():
    breaks = np.array([0.0, 1.0, 1.0, 1.0, 2.0])
    states, durations = np.arange(8.0).reshape(4, 2), np.array([1.0, 1e-30, 1e-30, 1.0])
    times = np.array([0.5, 1.0, 1.5])
    values = Pieces(breaks, states, durations, np.zeros(2), 0).at(times, 1)
    np.testing.assert_array_equal(values, [1.0, 7.0, 7.0])


TIMES = np.linspace(-3.0, 9.0, 600)


@pytest.mark.parametrize(
    "given",
    [
        TIMES.tolist(),
        TIMES.astype(">f8"),
        np.repeat(TIMES, 2)[::2],
        TIMES.reshape(2, 3, 100),
        np.asfortranarray(TIMES.reshape(20, 30)),
        memoryview(TIMES),
        np.arange(600),
        np.float32(TIMES),
    ],
)
def test_times_of_any_kind_give_the_values_of_their_numbers(given):
    piecewise = Pieces(*arrays(3), 1)
    plain = np.array(given, dtype=float)
    found = piecewise.at(given, 0)
    assert found.shape == plain.shape
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found.ravel(), [piecewise.at(float(t), 0) for t in plain.ravel()])
    np.testing.assert_array_equal(piecewise.up_to(given, 2, None)[0], found)


@pytest.mark.parametrize(
    "given", [1, 1.0, np.float64(1), np.int64(1), np.array(1.0), True], ids=repr
)
def test_one_time_gives_one_float(given):
    found = Pieces(*arrays(3), 1).at(given, 1)
    assert isinstance(found, float)
    assert found == Pieces(*arrays(3), 1).at([1.0], 1)[0]


def test_a_given_array_is_filled_row_by_row():
    piecewise, times = Pieces(*arrays(3), 1), TIMES.reshape(20, 30)
    room = np.full((5, 20, 30), np.nan)
    assert piecewise.up_to(times, 1, room[1:5:3]) is not None
    np.testing.assert_array_equal(room[[1, 4]], piecewise.up_to(times, 1, None))
    assert np.isnan(room[[0, 2, 3]]).all()


@pytest.mark.parametrize(
    "out", [np.empty((2, 5)), np.empty((3, 6)), np.empty((6, 2)).T, np.empty((2, 6), int)]
)
def test_an_array_that_does_not_fit_is_refused(out):
    with pytest.raises(ValueError, match="out does not fit"):
        Pieces(*arrays(3), 1).up_to(np.arange(6.0), 1, out)


@pytest.mark.parametrize(
    "bad", [np.nan, np.copysign(np.nan, -1.0), np.inf, -np.inf], ids=["nan", "-nan", "inf", "-inf"]
)
@pytest.mark.parametrize("where", [0, 3, 100, 199])
def test_times_must_be_finite(bad, where):
    times = np.linspace(-3.0, 9.0, 200)
    times[where] = bad
    for call in (
        lambda: Pieces(*arrays(3), 1).at(times, 0),
        lambda: Pieces(*arrays(3), 1).up_to(times, 2, None),
        lambda: Pieces(*arrays(3), 1).at(bad, 0),
    ):
        with pytest.raises(ValueError, match="times must be finite"):
            call()


def test_derivatives_beyond_the_order_are_zero():
    assert Pieces(*arrays(3), 1).at(0.0, 4) == 0.0
    assert not Pieces(*arrays(3), 1).at(TIMES, 10**6).any()


def test_the_largest_doubles_are_times_too():
    largest = np.finfo(float).max
    assert Pieces(*arrays(1), -1).at([-largest, largest], 0).tolist() == [0.0, 0.0]
    assert Pieces(*arrays(1), -1).at(np.full(300, largest), 0).tolist() == [0.0] * 300


def test_arrays_that_do_not_fit_one_another_are_refused():
    breaks, states, durations, end = arrays(3)
    with pytest.raises(ValueError, match="argument 1 has 7 values: expected 6"):
        Pieces(np.zeros(7), states, durations, end, 1)
    with pytest.raises(ValueError, match="argument 2 has 18 values: expected 20"):
        Pieces(breaks, states[:, :3].repeat(2, 1)[:3].copy(), durations, end, 1)
    with pytest.raises(TypeError, match="argument 2: expected a contiguous array of float64"):
        Pieces(breaks, states.astype(int), durations, end, 1)
    with pytest.raises(ValueError, match="coasting = 4"):
        Pieces(breaks, states, durations, end, 4)
