"""Verdicts on logs of known moves: never wrong, and mostly given."""

from math import inf, isnan

import numpy as np
import pytest
from encoder_logs import NOISES, NONE, encoder_log, random_move
from tiers import some

from jounce.analysis.log_conformance import conformance
from jounce.shaping import Limits, min_time_move


@pytest.mark.parametrize("order", some([2, 3, 4], 2))
@pytest.mark.parametrize("kind", NOISES)
def test_true_peaks_are_within_the_error_bars(order, kind):
    missed, seen = [], 0
    for seed in range(6):
        move = random_move(order, seed)
        times, positions, resolution = encoder_log(move, seed, kind)
        report = conformance(times, positions, NONE, resolution=resolution)
        for peak in report.peaks[: order - (order == 3) if order < 4 else 3]:
            seen += 1
            if not peak.least <= move.peak(peak.derivative) <= peak.most:
                missed.append((seed, peak, move.peak(peak.derivative)))
    assert len(missed) <= 0.1 * seen, missed


@pytest.mark.parametrize("kind", NOISES)
@pytest.mark.parametrize("order", [3, 4])
def test_verdicts_are_never_wrong_and_mostly_given(order, kind):
    """Limits 40 % off the peaks; jerk that is constant by pieces is not asked for."""
    told = []
    for seed in range(4):
        move = random_move(order, seed)
        times, positions, resolution = encoder_log(move, seed, kind)
        peaks = [move.peak(k) for k in (1, 2)]
        for factor, right in ((1.4, "kept"), (0.6, "broken")):
            limits = Limits.from_bounds([factor * peak for peak in peaks])
            report = conformance(times, positions, limits, resolution=resolution)
            for peak in report.peaks[:2]:
                assert peak.verdict in (right, "cannot tell"), (seed, factor, peak)
                told.append(peak.verdict == right)
    assert np.mean(told) >= 0.8


@pytest.mark.parametrize("seed", range(6))
def test_jerk_is_called_broken_only_if_it_is(seed):
    move = random_move(3, seed)
    times, positions, _ = encoder_log(move, seed, "fine noise", count=6000)
    kept = conformance(times, positions, Limits(jerk=1.05 * move.peak(3)))
    broken = conformance(times, positions, Limits(jerk=0.5 * move.peak(3)))
    assert kept.kept is not False
    assert broken.kept is False


def test_a_jump_of_acceleration_breaks_any_jerk():
    move = min_time_move(1.0, Limits(velocity=2.0, acceleration=5.0))
    times, positions, _ = encoder_log(move, 1, "fine noise", count=3000)
    report = conformance(times, positions, Limits(velocity=2.2, jerk=100.0))
    assert [peak.verdict for peak in report.peaks] == ["kept", "no limit", "broken"]
    assert report.kept is False


def rested(move, step):
    times = np.arange(-0.5, move.duration + 0.5, step)
    return times, move(np.clip(times, 0.0, move.duration))


def test_readings_of_few_counts_tell_nothing_of_jerk():
    move = min_time_move(5.0, Limits(velocity=3.0, acceleration=4.0, jerk=60.0))
    times, positions = rested(move, 0.01)
    report = conformance(
        times, 0.5 * np.round(positions / 0.5), Limits(2.0, 3.0, 20.0), resolution=0.5
    )
    assert [peak.verdict for peak in report.peaks] == ["cannot tell"] * 3
    assert report.peaks[2].most == inf
    assert report.kept is None


HASTY = {
    "jerk 40": (3.0, 4.0, 40.0),
    "jerk 100": (3.0, 4.0, 100.0),
    "jerk 400": (3.0, 4.0, 400.0),
    "velocity steps": (3.0, 300.0, 1e5),
    "position steps": (100.0, 1e5, 1e8),
}


@pytest.mark.parametrize("name", some(HASTY, 3))
def test_what_exceeds_a_limit_by_half_is_never_called_kept(name):
    """Its upper end would lie below two thirds of the true peak; the limit then in between."""
    move = min_time_move(5.0, Limits.from_bounds(HASTY[name]), method="closed-form")
    rng = np.random.default_rng(7)
    for step in (0.003, 0.01, 0.05):
        times, positions = rested(move, step)
        for size in (0.001, 0.05, 0.1, 0.5):
            counts = size * np.round(positions / size)
            logs = [
                (positions + size * rng.standard_normal(len(times)), None),
                (counts, None),
                (counts, size),
                (counts, 100.0),
            ]
            for readings, resolution in logs:
                peaks = conformance(times, readings, NONE, resolution=resolution).peaks
                for k in (1, 2, 3):
                    assert peaks[k - 1].most > move.peak(k) / 1.5, (step, size, resolution, k)


