"""Describing functions against closed forms, simulation with quadrature, and python-control."""

from math import pi

import control
import mpmath
import numpy as np
import pytest

from jounce.analysis.frequency_view import periodic
from jounce.analysis.frequency_view.describing_functions import (
    describing_function,
    periodic_response,
)
from jounce.shaping import CommandFollower, JerkFilter, Limits

LIMITER = Limits(velocity=1.0)
TRIANGLE = np.hypot(1.0, pi / 2.0)
LOADS = [1.0 + 1e-9, 1.001, 1.05, 1.3, 1.6, 1.8, TRIANGLE - 1e-9, TRIANGLE + 1e-9, 2.0, 5.0, 300.0]


def in_40_digits(load):
    """Return N of a rate limiter with the regime found by following the motion, not by formula."""
    with mpmath.workdps(40):
        slope = 1 / mpmath.mpf(float(load))
        begin = -mpmath.acos(slope)

        def ahead(theta):
            return mpmath.sin(begin) + slope * (theta - begin) - mpmath.sin(theta)

        end = mpmath.findroot(ahead, (-1.2 * begin, -2.5 * begin), solver="illinois")
        if mpmath.cos(end) < -slope:  # met too late: the mirrored ramp begins there at once
            end = mpmath.findroot(
                lambda turn: slope * mpmath.pi / 2 - mpmath.sin(turn), mpmath.mpf(3)
            )
            begin = end - mpmath.pi

        def turned(output):
            return lambda theta: output(theta) * mpmath.expj(-theta)

        ramp = turned(lambda theta: mpmath.sin(begin) + slope * (theta - begin))
        total = mpmath.quad(ramp, [begin, end])
        total += mpmath.quad(turned(mpmath.sin), [end, begin + mpmath.pi])
        return complex(2j / mpmath.pi * total)


def harmonic(theta, output):
    """Return N from samples of one whole period, both ends included, by the trapezoidal rule."""
    return 1j / pi * np.trapezoid(output * np.exp(-1j * theta), theta)


def simulated(follower, *, settle, periods=1, parts=16, with_velocity=False):
    """Return N from the last of some periods of the sine sin t, from rest, simulated.

    The first ones, to settle, sample by sample, the others with each sample in some parts: seen
    from a command that goes on as it does, the best motion stays the best, so that to
    replan more often than the command changes does not change the motion.
    """
    count, speed = round(2.0 * pi / follower.dt), follower.limits.upper[0]
    theta = follower.dt * np.arange(count * periods)
    velocities = np.clip(np.cos(theta), -speed, speed) * with_velocity
    plain = CommandFollower(follower.limits, dt=follower.dt)
    run = plain.run(
        np.tile(np.sin(theta[:count]), settle),
        command_velocities=np.tile(velocities[:count], settle),
    )
    commands = np.sin(theta)[:, None] + velocities[:, None] * (
        follower.dt / parts * np.arange(parts)
    )
    finer = CommandFollower(
        follower.limits, dt=follower.dt / parts, jerk_filter=follower.jerk_filter
    )
    begin = run.states[: follower.order, -1]
    fine = finer.run(
        commands.ravel(), command_velocities=np.repeat(velocities, parts), initial=begin
    )
    last = np.concatenate([begin[:1], fine.states[0]])[-count * parts - 1 :]
    return harmonic(np.linspace(0.0, 2.0 * pi, len(last)), last)


# The rate limiter


@pytest.mark.parametrize("load", LOADS, ids=str)
def test_rate_limiter_in_40_digits(load):
    found = describing_function(LIMITER, load, 1.0).response
    assert abs(found - in_40_digits(load)) < 2e-15


