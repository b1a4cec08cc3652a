"""Products and roots of many polynomials, against numpy's of each."""

import numpy as np
import pytest

from jounce.analysis.margins.many_roots import degrees, product, roots, summed, trimmed


def of_roots(places):
    """Return the coefficients of ∏(x − r), ascending."""
    return np.real(np.poly(places))[::-1]


def sorted_roots(row):
    found = roots(np.atleast_2d(row))[0]
    return np.sort_complex(found[np.isfinite(found)])


def test_rows_are_shifted_to_a_constant_term():
    rows = np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 2.0], [0.0, 0.0, 0.0]])
    shifted, by = trimmed(rows)
    np.testing.assert_array_equal(shifted, [[3.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 0.0, 0.0]])
    assert by.tolist() == [2, 0, 0]
    assert degrees(rows).tolist() == [2, 2, 0]
    assert degrees(shifted).tolist() == [0, 2, 0]


def test_products_and_sums_are_those_of_polynomials():
    rng = np.random.default_rng(0)
    left, right = rng.normal(size=(5, 4)), rng.normal(size=(5, 3))
    expected = [np.convolve(a, b) for a, b in zip(left, right, strict=True)]
    np.testing.assert_allclose(product(left, right), expected, rtol=1e-14)
    weighted = product(left, right, lambda i, j: i - j)
    lowered = [
        np.convolve(a * np.arange(4), b) - np.convolve(a, b * np.arange(3))
        for a, b in zip(left, right, strict=True)
    ]
    np.testing.assert_allclose(weighted, lowered, atol=1e-13)
    total = np.zeros((5, 4))
    total[:, :3] = right
    np.testing.assert_array_equal(summed(left, right), left + total)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 10])
def test_roots_of_every_degree(count):
    rng = np.random.default_rng(count)
    real = rng.normal(size=count % 2)
    upper = rng.normal(size=count // 2) + 1j * rng.uniform(0.1, 2.0, count // 2)
    places = np.concatenate([real, upper, upper.conj()])
    np.testing.assert_allclose(sorted_roots(of_roots(places)), np.sort_complex(places), rtol=1e-8)


def test_rows_of_different_degree_and_roots_at_zero():
    rows = np.array([[0.0, -2.0, 1.0, 0.0], [6.0, -5.0, 1.0, 0.0], [5.0, 0.0, 0.0, 0.0], [0.0] * 4])
    found = roots(rows)
    assert found.shape == (4, 3)
    some = [np.sort(row[np.isfinite(row)].real).tolist() for row in found]
    assert some == [[2.0], [2.0, 3.0], [], []]
    assert np.all(found[~np.isfinite(found)].real == -np.inf)


@pytest.mark.parametrize("decades", [4, 8, 12])
def test_roots_many_decades_apart_keep_digits(decades):
    places = 10 ** np.linspace(-decades / 2, decades / 2, 7) * np.array([1, -1, 1, 1, -1, 1, -1])
    found = sorted_roots(of_roots(places))
    np.testing.assert_allclose(found, np.sort(places), rtol=1e-5)


def test_nearly_double_roots_of_quadratics_and_of_opposite_sign():
    for places in ([1.0, 1.0 + 1e-6], [-1e-9, 1e9], [1e-9, 1e9], [3.0, 3.0]):
        np.testing.assert_allclose(sorted_roots(of_roots(places)).real, places, rtol=1e-8)


@pytest.mark.parametrize("factor", [1e-200, 1e200])
def test_the_size_of_the_coefficients_does_not_matter(factor):
    row = of_roots([1.0, -2.0, 3.0, -4.0])
    np.testing.assert_allclose(sorted_roots(row * factor), sorted_roots(row), rtol=1e-13)
