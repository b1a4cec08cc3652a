"""Banded matrices against dense ones."""

import numpy as np
import pytest
from scipy.linalg import cholesky_banded

from jounce.analysis.log_conformance.banded import band_of, banded, inverse_band, times_vector


def random_band(count, width, seed=0):
    band = np.random.default_rng((count, width, seed)).normal(size=(width + 1, count))
    band[0] += 2.0 * width + 2.0
    return band


def dense(band):
    count = band.shape[1]
    lower = sum(np.diag(row[: count - i], -i) for i, row in enumerate(band) if i < count)
    return lower + np.tril(lower, -1).T


@pytest.mark.parametrize("count", [6, 8, 9, 16, 37])
@pytest.mark.parametrize("width", [1, 5])
def test_the_inverse_on_the_band(count, width):
    band = random_band(count, width)
    found = inverse_band(cholesky_banded(band, lower=True))
    inverse = np.linalg.inv(dense(band))
    for i in range(width + 1):
        expected = np.diag(inverse, -i)
        np.testing.assert_allclose(found[i, : count - i], expected, rtol=1e-12, atol=1e-15)


def test_products_and_sparse_form():
    band, vector = random_band(23, 5), np.arange(23.0) - 7.0
    matrix = dense(band)
    np.testing.assert_allclose(times_vector(band, vector), matrix @ vector, rtol=1e-13)
    np.testing.assert_array_equal(banded(band).toarray(), matrix)
    np.testing.assert_array_equal(dense(band_of(banded(band), 5)), matrix)
