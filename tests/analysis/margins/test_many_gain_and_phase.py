"""The smallest of many margins, and phase crossovers picked from monotone pieces."""

import numpy as np
import pytest

from jounce.analysis.margins.many_crossings import pieces_of
from jounce.analysis.margins.many_gain_and_phase import gain_margins, least, phase_and_delay
from jounce.analysis.margins.many_loops import loops_of


@pytest.fixture(autouse=True)
def _quiet():
    with np.errstate(all="ignore"):
        yield


def test_the_smallest_margin_and_of_equal_ones_the_lowest_place():
    margins = np.array([[3.0, 1.0, 1.0 + 1e-15], [np.inf] * 3, [np.inf, np.inf, 2.0]])
    places = np.array([[1.0, 9.0, 5.0], [1.0, 2.0, 3.0], [np.nan, np.nan, 0.0]])
    value, place = least(margins, places)
    assert value.tolist() == [1.0, np.inf, 2.0]
    np.testing.assert_array_equal(place, [5.0, np.nan, 0.0])
    value, place = least(np.empty((2, 0)), np.empty((2, 0)))
    assert value.tolist() == [np.inf, np.inf]
    assert np.isnan(place).all()


def test_of_endless_phase_crossovers_the_nearest_to_unit_gain_is_taken():
    """0.99·e^(−τs)/(s + 1) falls from the first on; behind a resonance they rise, then fall."""
    loops = loops_of(np.array([[0.99]]), np.array([[1.0, 1.0]]), np.array([1e4]))
    margins, _ = gain_margins(pieces_of(loops))
    omega = margins["upper_gain_margin_hz"] * loops.scale
    turns = (omega * 1e4 + np.arctan(omega)) / (2 * np.pi)
    np.testing.assert_allclose(turns, 0.5, rtol=1e-12)


def test_a_jump_of_phase_on_the_axis_is_no_crossover():
    """(s² + 4)/((s² + 1)(s + 1)): the phase leaps over −180° at its undamped pole and zero."""
    num, den = np.array([[1.0, 0.0, 4.0]]), np.polymul([1.0, 0.0, 1.0], [1.0, 1.0])[None]
    pieces = pieces_of(loops_of(num, den, np.zeros(1)))
    margins, (gains, places) = gain_margins(pieces)
    angles = phase_and_delay(pieces)
    found = np.sort(places[np.isfinite(gains)])
    omega = np.linspace(1e-6, 50.0, 400_003)
    s = 1j * omega
    value = np.polyval(num[0], s) / np.polyval(den[0], s)
    changes = (np.diff(np.sign(value.imag)) != 0) & (value.real[1:] < 0)
    smooth = changes & (abs(value[1:]) < 100) & (abs(value[1:]) > 1e-3)
    assert found.size == np.count_nonzero(smooth)
    assert np.all(angles["phase_margin_deg"] > 0)
    assert set(margins) == {
        f"{side}_gain_margin_{unit}" for side in ("lower", "upper") for unit in ("db", "hz")
    }
