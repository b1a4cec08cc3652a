"""Verdicts that do not depend on units, direction, place, gaps and speed of reading."""

from math import inf

import numpy as np
import pytest
from encoder_logs import NONE, encoder_log, random_move

from jounce.analysis.log_conformance import conformance
from jounce.shaping import Limits, min_time_move


def test_directions_apart():
    move = min_time_move(1.0, Limits(velocity=2.0, acceleration=(-4.0, 8.0), jerk=200.0))
    times, positions, _ = encoder_log(move, 1, "fine noise", count=3000)
    limits = Limits(velocity=(-1.0, 1.8), acceleration=(-6.0, 6.0), jerk=(-inf, 900.0))
    report = conformance(times, positions, limits)
    verdicts = {peak.name: peak.verdict for peak in report.peaks}
    assert verdicts == {
        "velocity +": "broken",
        "velocity −": "kept",
        "acceleration": "broken",
        "jerk +": "kept",
        "jerk −": "no limit",
    }
    wide = conformance(times, positions, Limits(acceleration=(-5.0, 9.0)))
    assert wide.kept is True
    swapped = conformance(times, -positions, Limits(acceleration=(-5.0, 9.0)))
    assert swapped.kept is False


def test_the_mirrored_log_has_the_mirrored_peaks():
    move = random_move(4, 3)
    times, positions, _ = encoder_log(move, 3, "noise")
    limits = Limits(velocity=(-2.0, 3.0), acceleration=(-4.0, 5.0))
    there = conformance(times, positions, limits).peaks
    back = conformance(times, -positions, limits.mirror()).peaks
    for first, second in ((0, 1), (1, 0), (2, 3), (3, 2)):
        assert there[first].direction == -back[second].direction
        expected = (there[first].used, there[first].least, there[first].most, there[first].limit)
        peak = back[second]
        assert (peak.used, peak.least, peak.most, peak.limit) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("distance", [1e-9, 1e9])
@pytest.mark.parametrize("time", [1e-9, 1.0, 1e9])
def test_units_do_not_matter(distance, time):
    move = random_move(3, 1)
    times, positions, resolution = encoder_log(move, 1, "counts")
    plain = conformance(times, positions, Limits(2.0, 3.0, 100.0), resolution=resolution)
    rate = [distance / time**k for k in (1, 2, 3)]
    limits = Limits(2.0 * rate[0], 3.0 * rate[1], 100.0 * rate[2])
    other = conformance(
        time * times, distance * positions, limits, resolution=distance * resolution
    )
    assert [peak.verdict for peak in other.peaks] == [peak.verdict for peak in plain.peaks]
    for k, (found, peak) in enumerate(zip(other.peaks, plain.peaks, strict=True)):
        expected = np.array([peak.used, peak.least, peak.most]) * rate[k]
        np.testing.assert_allclose([found.used, found.least, found.most], expected, rtol=1e-5)


def test_when_and_where_the_log_was_taken_does_not_matter():
    move = random_move(3, 2)
    times, positions, _ = encoder_log(move, 2, "noise")
    plain = conformance(times, positions, NONE)
    later = conformance(times + 1.7e9, positions + 1e3, NONE)
    for found, peak in zip(later.peaks[:2], plain.peaks[:2], strict=True):
        assert found.used == pytest.approx(peak.used, rel=1e-3)
        assert found.time - 1.7e9 == pytest.approx(peak.time, abs=0.05 * move.duration)


def test_missing_samples_leave_the_peaks_within_the_error_bars():
    move = random_move(4, 4)
    times, positions, _ = encoder_log(move, 4, "noise", count=2000)
    whole = conformance(times, positions, NONE)
    there = np.abs(times / move.duration - 0.2) > 0.06
    gapped = conformance(times[there], positions[there], NONE)
    for k in (1, 2):
        assert gapped.peaks[k - 1].least <= move.peak(k) <= gapped.peaks[k - 1].most
        middle = 0.2 * move.duration
        wide, narrow = (
            np.interp(middle, report.bands[k - 1].times, report.bands[k - 1].noise)
            for report in (gapped, whole)
        )
        assert wide > 2.0 * narrow


@pytest.mark.parametrize("order", [2, 3])
def test_an_encoder_read_much_faster_than_it_counts(order):
    """Twenty readings a count: taken for independent they would break limits that were kept."""
    for seed in range(4):
        move = random_move(order, seed)
        rest = 0.2 * move.duration
        times = np.linspace(-rest, move.duration + rest, 20_000)
        positions = 0.01 * np.round(move(times) / 0.01 + 0.3)
        limits = Limits(1.05 * move.peak(1), 1.05 * move.peak(2))
        report = conformance(times, positions, limits)
        assert report.resolution == pytest.approx(0.01)
        assert report.noise > 0.002
        assert report.kept is not False, (seed, report.peaks)


def test_a_single_count_breaks_nothing():
    """One step of the reading may be a slow motion as well as a fast one."""
    times = np.linspace(0.0, 1.0, 200)
    for resolution in (None, 1.0):
        report = conformance(
            times, np.floor(times + 0.5), Limits(1.1, 1.0, 1.0), resolution=resolution
        )
        assert report.kept is None, str(report)


@pytest.mark.parametrize("pause", [0.01, 10.0, 1e5])
def test_what_is_logged_with_pauses_is_checked_as_without(pause):
    move = random_move(3, 2)
    times = np.linspace(-0.1 * move.duration, 1.1 * move.duration, 1000)
    cycle = 1.2 * move.duration + pause * move.duration
    rng = np.random.default_rng(0)
    logs = [
        (times + i * cycle, move(times) + i + 1e-5 * rng.standard_normal(1000)) for i in range(3)
    ]
    report = conformance(*map(np.concatenate, zip(*logs, strict=True)), NONE)
    assert len(report.bands[0].starts) == (1 if pause < 1.0 else 3)
    assert report.noise == pytest.approx(1e-5, rel=0.1)
    for k in (1, 2):
        assert report.peaks[k - 1].least <= move.peak(k) <= report.peaks[k - 1].most
        assert report.peaks[k - 1].most < 1.2 * move.peak(k)


def test_pieces_too_short_to_check_are_refused():
    times = np.concatenate([i * 1e4 + np.arange(12.0) for i in range(4)])
    with pytest.raises(ValueError, match="pieces of less than 16 readings"):
        conformance(np.sort(times), np.arange(48.0), NONE)
