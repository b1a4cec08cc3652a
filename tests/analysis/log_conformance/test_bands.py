"""Error bars: constants of the kernel against quadrature, coverage against simulation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, trapezoid

from jounce.analysis.log_conformance.bands import (
    OVERSHOOT,
    RESOLVED,
    critical_value,
    joint_band,
    noise_share,
)
from jounce.analysis.log_conformance.fit import fit_spline


def response(omega):
    return 1.0 / (1.0 + omega**8)


def step(time):
    """Return the kernel's answer to a jump from 0 to 1, in units of τ."""
    nodes = np.linspace(1e-9, 20.0, 20_001)
    return 0.5 + trapezoid(response(nodes) * np.sin(nodes * time) / nodes, nodes) / np.pi


def test_overshoot_and_resolution_of_the_kernel():
    levels = [step(time) for time in np.linspace(2.0, 6.0, 81)]
    assert max(levels) - 1.0 == pytest.approx(OVERSHOOT, abs=0.001)
    assert 2.0 * step(0.5 * RESOLVED) - 1.0 >= 0.9 > 2.0 * step(0.48 * RESOLVED) - 1.0


@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_share_of_noise_and_the_critical_value(k):
    def moment(power, of):
        return quad(lambda omega: omega**power * of(omega), 0.0, np.inf)[0]

    def squared(omega):
        return response(omega) ** 2

    assert noise_share(k) == pytest.approx(moment(2 * k, squared) / moment(2 * k, response))
    lengths = 50.0 * np.pi / moment(0, response)  # freedom = T/2π·∫H dω, over both signs
    speed = np.sqrt(moment(2 * k + 2, squared) / moment(2 * k, squared))
    c = critical_value(k, 50.0)
    tail = 2.0 * quad(lambda x: np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi), c, np.inf)[0]
    assert lengths * speed / np.pi * np.exp(-0.5 * c * c) + tail == pytest.approx(0.05, rel=1e-6)


def smooth_log(seed, count=600):
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, count)
    return t, np.sin(20.0 * t) + 1e-3 * rng.standard_normal(count)


@pytest.fixture(scope="module")
def logs():
    return [fit_spline(*smooth_log(seed), 0.0) for seed in range(60)]


@pytest.mark.parametrize("k", [1, 2, 3])
def test_a_smooth_motion_is_within_its_error_bars_at_all_times(logs, k):
    covered = []
    for fit in logs:
        band = joint_band([fit], k)
        truth = 20.0**k * np.sin(20.0 * band.times + 0.5 * np.pi * k)
        covered.append(bool(np.all(np.abs(band.values - truth) <= band.error)))
    assert np.mean(covered) >= 0.9


@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_noise_is_that_of_repeated_logs(logs, k):
    """Inside the log; the scatter of 60 logs, averaged over time."""
    bands = [joint_band([fit], k) for fit in logs]
    at = np.linspace(0.1, 0.9, 200)
    values = [np.interp(at, band.times, band.values) for band in bands]
    expected = np.sqrt(np.mean(np.var(values, axis=0, ddof=1)))
    found = np.median(
        [band.amplification * fit.noise for band, fit in zip(bands, logs, strict=True)]
    )
    assert found == pytest.approx(expected, rel=0.15)


def test_the_error_grows_in_a_gap():
    t, y = smooth_log(1)
    kept = (t < 0.4) | (t > 0.55)
    band = joint_band([fit_spline(t[kept], y[kept], 0.0)], 2)
    gap = np.abs(band.times - 0.475) < 0.02
    inside = np.abs(band.times - 0.2) < 0.05
    assert band.noise[gap].min() > 5.0 * band.noise[inside].max()
    truth = -400.0 * np.sin(20.0 * band.times)
    assert np.all(np.abs(band.values - truth) <= band.error)


def test_parts_of_a_log_share_their_error_bars(logs):
    first, second = logs[0], replace(logs[1], start=5.0)
    joint = joint_band([first, second], 2)
    alone = [joint_band([fit], 2) for fit in (first, second)]
    assert joint.starts == (0, len(alone[0].times))
    np.testing.assert_array_equal(joint.values, np.concatenate([band.values for band in alone]))
    np.testing.assert_array_equal(joint.times, np.concatenate([band.times for band in alone]))
    wider = joint.noise / np.concatenate([band.noise for band in alone])
    assert 1.0 < wider.min() <= wider.max() < 1.1
    assert joint.times[joint.starts[1]] > 5.0
