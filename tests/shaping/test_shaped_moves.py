"""Input shapers against simulated modes, closed forms and place_null; refusals."""

from math import exp, pi, sqrt

import numpy as np
import pytest
from scipy.linalg import expm

from jounce.analysis import place_null, residual_vibration
from jounce.shaping import InputShaper, Limits, input_shaper, min_time_move, min_time_transfer

LIMITS = Limits(velocity=10.5, acceleration=10.5, jerk=42.0)
MOVE = min_time_move(3.5, LIMITS)
KINDS = ("ZV", "ZVD", "ZVDD", "EI")


def carried(trajectory, frequency_hz, zeta):
    """Return amplitude and phase of x″ + 2ζω(x′ − s′) + ω²(x − s) = 0 at the end, by expm."""
    w = 2 * pi * frequency_hz
    n = trajectory.order
    matrix = np.zeros((n + 3, n + 3))
    matrix[0, 1] = 1.0
    matrix[1, :4] = [-w * w, -2 * zeta * w, w * w, 2 * zeta * w]
    matrix[2:, 2:] += np.diag(np.ones(n), 1)
    x = np.array([trajectory.start_state[0], 0.0])
    for state, length in zip(trajectory.states, trajectory.durations, strict=True):
        x = (expm(matrix * length) @ np.concatenate([x, state]))[:2]
    off = x[0] - trajectory.end_state[0]
    return np.hypot(off, (x[1] + zeta * w * off) / (w * sqrt(1 - zeta**2)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("zeta", [0.0, 0.01, 0.1, 0.3])
def test_a_shaped_move_leaves_what_the_curve_says(kind, zeta):
    shaper = input_shaper(kind, 6.0, zeta)
    shaped = shaper.shape(MOVE)
    assert shaped.duration == pytest.approx(MOVE.duration + shaper.duration, rel=1e-14)
    assert shaped.end_state[0] == pytest.approx(3.5, rel=1e-14)
    for k in (1, 2, 3):
        assert shaped.peak(k) <= MOVE.peak(k) * (1 + 1e-12)
    for ratio in (0.8, 0.95, 1.0, 1.05, 1.3):
        alone = carried(MOVE, 6.0 * ratio, zeta)
        left = shaper.residual(6.0 * ratio, zeta) * alone
        assert carried(shaped, 6.0 * ratio, zeta) == pytest.approx(left, abs=2e-13)
        assert residual_vibration(shaped, 6.0 * ratio, zeta) == pytest.approx(left, abs=2e-13)
    expected = 0.05 if kind == "EI" else 0.0
    assert shaper.residual(6.0, zeta) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.1, 0.3])
@pytest.mark.parametrize("vibration", [0.01, 0.05, 0.2])
def test_an_ei_shaper_solves_its_five_equations(zeta, vibration):
    shaper = input_shaper("EI", 3.0, zeta, vibration=vibration)
    assert shaper.amplitudes.sum() == pytest.approx(1.0, abs=1e-15)
    assert shaper.duration == pytest.approx(1 / (3.0 * sqrt(1 - zeta**2)), rel=1e-14)
    assert shaper.residual(3.0, zeta) == pytest.approx(vibration, abs=1e-13)
    fine = np.linspace(1.5, 5.5, 40001)
    left = shaper.residual(fine, zeta)
    low = np.flatnonzero((left[1:-1] < left[:-2]) & (left[1:-1] < left[2:])) + 1
    assert len(low) == 2
    assert fine[low[0]] < 3.0 < fine[low[1]]
    assert (left[low] < 2e-4).all()


def test_parts_are_the_published_ones():
    zeta, f = 0.1, 2.0
    k, h = exp(-zeta * pi / sqrt(1 - zeta**2)), 0.5 / (f * sqrt(1 - zeta**2))
    for kind, parts in (("ZV", [1, k]), ("ZVD", [1, 2 * k, k * k]),
                        ("ZVDD", [1, 3 * k, 3 * k**2, k**3])):  # fmt: skip
        shaper = input_shaper(kind, f, zeta)
        np.testing.assert_allclose(shaper.amplitudes, np.array(parts) / sum(parts), rtol=1e-14)
        np.testing.assert_allclose(shaper.times, h * np.arange(len(parts)), rtol=1e-14)
    np.testing.assert_allclose(
        input_shaper("EI", f, vibration=0.1).amplitudes, [0.275, 0.45, 0.275], rtol=1e-14
    )
    at = [input_shaper(kind, 1.0).residual(1.1) for kind in KINDS]
    np.testing.assert_allclose(at, [0.1564, 0.0245, 0.0038, 0.0243], atol=6e-5)


