"""Readings: what is refused, and what repeated readings are taken for."""

import numpy as np
import pytest

from jounce.analysis.log_conformance.readings import checked_log, found_resolution, merged, parts

TIMES = np.arange(20.0)


@pytest.mark.parametrize(
    ("times", "positions", "message"),
    [
        (TIMES[:15], TIMES[:15], r"^15 readings are too few: expected at least 16$"),
        (TIMES, TIMES[:19], r"times of shape \(20,\) and positions of shape \(19,\) do not fit"),
        (TIMES[:, None], TIMES[:, None], r"do not fit"),
        (np.where(TIMES == 7, np.nan, TIMES), TIMES, r"^times must be finite: times\[7\] = nan"),
        (TIMES, np.where(TIMES == 3, np.inf, TIMES), r"^positions must be finite: positions\[3\]"),
        (np.where(TIMES == 7, 6, TIMES), TIMES, r"^times\[7\] = 6.0 repeats the time of the row"),
        (
            np.where(TIMES == 7, 2, TIMES),
            TIMES,
            r"^times\[7\] = 2.0 is before the time .* 6.0: .*sort",
        ),
    ],
    ids=["few", "lengths", "matrix", "nan", "infinite", "repeated", "backward"],
)
def test_what_is_no_log_is_refused(times, positions, message):
    with pytest.raises(ValueError, match=message):
        checked_log(times, positions)


def test_lists_are_taken():
    times, positions = checked_log(list(range(16)), [1] * 16)
    assert times.dtype == positions.dtype == float


def test_equal_readings_in_a_row_become_one_in_their_middle():
    positions = np.repeat(np.arange(40.0), 3)
    times, values, share = merged(np.arange(120.0), positions)
    assert share == 1.0
    np.testing.assert_array_equal(values, np.arange(40.0))
    np.testing.assert_array_equal(times, 1.0 + 3.0 * np.arange(40.0))


def test_readings_that_all_differ_stay():
    positions = np.sin(TIMES)
    times, values, share = merged(TIMES, positions)
    assert share == 1.0
    np.testing.assert_array_equal(times, TIMES)
    np.testing.assert_array_equal(values, positions)


def test_a_rest_is_divided():
    positions = np.concatenate([np.repeat(np.arange(50.0), 2), np.full(900, 50.0)])
    times, values, share = merged(np.arange(1000.0), positions)
    assert share == 1.0
    assert np.diff(times).max() <= 8.0  # four times the median run
    assert np.all(np.isin(times[values == 50.0] * 2, np.arange(2000)))
    assert times[-1] <= 999.0


@pytest.mark.parametrize("count", [16, 17, 1000])
def test_a_log_at_rest_keeps_enough_readings(count):
    times, values, share = merged(np.arange(float(count)), np.full(count, 3.0))
    assert share == pytest.approx(1.0 / len(times))
    assert 16 <= len(times) <= 32
    assert np.all(np.diff(times) > 0.0)
    assert set(values) == {3.0}


def test_a_resolution_shows_where_readings_repeat():
    motion = np.sin(np.linspace(0.0, 3.0, 2000))
    assert found_resolution(0.01 * np.round(motion / 0.01)) == pytest.approx(0.01)
    assert found_resolution(1e-5 * np.round(motion / 1e-5)) == 0.0
    assert found_resolution(motion) == 0.0
    assert found_resolution(np.ones(20)) == 0.0


def test_few_counts_are_few_independent_readings():
    times, _, share = merged(np.arange(400.0), np.repeat([0.0, 1.0], 200))
    assert share * len(times) == pytest.approx(2.0)


def test_pauses_part_a_log():
    times = np.concatenate([np.arange(50.0), 200.0 + np.arange(10.0), 400.0 + np.arange(300.0)])
    found = [(part.start, part.stop) for part in parts(times)]
    assert found == [(0, 50), (60, 360)]
    assert len(parts(np.concatenate([np.arange(50.0), 140.0 + np.arange(50.0)]))) == 1


def test_numbers_out_of_range_are_refused():
    for times, positions in ((1e200 * TIMES, TIMES), (1e-40 * TIMES, TIMES), (TIMES, 1e31 * TIMES),
                             (TIMES, 1e-300 * TIMES)):  # fmt: skip
        with pytest.raises(ValueError, match="choose units nearer to the problem's own"):
            checked_log(times, positions)
