"""Balanced matrices beside LAPACK's."""

import numpy as np
import pytest
from scipy.linalg import matrix_balance

from jounce.plant.balance import balanced, balanced_norm


@pytest.mark.parametrize("seed", range(20))
def test_it_is_what_lapack_makes(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    units = 10.0 ** rng.uniform(-6.0, 6.0, n)
    a = rng.standard_normal((n, n)) * units[:, None] / units * (rng.random((n, n)) < 0.8)
    expected, (scale, _) = matrix_balance(a, permute=False, separate=True)
    found, own = balanced(a)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(own, scale)
    assert balanced_norm(a) == pytest.approx(abs(expected).sum(axis=0).max(), rel=1e-15)


def test_what_cannot_be_balanced_stays():
    for a in ([[0.0, 1.0], [0.0, 0.0]], [[np.inf, 1.0], [1.0, 0.0]], np.zeros((0, 0))):
        np.testing.assert_array_equal(balanced(a)[0], a)
    assert balanced_norm(np.zeros((0, 0))) == 0.0
