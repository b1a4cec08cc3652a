"""Problems without a motion: the bound, the time, and the nearest start or end that has one."""

import pickle
import re

import pytest

from jounce.shaping import InfeasibleError, Limits, min_time_transfer, through

EVEN = Limits(velocity=1.0, acceleration=1.0, jerk=1.0, snap=1.0)
STAGE = Limits(velocity=2.0, acceleration=1.0, jerk=4.0, snap=20.0, position=(0.0, 1.0))
SHORT = Limits(velocity=2.0, acceleration=1.0, jerk=2.0, position=(-1.0, 1.0))


def refused(start, end, limits):
    """Return the error, whose message names what its attributes hold."""
    with pytest.raises(InfeasibleError, match=r"no motion within the limits") as caught:
        min_time_transfer(start, end, limits)
    error = caught.value
    assert f"{error.bound} " in str(error)
    assert f"= {error.nearest!r}, the nearest" in str(error)
    assert error.nearest in error.state
    assert "\n" not in str(error)
    return error


@pytest.mark.parametrize(
    ("start", "end", "limits", "bound", "latest"),
    [
        ((0.0, 0.9, 0.5), 5.0, EVEN, "velocity", 0.22),  # 0.9 + 0.5 t − t³/6 = 1 but for snap
        ((0.5, 1.2), 0.0, SHORT, "position", 0.45),  # 0.5 + 1.2 t − t³/3 = 1
        (0.5, (0.1, 1.2), STAGE, "position", -0.084),  # about 0.1/1.2
        (0.0, (-0.95, 1.0), SHORT, "position", -0.0504),  # about 0.05
    ],
)
def test_a_dead_end_is_told_with_the_nearest_state_that_is_none(start, end, limits, bound, latest):
    error = refused(start, end, limits)
    at_end = error.time < 0.0
    assert error.bound == bound
    assert error.time == pytest.approx(latest, rel=0.08)
    assert f"about {abs(error.time):.3g} {'before' if at_end else 'after'} it" in str(error)
    given = end if at_end else start
    changed = [i for i, (a, b) in enumerate(zip(given, error.state, strict=False)) if a != b]
    assert len(changed) == 1

    def ending(value):
        state = [*error.state]
        state[changed[0]] = value
        return min_time_transfer(*((start, state) if at_end else (state, end)), limits)

    assert ending(error.nearest).violation(limits) <= 1e-12
    beyond = error.nearest + 0.04 * (given[changed[0]] - error.nearest)
    with pytest.raises(InfeasibleError):
        ending(beyond)


def test_no_way_back_is_told_with_the_nearest_end():
    limits = Limits(velocity=(-0.5, 2.0), acceleration=(-1.0, 1.0), jerk=2.0, snap=20.0)
    forward = Limits(velocity=(0.0, 2.0), acceleration=1.0, jerk=2.0, snap=20.0)
    error = refused(0.0, -1.0, forward)
    assert (error.bound, error.nearest, error.time) == ("velocity", 0.0, None)
    assert error.state == (0.0, 0.0, 0.0, 0.0)
    assert min_time_transfer(0.0, error.state, forward).duration == 0.0
    assert min_time_transfer(0.0, -1.0, limits).duration > 2.0


def test_too_near_to_stop_is_told_with_the_nearest_end():
    """From 0.5 it stops in 0.125 at the least, and in jerk/snap ramps later."""
    forward = Limits(velocity=(0.0, 2.0), acceleration=1.0, jerk=10.0, snap=200.0)
    with pytest.raises(InfeasibleError, match=r"there is no turning back: no motion") as caught:
        min_time_transfer((0.0, 0.5), 0.01, forward)
    error = caught.value
    start = error.state if error.time > 0.0 else (0.0, 0.5)
    end = error.state if error.time < 0.0 else 0.01
    there = min_time_transfer(start, end, forward)
    assert there.violation(forward) <= 1e-12


STOPS = Limits(velocity=1.0, acceleration=2.0, jerk=5.0, snap=40.0, position=(-0.1, 1.2))


@pytest.mark.parametrize(
    ("start", "end", "limits", "remedy"),
    [
        ((1.1, 0.9), 0.0, STOPS, r"position would exceed its bound 1\.2 .*; raise that bound"),
        ((-0.05, -0.9), 1.0, STOPS, r"would exceed its bound -0\.1 .*; lower that bound"),
        (0.0, (-0.05, 0.9), STOPS, r"would exceed its bound -0\.1 .*; lower that bound"),
        (0.0, -1.0, Limits((0.0, 1.0), 2.0, 5.0), "velocity bound 0 stands .*; lower it, or end"),
        (0.0, 1.0, Limits((-1.0, 0.0), 2.0, 5.0), "velocity bound 0 stands .*; raise it, or end"),
        (0.0, 1.0, Limits(None, (0.0, 2.0), 5.0), "never comes back to zero; lower that bound"),
        (0.0, -1.0, Limits(None, (-2.0, 0.0), 5.0), "never comes back to zero; raise that bound"),
        ((0.0, 0.5), 0.05, Limits((0.0, 1.0), 2.0), r"pass 0\.05, the end, .*; end further away"),
        (0.0, (0.05, 0.5), Limits((0.0, 1.0), 2.0), r"pass 0, the start, .*; start further away"),
    ],
    ids=str,
)
def test_the_remedy_widens_the_bound_that_stands_in_the_way(start, end, limits, remedy):
    with pytest.raises(InfeasibleError, match=remedy):
        min_time_transfer(start, end, limits)


def test_an_error_keeps_what_it_knows_through_pickling_and_axes():
    with pytest.raises(InfeasibleError, match=re.escape("from point [0.0, 0.0]")) as caught:
        through([[0.0, 0.0], [1.0, -1.0]], Limits(velocity=(0.0, 1.0), acceleration=1.0, jerk=2.0))
    error = caught.value
    again = pickle.loads(pickle.dumps(error))
    for name in ("bound", "nearest", "time", "state"):
        assert getattr(again, name) == getattr(error, name)
    assert str(again) == str(error)
    assert error.state is not None