def test_several_modes_are_all_nulled_and_bounds_kept():
    modes = [(6.0, 0.01), (11.0, 0.05), (17.3, 0.0)]
    shaper = input_shaper("ZV", *zip(*modes, strict=True))
    assert (shaper.amplitudes > 0.0).all()
    shaped = shaper.shape(min_time_move(-3.5, LIMITS))
    for f, zeta in modes:
        assert shaper.residual(f, zeta) < 1e-14
        assert carried(shaped, f, zeta) < 1e-12
    for k in (1, 2, 3):
        assert shaped.peak(k) <= LIMITS.upper[k - 1] * (1 + 1e-12)
    parts = [input_shaper("ZV", f, zeta).duration for f, zeta in modes]
    assert shaper.duration == pytest.approx(sum(parts))


def test_a_damped_mode_is_nulled_where_a_placed_null_leaves_some_of_it():
    """No real bound makes a damped mode's residual zero: a placed null only comes near it."""
    placed = min_time_move(3.5, place_null(3.5, LIMITS, 6.0, by="jerk", damping=0.01))
    assert placed.duration == pytest.approx(1.535, abs=5e-4)
    assert 3600 * residual_vibration(placed, 6.0, 0.01) == pytest.approx(0.724, abs=5e-4)
    shaped = input_shaper("ZV", 6.0, 0.01).shape(MOVE)
    assert shaped.duration == pytest.approx(1.515, abs=5e-4)
    assert 3600 * residual_vibration(shaped, 6.0, 0.01) < 5e-14


def test_any_motion_is_shaped():
    onto = min_time_transfer(0.0, (1.0, 2.0), LIMITS)
    shaped = input_shaper("ZVD", 4.0, 0.02).shape(onto)
    assert shaped.end_state[1] == pytest.approx(2.0, rel=1e-13)  # it goes on as commanded
    delay = float(input_shaper("ZVD", 4.0, 0.02).amplitudes @ input_shaper("ZVD", 4.0, 0.02).times)
    assert shaped(9.0) == pytest.approx(onto(9.0) - 2.0 * delay, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: input_shaper("ZV", -5.0), "frequency_hz = -5.0: expected a positive"),
        (lambda: input_shaper("ZV", []), "expected a frequency, or a row"),
        (lambda: input_shaper("ZV", [1.0, 2.0], [0.1, 0.2, 0.3]), "with 2 frequencies"),
        (lambda: input_shaper("zv", 5.0), "kind = 'zv': expected 'ZV', 'ZVD', 'ZVDD' or 'EI'"),
        (lambda: input_shaper("ZV", 5.0, 1.0), "damping = 1.0: expected a damping ratio"),
        (lambda: input_shaper("EI", 5.0, 0.9, vibration=0.5), "no EI shaper of positive parts"),
        (lambda: input_shaper("EI", 5.0, 0.7, vibration=0.2), "damping = 0.7: no EI shaper"),
        (lambda: input_shaper("EI", 5.0, vibration=1.0), "vibration = 1.0"),
        (lambda: input_shaper("ZV", 1e-320), "range of a double"),
        (lambda: InputShaper([0.0, 1.0], [2.0, -1.0]), "would leave its bounds"),
        (lambda: InputShaper([0.5, 1.0], [1.0, 1.0]), "increase from 0"),
        (lambda: InputShaper([0.0, 1.0], [1.0]), "one amplitude for each time"),
    ],
)
def test_what_no_shaper_is_gets_one_line(make, words):
    with pytest.raises(ValueError, match=words) as refusal:
        make()
    assert "\n" not in str(refusal.value)


def test_other_kinds_are_refused():
    with pytest.raises(TypeError, match="expected an InputShaper"):
        input_shaper("ZV", 5.0).then(3)
    with pytest.raises(TypeError, match="expected a Trajectory"):
        input_shaper("ZV", 5.0).shape(3)
