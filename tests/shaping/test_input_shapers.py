"""Input shapers: nothing left of a mode, every bound kept, published forms; sums."""

from math import exp, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jounce.shaping import InputShaper, Limits, Trajectory, input_shaper, min_time_move

LIMITS = Limits(velocity=1.0, acceleration=8.0, jerk=200.0)
MOVE = min_time_move(0.5, LIMITS)
KINDS = ["ZV", "ZVD", "ZVDD", "EI"]


def swing_after(command, frequency_hz, zeta):
    """Return the amplitude that a mode on a moving base swings with after the command's end.

    By the integral of e^(−pt) against the base's acceleration, of each piece in closed form.
    """
    omega = 2 * pi * frequency_hz
    pole = -zeta * omega + 1j * omega * sqrt(1 - zeta**2)
    total = 0.0
    for start, h, row in zip(command.breaks, np.diff(command.breaks), command.states, strict=False):
        a, j = row[2], row[3]
        grown = np.exp(-pole * h)
        part = a * (1 - grown) / pole + j * ((1 - grown) / pole**2 - h * grown / pole)
        total += np.exp(-pole * (start - command.end_time)) * part
    return abs(total)


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.1, 0.3])
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_left_of_the_mode_but_what_ei_leaves(kind, zeta):
    shaper = input_shaper(kind, 5.0, zeta)
    shaped = shaper.shape(MOVE)
    bare = swing_after(MOVE, 5.0, zeta)
    decay = exp(-zeta * 2 * pi * 5.0 * shaper.duration)
    left = 0.05 if kind == "EI" else 0.0
    assert shaper.residual(5.0, zeta) == pytest.approx(left, abs=1e-12)
    expected = shaper.residual(5.0, zeta) * bare
    assert swing_after(shaped, 5.0, zeta) == pytest.approx(expected, abs=1e-11 * bare)
    assert decay > 0.0


@given(
    frequency=st.floats(0.5, 50.0),
    zeta=st.floats(0.0, 0.5),
    kind=st.sampled_from(KINDS[:3]),
    other=st.floats(0.2, 5.0),
)
def test_a_shaped_command_keeps_all_bounds_and_its_length(frequency, zeta, kind, other):
    shaper = input_shaper(kind, [frequency, other * frequency], [zeta, 0.0])
    shaped = shaper.shape(MOVE)
    assert shaped.violation(LIMITS) < 1e-9
    assert shaped.end_state[0] == pytest.approx(0.5, abs=1e-14)
    assert shaped.duration == pytest.approx(MOVE.duration + shaper.duration, rel=1e-13)
    assert shaper.amplitudes.sum() == pytest.approx(1.0, abs=1e-15)
    assert shaper.residual(frequency, zeta) < 1e-12
    assert shaper.residual(other * frequency) < 1e-12
    assert shaped.lowest_jump() == 3


def test_zero_vibration_beats_a_command_that_is_slowed_down():
    """At 6 Hz of a telescope: nothing is left, and the move is shorter than with a nulled jerk."""
    limits = Limits(velocity=10.5, acceleration=10.5, jerk=42.0)
    move = min_time_move(3.5, limits)
    shaped = input_shaper("ZV", 6.0).shape(move)
    assert swing_after(shaped, 6.0, 0.0) < 1e-13 * 10.5
    assert shaped.duration == pytest.approx(move.duration + 1 / 12.0)


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.2])
def test_ei_leaves_nothing_at_a_frequency_on_either_side(zeta):
    shaper = input_shaper("EI", 5.0, zeta)
    ratios = np.linspace(0.6, 1.4, 8001)
    curve = shaper.residual(5.0 * ratios, zeta)
    below, above = curve[ratios < 1.0], curve[ratios > 1.0]
    assert max(below.min(), above.min()) < 2e-4
    wide = input_shaper("EI", 5.0, zeta, vibration=0.2)
    assert (wide.residual(5.0 * ratios, zeta) < 0.2).sum() > (curve < 0.05).sum()


def test_robustness_goes_up_with_the_order():
    """At ±10 %: 0.156, 0.0245, 0.0038, 0.0243."""
    found = [float(input_shaper(kind, 5.0).residual(5.5)) for kind in KINDS]
    assert found == pytest.approx([0.156, 0.0245, 0.0038, 0.0243], rel=0.01)


def test_a_sum_is_the_sum_of_functions_of_time():
    rng = np.random.default_rng(7)
    first = min_time_move(1.0, LIMITS).delay(0.3)
    second = min_time_move(-0.4, Limits(velocity=2.0, acceleration=5.0)).shift(2.0)
    total = first + second
    t = rng.uniform(-1.0, 3.0, 500)
    for k in range(3):
        np.testing.assert_allclose(total(t, k), first(t, k) + second(t, k), atol=1e-13)
    assert total.order == 3
    twice = first + first
    assert len(twice.breaks) == len(first.breaks)
    with pytest.raises(TypeError):
        first + 1.0


def test_a_coasting_start_goes_on_in_the_sum():
    coming = Trajectory([0.0, 1.0], [[1.0, 2.0, -2.0]])
    total = coming + coming.delay(0.5)
    t = np.array([-1.0, 0.25, 1.2, 4.0])
    np.testing.assert_allclose(total(t), coming(t) + coming(t - 0.5), atol=1e-13)
    shaped = InputShaper([0.0, 0.5], [1.0, 1.0]).shape(coming)
    np.testing.assert_allclose(shaped(t), 0.5 * (coming(t) + coming(t - 0.5)), atol=1e-13)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: input_shaper("ZVX", 5.0), "kind = 'ZVX'"),
        (lambda: input_shaper("ZV", -5.0), "frequency_hz = -5.0"),
        (lambda: input_shaper("ZV", 5.0, 1.0), "damping = 1.0"),
        (lambda: input_shaper("EI", 5.0, vibration=1.5), "vibration = 1.5"),
        (lambda: InputShaper([0.0, 0.1], [1.0, -0.2]), "negative one"),
        (lambda: InputShaper([0.1], [1.0]), "increase from 0"),
    ],
)
def test_what_shapes_nothing_gets_one_line(make, words):
    with pytest.raises(ValueError, match=words):
        make()
