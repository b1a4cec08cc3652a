"""A velocity bound lowered under way: no turning round, and the least time, by ramps by hand."""

from math import sqrt

import numpy as np
import pytest
from references import replay
from tiers import some

from jounce.shaping import s_curve_move

SEEDS = range(400)


def ramp_down(v, a, low, rates):
    """Return (time, jerk) of the fastest change to a lower velocity kept, a > 0 to zero first."""
    ramp = []
    if a > 0.0:
        ramp.append((a / rates["acceleration_jerk"], -rates["acceleration_jerk"]))
        v, a = v + 0.5 * a * a / rates["acceleration_jerk"], 0.0
    most, jerk = rates["deceleration"], rates["deceleration_jerk"]
    peak = min(most, sqrt(jerk * (v - low) + 0.5 * a * a))
    held = (v - low - (peak**2 - 0.5 * a * a) / jerk) / most if peak == most else 0.0
    return [*ramp, ((peak + a) / jerk, -jerk), (held, 0.0), (peak / jerk, jerk)]


def taken(ramp, v, a):
    """Return distance and time of a ramp."""
    x = 0.0
    for time, jerk in ramp:
        x += time * (v + time * (a / 2.0 + time * jerk / 6.0))
        v, a = v + time * (a + time * jerk / 2.0), a + time * jerk
    return x, sum(time for time, _ in ramp)


def by_way_of(low, state, rates):
    """Return distance and time of slowing down to a velocity, and from there to rest."""
    first = taken(ramp_down(*state, low, rates), *state)
    last = taken(ramp_down(low, 0.0, 0.0, rates), low, 0.0)
    return first[0] + last[0], first[1] + last[1]


def lowered(seed):
    """Return rates, state, distance left and lowered bound, and what is planned from there."""
    rng = np.random.default_rng((31, seed))
    names = "velocity", "acceleration", "deceleration", "acceleration_jerk", "deceleration_jerk"
    rates = dict(zip(names, (10.0 ** rng.uniform(-1.0, 1.0, 5)).tolist(), strict=True))
    if seed % 2:
        rates["deceleration"], rates["deceleration_jerk"] = list(rates.values())[1:4:2]
    move = s_curve_move(float(10.0 ** rng.uniform(-2.0, 1.0)), **rates)
    last = move.duration
    time = float(rng.uniform()) * last * (1.0 - 1e-9)
    bound = float(move.peak(1) * 10.0 ** rng.uniform(-2.0, 0.0))
    x, v, a, _ = move.evaluate(time).tolist()
    changed = move.modify(time, velocity=bound)
    return rates, (v, a), move.end_state[0] - x, bound, changed, time


@pytest.mark.parametrize("part", some(range(4), 2))
def test_it_never_turns_round_and_takes_the_least_time(part):
    levelled = near = 0
    for seed in SEEDS[part::4]:
        rates, state, left, bound, changed, time = lowered(seed)
        text = f"seed {seed}: {rates}, {state} with {left} left, lowered to {bound}"
        assert replay(changed).extremes[1][0] >= -1e-9 * rates["velocity"], text
        v, a = state
        settling = v + a * abs(a) / 2.0 / rates[("de" if a < 0.0 else "ac") + "celeration_jerk"]
        if settling <= bound:
            continue
        distance, least = by_way_of(bound, state, rates)
        took = changed.end_time - time
        if distance <= left:  # down to the bound, along at it, and to rest
            least += (left - distance) / bound
            assert took == pytest.approx(least, rel=1e-9, abs=1e-9 * changed.duration), text
            levelled += 1
            continue
        near += 1
        # too near: no slower than by the highest of many lower velocities that leads no further
        lower = [by_way_of(low, state, rates) for low in np.linspace(0.0, bound, 400)]
        ways = [(left - way[0]) / low + way[1] for low, way in
                zip(np.linspace(0.0, bound, 400)[1:], lower[1:], strict=True)
                if way[0] <= left]  # fmt: skip
        assert took <= min(ways, default=np.inf) * (1.0 + 1e-9), text
    assert levelled > 20
    assert near > 20


@pytest.mark.parametrize("target", np.linspace(8.68, 9.6, 9))
def test_two_rates_that_hardly_differ_plan_as_one_where_the_target_is_near(target):
    rates = {"velocity": 0.46, "acceleration": 5.4, "acceleration_jerk": 0.162}
    start = (5.9534701799027, 1.062482477123876)
    one, two = (
        s_curve_move(float(target), **rates, start=start, deceleration=5.4 * more)
        for more in (1.0, 1.0 + 1e-12)
    )
    assert two.duration == pytest.approx(one.duration, rel=1e-6)


@pytest.mark.parametrize("percent", [0.0, 0.4, 1.0])
def test_by_jerk_percent_it_slows_to_rest_without_turning_round(percent):
    """Any velocity on the way takes the same distance, v²/2D: the edge on which rounding lies."""
    for share in np.linspace(0.02, 0.98, 25):
        move = s_curve_move(3.0, velocity=2.0, acceleration=4.0, jerk_percent=percent)
        changed = move.modify(move.duration - 0.5, velocity=float(share))  # it begins to slow down
        assert changed.extremes(1)[0] >= -1e-9
        assert changed.end_state.tolist() == [3.0, 0.0, 0.0, 0.0]