def test_good_logs_are_called_kept():
    for bounds in ((3.0, 4.0, 20.0), (3.0, 4.0, 60.0), (1.0, 2.0, 20.0)):
        move = min_time_move(5.0, Limits.from_bounds(bounds), method="closed-form")
        times, positions = rested(move, 0.001)
        readings = 1e-5 * np.round(positions / 1e-5)
        allowed = Limits(1.1 * bounds[0], 1.1 * bounds[1], 2.0 * bounds[2])
        report = conformance(times, readings, allowed, resolution=1e-5)
        assert [peak.verdict for peak in report.peaks] == ["kept"] * 3, (bounds, str(report))


def test_constant_velocity_keeps_velocity_and_acceleration_only():
    times = np.arange(0.0, 10.0, 0.01)
    noise = 1e-5 * np.random.default_rng(0).standard_normal(len(times))
    moving = conformance(times, times + noise, Limits(1.1, 1.0, 100.0))
    assert [peak.verdict for peak in moving.peaks] == ["kept", "kept", "cannot tell"]
    resting = conformance(times, noise, Limits(0.1))
    assert resting.kept is True


def test_an_axis_at_rest():
    times = np.linspace(0.0, 10.0, 5000)
    report = conformance(times, np.full(5000, 3.2), Limits(0.1, 0.1, 0.1), resolution=1e-3)
    assert report.kept is True
    assert report.resolved_time <= 10.0
    with pytest.raises(ValueError, match=r"^positions are all 3.2: at rest .* give resolution=…"):
        conformance(times, np.full(5000, 3.2), Limits(0.1))


def test_a_tolerance_lets_a_planned_peak_pass():
    move = min_time_move(1.0, Limits(velocity=2.0, acceleration=10.0, jerk=100.0))
    times, positions, _ = encoder_log(move, 2, "fine noise", count=2000)
    exact = conformance(times, positions, Limits(velocity=2.0))
    assert (exact.kept, exact.peaks[0].verdict) == (None, "cannot tell")
    assert conformance(times, positions, Limits(velocity=2.0), tolerance=0.02).kept is True


def test_snap_cannot_be_told():
    move = random_move(4, 0)
    times, positions, _ = encoder_log(move, 0, "fine noise")
    limits = Limits(velocity=10.0, snap=1e12, pop=1e20)
    report = conformance(times, positions, limits)
    assert [peak.name for peak in report.peaks][3:] == ["snap", "pop"]
    assert report.kept is None
    assert report.peaks[-1].most == inf
    assert isnan(report.peaks[-1].used)


def test_coarser_readings_make_wider_error_bars():
    move = random_move(3, 4)
    widths = []
    for kind in ("fine noise", "noise", "coarse noise"):
        times, positions, _ = encoder_log(move, 4, kind)
        report = conformance(times, positions, NONE)
        widths.append([peak.most - peak.least for peak in report.peaks] + [report.resolved_time])
    assert np.all(np.diff(widths, axis=0) > 0.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"resolution": 0.0}, r"^resolution = 0.0: expected a positive"),
        ({"resolution": np.nan}, r"^resolution = nan"),
        ({"tolerance": -0.1}, r"^tolerance = -0.1: expected zero or more"),
        ({"tolerance": np.nan}, r"^tolerance = nan"),
    ],
    ids=["resolution zero", "resolution nan", "tolerance negative", "tolerance nan"],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        conformance(np.arange(20.0), np.arange(20.0), NONE, **options)


@pytest.mark.parametrize("limits", [None, {"velocity": 1.0}, 2.0])
def test_limits_have_to_be_limits(limits):
    with pytest.raises(TypeError, match=r"expected Limits, such as Limits\(velocity=2.0\)"):
        conformance(np.arange(20.0), np.arange(20.0), limits)


def test_bands_by_name():
    report = conformance(np.arange(40.0), np.sin(0.1 * np.arange(40.0)), NONE)
    assert report.band("jerk") is report.bands[2]
    for wrong in ("position", "snap"):
        with pytest.raises(ValueError, match="expected velocity, acceleration or jerk"):
            report.band(wrong)
    assert repr(report) == (
        "Conformance(readings=40, velocity: kept, acceleration: no limit, jerk: no limit)"
    )


def test_a_hundred_thousand_readings():
    times = np.arange(100_000) * 1e-3
    noise = 1e-5 * np.random.default_rng(0).standard_normal(len(times))
    report = conformance(times, np.sin(times) + noise, Limits(1.01, 1.05, 1.5))
    assert [peak.verdict for peak in report.peaks] == ["kept", "kept", "kept"]
    assert report.noise == pytest.approx(1e-5, rel=0.02)
