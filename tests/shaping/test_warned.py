"""Warnings point at the caller's own line, however deep, and say of what they are."""

import warnings
from threading import Thread

import pytest

from jounce.shaping import Limits, min_time_move
from jounce.shaping.warned import untold, warn_caller, warned_of

HIGH = Limits.from_bounds([1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0, 34.0, 55.0, 89.0, 144.0])


@pytest.mark.parametrize("depth", [0, 1, 3])
def test_the_line_is_that_outside_the_package(depth):
    inside = {"__name__": "jounce.somewhere", "call": warn_caller}
    for _ in range(depth):
        exec("def deeper(message, call=call): call(message)\ncall = deeper", inside)
    with pytest.warns(RuntimeWarning, match="known") as told:
        inside["call"]("this is known")
    assert [warning.filename for warning in told] == [__file__]


def test_a_move_tells_of_its_caller():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        move = min_time_move(1.0, HIGH)
    assert move.duration > 0.0
    assert {warning.filename for warning in told} == {__file__}


def told_within(contexts):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        contexts()
    return [(str(each.message), each.category) for each in told]


def test_what_a_warning_is_of_stands_in_front_and_kinds_are_left_out():
    def contexts():
        with warned_of("a.toml"), untold(UserWarning):
            with warned_of("move 'up'"):
                warn_caller("slow")
                warn_caller("near", UserWarning)
            warn_caller("late")
        warn_caller("near", UserWarning)

    assert told_within(contexts) == [
        ("a.toml: move 'up': slow", RuntimeWarning),
        ("a.toml: late", RuntimeWarning),
        ("near", UserWarning),
    ]


def test_what_one_thread_leaves_out_another_tells():
    def contexts():
        with untold(), warned_of("here"):
            other = Thread(target=warn_caller, args=("there",))
            other.start()
            other.join()
            warn_caller("nothing")

    assert told_within(contexts) == [("there", RuntimeWarning)]
