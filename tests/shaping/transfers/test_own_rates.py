"""modify and append with rates of their own: every mixture, sampled; percents never exceeded."""

import numpy as np
import pytest
from references import replay

from jounce.shaping import Limits, s_curve_move, synchronize, velocity_move

RATES = ("velocity", "acceleration", "deceleration", "acceleration_jerk", "deceleration_jerk")
WAYS = [(None, "duration"), (0.35, "duration"), (0.8, "acceleration")]


def assert_rates(text, move, since, rates, rise, begun):
    """Assert the rates from a time on, at samples, but for what the start brings with it."""
    v, a, j = move.evaluate(np.linspace(since, move.end_time, 400)[:-1])[1:]
    v0, a0 = begun
    leads_to = abs(v0) + a0 * a0 / 2.0 / rates.get("acceleration_jerk", np.inf)
    if a0 * v0 >= 0.0:
        assert np.abs(v).max() <= max(rates["velocity"], leads_to) * (1.0 + 1e-9), text
    for name, now in (("acceleration", a * v > 1e-9), ("deceleration", a * v < -1e-9)):
        most = max(rates[name] / rise, abs(a0))
        assert np.abs(a[now]).max(initial=0.0) <= most * (1.0 + 1e-9), (text, name)
        jerk = rates.get(f"{name}_jerk", np.inf)
        assert np.abs(j[now]).max(initial=0.0) <= jerk * (1.0 + 1e-9), (text, name)


def assert_no_gap(text, move, percent):
    again = replay(move)
    for k in range(2 if percent is not None else 3):
        scale = max(np.abs(again.extremes[k]))
        assert again.gaps[k] <= 1e-9 * scale + 1e-12, (text, k)


@pytest.mark.parametrize(("percent", "keeps"), WAYS)
def test_every_mixture_of_rates_holds_from_then_on(percent, keeps):
    names = RATES if percent is None else RATES[:3]
    kind = {} if percent is None else {"jerk_percent": percent, "percent_keeps": keeps}
    rise = 1.0 - 0.5 * percent if percent is not None and keeps == "duration" else 1.0
    for seed in range(2 ** len(names) * 3):
        rng = np.random.default_rng((81, seed))
        rates = dict(zip(names, (10.0 ** rng.uniform(-1.0, 1.0, len(names))).tolist(),
                         strict=True))  # fmt: skip
        new = {
            name: float(10.0 ** rng.uniform(-1.0, 1.0))
            for bit, name in enumerate(names)
            if seed >> bit & 1
        }
        move = s_curve_move(float(3.0 * rng.normal()), **rates, **kind)
        target, relative = float(3.0 * rng.normal()), bool(rng.integers(2))
        time = float(rng.uniform(0.0, 1.1)) * move.duration
        text = f"{move!r} of {rates!r} {kind!r} at {time!r} to {target!r} by {new!r}"
        goal = target + (float(move.end_state[0]) if relative else 0.0)
        v, a = move.evaluate(time)[1:3].tolist()
        begun = (v, 0.0 if percent is not None else a)
        changed = move.modify(time, target=target, relative=relative, **new)
        longer = move.append(target, relative=relative, delay=0.5, **new)
        for motion, since, state in (
            (changed, time, begun),
            (longer, move.end_time + 0.5, (0.0, 0.0)),
        ):
            assert motion.end_state[0] == goal
            assert_no_gap(text, motion, percent)
            if motion.end_time > since:
                assert_rates(text, motion, since, {**rates, **new}, rise, state)


def test_a_percent_that_keeps_the_acceleration_never_exceeds_it_from_any_start():
    for seed in range(300):
        rng = np.random.default_rng((82, seed))
        velocity, up, down = (10.0 ** rng.uniform(-2.0, 2.0, 3)).tolist()
        ends = (velocity * rng.uniform(-1.0, 1.0, 2) * rng.integers(0, 2, 2)).tolist()
        percent = float(rng.choice([0.0, 1.0, rng.uniform()]))
        given = {"velocity": velocity, "acceleration": up, "deceleration": down}
        given |= {"percent_keeps": "acceleration", "start": (0.0, ends[0])}
        target = float(rng.normal() * 10.0 ** rng.uniform(-3.0, 3.0))
        move = s_curve_move(target, jerk_percent=percent, final_velocity=ends[1], **given)
        text = f"s_curve_move({target!r}, jerk_percent={percent!r}, {given!r}, to {ends[1]!r})"
        scale = 1e-9 * velocity * max(up, down)
        for duration, (_, v, a, j) in zip(move.durations, move.states, strict=True):
            t = np.linspace(0.0, duration, 9)
            power = (a + j * t) * (v + a * t + 0.5 * j * t * t)
            for now, most in ((power > scale, up), (power < -scale, down)):
                assert np.abs((a + j * t)[now]).max(initial=0.0) <= most * (1.0 + 1e-9), text
        if not any(ends):
            less = s_curve_move(target, jerk_percent=0.5 * percent, **given)
            assert less.duration <= move.duration * (1.0 + 1e-12), text


FOUR = {"acceleration": 8.0, "deceleration": 2.0, "acceleration_jerk": 40.0,
        "deceleration_jerk": 5.0}  # fmt: skip


def curve(size, target, **more):
    """Return a move with all numbers but times in another unit."""
    rates = {name: value * size for name, value in {**FOUR, "velocity": 4.0}.items()}
    return s_curve_move(target * size, **rates, **more)


SIZES = {
    "a start and an end that move": lambda s: curve(
        s, 10.0, start=(0.0, s, 0.5 * s), final_velocity=0.5 * s
    ),
    "a lowered velocity": lambda s: curve(s, 10.0).modify(1.0, velocity=0.4 * s),
    "a lowered velocity near the end": lambda s: curve(s, 1.0).modify(0.4, velocity=0.2 * s),
    "turning round": lambda s: curve(s, -1.0, start=(0.0, 3.0 * s, -1.5 * s)),
    "a velocity": lambda s: velocity_move(
        3.0 * s, **{name: value * s for name, value in FOUR.items()}, start=(0.0, -s, 0.3 * s)
    ),
    "axes": lambda s: synchronize(
        [curve(s, 3.0), (0.0, 4.0 * s, Limits(s, 2.0 * s, 8.0 * s))]
    ).modify(1.0, [6.0 * s, -8.0 * s]),
    "a line": lambda s: synchronize(
        [(0.0, 3.0 * s), (0.0, 4.0 * s)], "straight-line", resultant=curve(s, 5.0)
    ).modify(1.0, [0.0, 8.0 * s]),
}


@pytest.mark.parametrize("name", SIZES)
@pytest.mark.parametrize("exponent", [-900, -500, 500, 900])
def test_numbers_of_any_size_are_planned_alike(name, exponent):
    """In units of 2^±900 the squares of velocities and accelerations leave the range."""
    expected = SIZES[name](1.0).duration
    assert SIZES[name](2.0**exponent).duration == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("size", [2.0**-900, 2.0**900])
def test_remarks_and_the_nearest_target_too(size):
    assert curve(size, 10.0).remarks == ()
    [told] = curve(size, 10.0).modify(1.0, deceleration_jerk=0.5 * size).remarks
    assert told.startswith("deceleration_jerk = ")
    with pytest.raises(ValueError, match="takes a reversal") as caught:
        curve(size, 0.1, start=(0.0, 3.0 * size), no_reversal=True)
    with pytest.raises(ValueError, match="takes a reversal") as expected:
        curve(1.0, 0.1, start=(0.0, 3.0), no_reversal=True)
    assert caught.value.nearest == pytest.approx(expected.value.nearest * size)
