"""Steady answers of rate limiters and followers to a sine: what repeats, and its first harmonic.

In units of the sine: amplitude 1, angle θ = ωt for time, bounds L_k/(A·ω^k) on derivative k.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from ...shaping import CommandFollower, Limits

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...shaping.pieces import FloatArray

    ComplexArray = NDArray[np.complex128]
    Counts = NDArray[np.intp]
    Pieces = list[tuple[FloatArray, FloatArray, FloatArray]]

TRIANGLE = float(np.hypot(1.0, 0.5 * pi))
"""A·ω/V from which on the output of a rate limiter is a triangle wave: √(1 + π²/4) = 1.862."""

REPEATS = 1e-11
"""Half periods repeat when their ends differ by less than this part of the output's size."""

_TURNS, _SIMPLE = 100, 8  # half periods, and those without a secant; 4 or so are needed
_COARSE = 64  # samples per period that tell about where a fine follower goes
_FEW = 100  # points that are faster one by one
_THERE = 2.0**-50
_NEWTON_STEPS = 6  # 4 suffice
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


# The rate limiter


def ramp_angles(slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the angles at which a rate limiter begins to lag behind the rising sine and meets it.

    For V/(A·ω) = slope < 1 it leaves the sine at −arccos(slope), where that becomes too fast, and
    meets it where sin θ = sin θ₀ + slope·(θ − θ₀). Were that after π − arccos(slope), it would be
    too late to follow the sine at all: a triangle wave, which turns at π − arcsin(π·slope/2).
    """
    slope = np.minimum(slope, 1.0)
    begin = np.arccos(slope)
    end = np.minimum(pi - begin, 2.2 * begin)
    for _ in range(_NEWTON_STEPS):
        missing = np.sin(end) + np.sin(begin) - slope * (end + begin)
        fall = slope - np.cos(end)
        end = end + np.divide(missing, fall, out=np.zeros_like(end), where=fall > 0.0)
    turn = pi - np.arcsin(np.minimum(0.5 * pi * slope, 1.0))
    triangle = slope * TRIANGLE <= 1.0
    return np.where(triangle, turn - pi, -begin), np.where(triangle, turn, end)


def rate_limited_harmonic(slope: FloatArray) -> ComplexArray:
    """Return the describing function of a rate limiter, V/(A·ω) = slope.

    The lag y − r has the rate slope − cos θ on the ramp, and is zero elsewhere:

        N = 1 + (2/π)·∫ (slope − cos θ)·e^(−jθ) dθ,

    and of the triangle wave N = (4/π)·slope·e^(−j·arccos(π·slope/2)).
    """
    begin, end = ramp_angles(slope)
    slope = np.minimum(slope, 1.0)
    once = np.exp(-1j * end) - np.exp(-1j * begin)
    twice = np.exp(-2j * end) - np.exp(-2j * begin)
    partly = 1.0 + (2.0 / pi) * (1j * slope * once - 0.5 * (end - begin) - 0.25j * twice)
    level = np.minimum(0.5 * pi * slope, 1.0)
    fully = (4.0 / pi) * slope * (level - 1j * np.sqrt(1.0 - level * level))
    found: ComplexArray = np.where(slope * TRIANGLE <= 1.0, fully, partly)
    found[slope >= 1.0] = 1.0
    return found


def rate_limited(theta: FloatArray, slope: float) -> FloatArray:
    """Return the output of a rate limiter at angles θ."""
    [begin], [end] = ramp_angles(np.array([slope]))
    turns = np.floor((theta - begin) / pi)
    ahead = theta - turns * pi  # in the half period that begins with the ramp
    ramp = np.sin(begin) + slope * (ahead - begin)
    return np.asarray(np.where(turns % 2.0, -1.0, 1.0) * np.where(ahead < end, ramp, np.sin(ahead)))


# Followers


def follower_cycle(
    bounds: FloatArray, counts: Counts, with_velocity: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the states in which followers begin each period, and how nearly they do.

    Half a period maps the state to a mirror image, of which a fixed point is sought. Offsets that
    die away slowly change their sign from one half period to the next, so that halfway to
    the image there is little left of them: image and halfway in turns, and for the few that
    this leaves halfway with a secant through the last two turns (Anderson's mixing).

    Parameters
    ----------
    bounds : (order, M) array
    counts : (M,) array
        Samples per period, even, the largest first.
    with_velocity : bool
        Whether the velocity is commanded, too.

    Returns
    -------
    (order, M) array
        At θ = 0.
    (M,) array
        Difference to the image, over the size of the output.
    """
    states = np.zeros_like(bounds)
    if counts.max(initial=0) >= 8 * _COARSE:
        states, _ = follower_cycle(bounds, np.maximum(counts // 16 * 2, _COARSE), with_velocity)
    nearest, left = np.full(bounds.shape[1], np.inf), np.arange(bounds.shape[1])
    size = np.minimum(bounds.min(axis=0), 1.0)
    now = before = off = states.copy()
    for turn in range(_TURNS):
        last, off = off, -_half(now, bounds[:, left], counts[left], with_velocity) - now
        apart = np.abs(off).max(axis=0) / size[left]
        nearer = apart < nearest[left]
        states[:, left[nearer]], nearest[left[nearer]] = now[:, nearer], apart[nearer]
        some = ~(apart < REPEATS)
        if not some.any():
            break
        then = (
            _mixed(now, off, before, last) if turn > _SIMPLE else now + (1.0 - turn % 2 / 2) * off
        )
        now, before, off, left = then[:, some], now[:, some], off[:, some], left[some]
    return states, nearest


def _half(
    states: FloatArray, bounds: FloatArray, counts: Counts, with_velocity: bool
) -> FloatArray:
    """Return the states half a period after θ = 0."""
    if len(bounds) == 2 and len(counts) > _FEW:
        return second_order_half(states, bounds, counts, with_velocity)
    ends = [
        follower_states(*each, with_velocity)[:, -1]
        for each in zip(states.T, bounds.T, counts.tolist(), strict=True)
    ]
    return np.array(ends).T


def _mixed(
    now: FloatArray, off: FloatArray, before: FloatArray, off_before: FloatArray
) -> FloatArray:
    """Return the next states from the last two and what they are off by."""
    change = off - off_before
    square = np.maximum((change * change).sum(axis=0), np.finfo(float).tiny)
    back = np.clip((change * off).sum(axis=0) / square, -1.0, 1.0)
    return np.asarray(now + 0.5 * off - back * (now - before + 0.5 * change))


def follower_harmonic(
    states: FloatArray, bounds: FloatArray, counts: Counts, with_velocity: bool
) -> ComplexArray:
    """Return the describing functions of followers from their states at θ = 0.

    N = (2/π)·∫ v·e^(−jθ) dθ over half a period, piece by piece.
    """
    total = np.zeros(states.shape[1], dtype=np.complex128)
    if len(bounds) == 2:
        second_order_half(states, bounds, counts, with_velocity, total)
    else:
        for i, count in enumerate(counts.tolist()):
            total[i] = _third_order_moment(states[:, i], bounds[:, i], count, with_velocity)
    total *= 2.0 / pi
    return total


def second_order_half(
    states: FloatArray,
    bounds: FloatArray,
    counts: Counts,
    with_velocity: bool,
    total: ComplexArray | None = None,
) -> FloatArray:
    """Return the states (2, M) half a period after θ = 0: CommandFollower.run on arrays.

    Adds ∫ v·e^(−jθ) dθ to `total`, if given.
    """
    (x, v), (speed, power) = states.copy(), bounds
    step, halves = 2.0 * pi / counts, counts // 2
    for k in range(int(halves.max(initial=0))):
        m = int(np.count_nonzero(halves > k))
        theta, dt, top = step[:m] * k, step[:m], speed[:m]
        r = np.sin(theta)
        u = np.clip(np.cos(theta), -top, top) if with_velocity else np.zeros(m)
        x[:m], v[:m], pieces = _sample((x[:m], v[:m]), (r, u), (top, power[:m]), dt)
        if total is not None:
            for begin, end, duration in pieces:
                total[:m] += _moment(begin, end, duration, theta)
                theta = theta + duration
    return np.array([x, v])


def _sample(
    state: tuple[FloatArray, FloatArray],
    command: tuple[FloatArray, FloatArray],
    bounds: tuple[FloatArray, FloatArray],
    dt: FloatArray,
) -> tuple[FloatArray, FloatArray, Pieces]:
    """Return position and velocity a sample later, and velocities and duration of its pieces.

    As `second_order.follow`: speed up to a peak, cruise, slow down and stay at the command.
    """
    (x, v), (r, u), (speed, power) = state, command, bounds
    e, w = x - r, v - u
    beyond = e + 0.5 * w * np.abs(w) / power  # where it would stop
    ahead = np.where(np.abs(beyond) <= _THERE, np.sign(w), -np.sign(beyond))
    w, top = ahead * w, speed - ahead * u
    gain = np.abs(beyond) * power + w * np.maximum(w, 0.0)
    peak = np.minimum(np.sqrt(gain), top)
    rise, fall = np.maximum(peak - w, 0.0) / power, peak / power
    cruise = np.full_like(w, np.inf)
    np.divide(np.maximum(gain - peak * peak, 0.0), power * top, out=cruise, where=top > 0.0)
    first = np.minimum(rise, dt)
    second = np.minimum(cruise, dt - first)
    left = dt - first - second
    third = np.minimum(fall, left)
    higher = np.where(first < rise, w + power * first, peak)
    last = np.where(third < fall, higher - power * third, np.minimum(higher, 0.0))
    gone = 0.5 * (w + higher) * first + higher * second + 0.5 * (higher + last) * third
    begin, top, end = u + ahead * w, u + ahead * higher, u + ahead * last
    x = u * dt + np.where(fall < left, r, x + ahead * gone)
    pieces = [(begin, top, first), (top, top, second), (top, end, third), (u, u, left - third)]
    return x, end, pieces


def _moment(
    begin: FloatArray, end: FloatArray, duration: FloatArray, theta: FloatArray
) -> ComplexArray:
    """Return ∫ v·e^(−jθ) dθ of a velocity that changes linearly, over less than a radian."""
    p = 0.5 * duration
    q = p * p
    even = (begin + end) * p * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0)))
    odd = (end - begin) * q / 3.0 * (1.0 - q / 10.0 * (1.0 - q / 28.0 * (1.0 - q / 54.0)))
    return np.asarray(np.exp(-1j * (theta + p)) * (even - 1j * odd))