def test_rate_limiter_by_simulation():
    """The motion itself, in 10,000 steps per period."""
    slopes, count = 1.0 / np.array(LOADS), 10_000
    theta = np.linspace(0.0, 2.0 * pi, count + 1)
    output = np.empty((count + 1, len(slopes)))
    output[-1] = 0.0
    for _ in range(8):
        output[0] = output[-1]
        for k in range(1, count + 1):
            step = np.sin(theta[k]) - output[k - 1]
            bound = slopes * theta[1]
            output[k] = output[k - 1] + np.minimum(np.maximum(step, -bound), bound)
    slow = slopes > 0.1  # the others settle later
    expected = [harmonic(theta, column) for column in output[:, slow].T]
    found = describing_function(LIMITER, np.array(LOADS)[slow], 1.0).response
    np.testing.assert_allclose(found, expected, rtol=0, atol=4e-4)


def test_rate_limiter_is_one_up_to_the_bound():
    found = describing_function(LIMITER, [1e-9, 0.5, 1.0], 1.0)
    assert found.response.tolist() == [1.0, 1.0, 1.0]
    assert found.gain_db.tolist() == [0.0, 0.0, 0.0]


def test_a_triangle_wave_in_closed_form():
    load = np.array([1.863, 3.0, 1e3, 1e9])
    found = describing_function(LIMITER, load, 1.0)
    np.testing.assert_allclose(found.gain_db, 20.0 * np.log10(4.0 / (pi * load)), atol=1e-12)
    np.testing.assert_allclose(found.phase_deg, -np.degrees(np.arccos(pi / (2.0 * load))))


def test_the_regimes_meet():
    for edge in (1.0, TRIANGLE):
        below, above = describing_function(
            LIMITER, edge * np.array([1 - 1e-9, 1 + 1e-9]), 1.0
        ).response
        assert abs(above - below) < 1e-8


def test_the_rate_limiter_of_python_control():
    """Its describing function of a callable with memory: samples of the sine, one by one."""
    count = 4000

    class Limiter:
        def __init__(self, bound):
            self.bound, self.output = bound, 0.0

        def __call__(self, command):
            step = command - self.output
            self.output += min(max(step, -self.bound), self.bound)
            return self.output

    for load in (0.9, 1.2, 1.7, 2.5):
        limiter = Limiter(2.0 * pi / count)
        for _ in range(3):  # it starts where the last call left it
            theirs = control.describing_function(limiter, load, num_points=count, zero_check=False)
        ours = describing_function(LIMITER, load, 1.0).response
        assert abs(theirs - ours) < 2e-3, load


# Followers


@pytest.mark.parametrize("with_velocity", [False, True], ids=["position", "velocity"])
@pytest.mark.parametrize(
    "bounds", [(0.3, 5.0), (0.7, 1.5), (0.05, 1.0), (3.0, 0.3), (5.0, 3.0), (0.9, 40.0)], ids=str
)
def test_followers_by_simulation(bounds, with_velocity):
    limits = Limits(*bounds)
    follower = CommandFollower(limits, dt=2.0 * pi / 64)
    expected = simulated(follower, settle=200, with_velocity=with_velocity)
    found = describing_function(follower, 1.0, 1.0, command_velocity=with_velocity)
    assert abs(found.response - expected) < 1e-4
    given = describing_function(
        limits, 1.0, 1.0, command_velocity=with_velocity, samples_per_period=64
    )
    assert abs(given.response - found.response) < 1e-10


@pytest.mark.parametrize("with_velocity", [False, True], ids=["position", "velocity"])
def test_third_order_by_simulation(with_velocity):
    follower = CommandFollower(Limits(0.7, 1.5, 20.0), dt=2.0 * pi / 32)
    expected = simulated(follower, settle=6, with_velocity=with_velocity)
    found = describing_function(follower, 1.0, 1.0, command_velocity=with_velocity)
    assert abs(found.response - expected) < 1e-4


def test_behind_a_jerk_filter_by_simulation():
    follower = CommandFollower(Limits(0.7, 1.5), dt=2.0 * pi / 32, jerk_filter=JerkFilter(0.4, 3))
    expected = simulated(follower, settle=20, periods=5)
    assert abs(describing_function(follower, 1.0, 1.0).response - expected) < 1e-4


