"""Evaluation of many points: the three ways through agree, and outside states are used."""

import numpy as np
import pytest

from jounce.shaping.evaluation import Evaluator


def evaluator():
    rng = np.random.default_rng(7)
    breaks = np.concatenate([[-2.0], -2.0 + np.cumsum(rng.uniform(0.1, 2.0, 5))])
    return Evaluator(breaks, rng.normal(size=(7, 4)), np.diff(breaks))


@pytest.mark.parametrize("derivatives", [range(4), range(1, 2), range(3, 4)])
def test_few_many_and_unsorted_points_get_the_same_values(derivatives):
    piecewise = evaluator()
    times = np.sort(np.random.default_rng(8).uniform(-4.0, 8.0, 20_000))
    many = piecewise(times, derivatives)
    few = np.hstack([piecewise(part, derivatives) for part in np.array_split(times, 10)])
    np.testing.assert_array_equal(many, few)
    order = np.random.default_rng(9).permutation(times.size)
    np.testing.assert_array_equal(piecewise(times[order], derivatives), many[:, order])


def test_outside_the_first_and_last_states_hold_from_their_own_break():
    piecewise = evaluator()
    before, after = piecewise.states[:, 0], piecewise.states[:, -1]
    powers = np.array([1.0, 0.5, 0.125, 0.125 / 6])
    late = piecewise(piecewise.breaks[-1] + 0.5, range(1))[0]
    assert late == pytest.approx(after @ powers, rel=1e-14)
    early = piecewise(piecewise.breaks[0] - 0.5, range(1))[0]
    assert early == pytest.approx(before @ (powers * [1, -1, 1, -1]), rel=1e-14)


def test_a_given_array_is_filled_and_shapes_are_kept():
    piecewise = evaluator()
    times = np.linspace(-1.0, 3.0, 12).reshape(3, 4)
    out = np.empty((2, 3, 4))
    result = piecewise(times, range(2), out)
    np.testing.assert_array_equal(result, out)
    np.testing.assert_array_equal(out, piecewise(times, range(2)))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_times_must_be_finite(bad):
    with pytest.raises(ValueError, match="times must be finite"):
        evaluator()([0.0, bad], range(1))