def sine_commands(count: int, with_velocity: bool) -> tuple[FloatArray, FloatArray]:
    """Return commands and their velocities of the samples in the first half period."""
    theta = np.arange(count // 2) * (2.0 * pi / count)
    return np.sin(theta), np.cos(theta) if with_velocity else np.zeros_like(theta)


def follower_states(
    state: FloatArray, bounds: FloatArray, count: int, with_velocity: bool
) -> FloatArray:
    """Return the states (order, count/2 + 1) at the samples of the first half period."""
    return _sampled(state, bounds, count, with_velocity)[1]


def _sampled(
    state: FloatArray, bounds: FloatArray, count: int, with_velocity: bool
) -> tuple[CommandFollower, FloatArray]:
    """Return a follower, and its states at the samples of the first half period."""
    follower = CommandFollower(Limits.from_bounds(bounds.tolist()), dt=2.0 * pi / count)
    commands, velocities = sine_commands(count, with_velocity)
    run = follower.run(commands, command_velocities=velocities, initial=state.tolist())
    return follower, np.hstack([state[:, None], run.states[: len(state)]])


def _third_order_moment(
    state: FloatArray, bounds: FloatArray, count: int, with_velocity: bool
) -> complex:
    """Return ∫ v·e^(−jθ) dθ over half a period."""
    follower, states = _sampled(state, bounds, count, with_velocity)
    dt, rows = 2.0 * pi / count, []
    for k, (begin, r, u) in enumerate(
        zip(states.T.tolist(), *sine_commands(count, with_velocity), strict=False)
    ):
        motion = follower.motion(begin, float(r), float(u))
        for start, duration, row in zip(
            motion.breaks, motion.durations, motion.states, strict=False
        ):
            rows.append((k * dt + start, duration, *row[1:]))
    return _moment_of_pieces(np.array(rows).T)


def _moment_of_pieces(pieces: FloatArray) -> complex:
    """Return ∫ v·e^(−jθ) dθ over pieces: start, duration, velocity, acceleration and jerk."""
    theta, duration, v, a, j = (row[:, None] for row in pieces)
    inside = 0.5 * duration * (1.0 + _NODES)
    velocity = v + inside * (a + 0.5 * inside * j)
    return complex((0.5 * duration * _WEIGHTS * velocity * np.exp(-1j * (theta + inside))).sum())