def test_the_follower_of_python_control():
    """Its harmonic of the samples, which are those at the ends."""
    count = 400
    follower = CommandFollower(Limits(0.5, 1.2), dt=2.0 * pi / count)
    state = [0.0, 0.0]

    def output(command):
        state[:] = follower.step(state, command)[:2]
        return state[0]

    for _ in range(4):
        theirs = control.describing_function(output, 1.0, num_points=count, zero_check=False)
    ours = describing_function(follower, 1.0, 1.0).response
    assert abs(theirs * np.exp(-2j * pi / count) - ours) < 1e-4


def test_bang_bang_in_closed_form():
    """Parabolas: |N| = 4α/π whatever the sampling, the phase as with ever more samples."""
    power = np.array([1e-4, 0.05, 0.3, 0.6])
    expected = np.arcsin(pi**2 / 8.0 * power) - pi
    off = []
    for count in (128, 512):
        found = np.array(
            [
                describing_function(
                    Limits(velocity=2.0, acceleration=a), 1.0, 1.0, samples_per_period=count
                ).response
                for a in power
            ]
        )
        np.testing.assert_allclose(np.abs(found), 4.0 * power / pi, rtol=1e-9)
        off.append(np.abs(found / (np.abs(found) * np.exp(1j * expected)) - 1.0).max())
    assert off[0] < 2.0 * pi / 128
    assert off[1] < 2.0 * pi / 512


def test_nothing_lags_within_the_bounds_where_the_velocity_is_commanded():
    limits, sizes = Limits(velocity=2.0, acceleration=2.0), np.array([0.1, 0.4, 0.9])
    for count in (64, 256):
        found = describing_function(
            limits, sizes, 1.0, command_velocity=True, samples_per_period=count
        )
        assert np.abs(found.response - 1.0).max() < 40.0 / count**2


@pytest.mark.parametrize("with_velocity", [False, True], ids=["position", "velocity"])
def test_twice_the_samples_change_little(with_velocity):
    """As the docstring says: within 7/n of the limit, so that n and 2n differ by less."""
    sizes, omega = np.geomspace(0.2, 5.0, 5)[:, None], np.geomspace(0.3, 6.0, 8)
    coarse, fine = (
        describing_function(
            Limits(1.0, 2.0), sizes, omega, command_velocity=with_velocity, samples_per_period=n
        ).response
        for n in (128, 256)
    )
    assert np.abs(coarse - fine).max() < 7.0 / 128
    assert np.abs(coarse - fine).max() > 1e-4


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_units_do_not_matter(scale):
    """A length unit, then a time unit: N depends on ratios of bounds to the sine's own alone."""
    sizes, omega = np.array([[0.3], [1.0], [3.0]]), np.array([0.4, 1.1, 2.3])
    for bounds in ([1.0], [1.0, 2.0]):
        expected = describing_function(Limits(*bounds), sizes, omega).response
        longer = Limits(*(scale * bound for bound in bounds))
        slower = Limits(*(bound / scale**k for k, bound in enumerate(bounds, start=1)))
        for found in (
            describing_function(longer, scale * sizes, omega),
            describing_function(slower, sizes, omega / scale),
        ):
            np.testing.assert_allclose(found.response, expected, rtol=0, atol=2e-11)


def test_a_follower_is_told_at_frequencies_of_whole_periods():
    follower = CommandFollower(Limits(1.0, 2.0), dt=0.01)
    omega = np.array([0.5, 1.234, 7.7])
    found = describing_function(follower, 0.8, omega)
    halves = pi / (found.omega * follower.dt)
    np.testing.assert_allclose(halves, np.rint(halves), rtol=1e-13)
    assert np.abs(found.omega / omega - 1.0).max() < 0.5 / halves.min()
    for i, half in enumerate(np.rint(halves)):
        alone = describing_function(
            follower.limits, 0.8, found.omega[i], samples_per_period=int(2 * half)
        )
        assert abs(alone.response - found.response[i]) < 1e-10


def test_sweeps_are_their_points():
    sizes, omega = np.array([0.3, 1.0, 4.0]), np.array([0.5, 2.0])
    for shaper in (LIMITER, Limits(1.0, 2.0), CommandFollower(Limits(1.0, 2.0), dt=0.05)):
        swept = describing_function(shaper, sizes[:, None], omega)
        assert swept.response.shape == swept.amplitude.shape == swept.omega.shape == (3, 2)
        assert "(3, 2)" in repr(swept)
        for i, size in enumerate(sizes):
            for j, frequency in enumerate(omega):
                alone = describing_function(shaper, size, frequency)
                assert alone.response.shape == ()
                assert abs(alone.response - swept.response[i, j]) < 1e-9
        with pytest.raises(ValueError, match="read-only"):
            swept.response[0, 0] = 0.0


def test_many_points_are_as_few():
    """Points together and one by one take different ways."""
    sizes, omega = np.geomspace(0.1, 10.0, 12)[:, None], np.geomspace(0.2, 5.0, 12)
    limits = Limits(1.0, 2.0)
    many = describing_function(limits, sizes, omega, samples_per_period=64)
    few = [
        describing_function(limits, size, omega, samples_per_period=64).response for size in sizes
    ]
    np.testing.assert_allclose(many.response, few, rtol=0, atol=1e-9)


def test_phases_of_shapers_lag():
    found = describing_function(Limits(2.0, 0.001), 1.0, 1.0, samples_per_period=8)
    assert -270.0 < found.phase_deg < -90.0


def test_nothing_swept():
    for shaper in (LIMITER, Limits(1.0, 2.0)):
        assert describing_function(shaper, [], []).response.shape == (0,)


def test_a_motion_that_is_not_found_is_an_error(monkeypatch):
    monkeypatch.setattr(periodic, "_TURNS", 1)
    with pytest.raises(RuntimeError, match=r"2 of 2 points.* of 0.667, 0.444 times"):
        describing_function(Limits(1.0, 1.0), [1.0, 2.0], 1.5, samples_per_period=8)


# One period


def test_the_period_of_a_rate_limiter():
    for load in LOADS:
        period = periodic_response(LIMITER, 2.0, 0.5 * load)
        theta = 0.5 * load * period.time
        assert period.time[[0, -1]] == pytest.approx([0.0, 4.0 * pi / load])
        np.testing.assert_allclose(period.command, 2.0 * np.sin(theta), atol=1e-14)
        assert np.abs(np.diff(period.output)).max() <= (1.0 + 1e-9) * period.time[1]
        np.testing.assert_allclose(period.output[512:], -period.output[:513], atol=1e-13)
        found = describing_function(LIMITER, 2.0, 0.5 * load).response
        assert abs(harmonic(theta, period.output / 2.0) - found) < 1e-5


@pytest.mark.parametrize("bounds", [(1.0, 2.0), (1.0, 2.0, 30.0)], ids=["order 2", "order 3"])
def test_the_period_of_a_follower(bounds):
    limits = Limits(*bounds)
    period = periodic_response(limits, 1.5, 1.3, samples_per_period=64)
    assert repr(period) == "PeriodicResponse(points=65, period=4.83322)"
    follower = CommandFollower(limits, dt=period.time[1])
    run = follower.run(np.tile(period.command[:-1], 5))
    last = run.states[0, -64:]  # from rest, and so with an offset
    np.testing.assert_allclose(last - last.mean(), period.output[1:], atol=1e-9)
    assert period.output[0] == period.output[-1]


def test_the_period_behind_a_jerk_filter_is_refused():
    follower = CommandFollower(Limits(1.0, 2.0), dt=0.1, jerk_filter=JerkFilter(1.0, 2))
    with pytest.raises(ValueError, match="without it"):
        periodic_response(follower, 1.0, 1.0)
