"""Names and numbers of derivatives."""

import numpy as np
import pytest

from jounce.shaping.derivatives import DERIVATIVE_NAMES, derivative_name, derivative_number


def test_names_are_the_fields_own_in_order():
    assert DERIVATIVE_NAMES == (
        "position", "velocity", "acceleration", "jerk", "snap", "crackle", "pop",
    )  # fmt: skip


@pytest.mark.parametrize("number", range(10))
def test_number_and_name_agree(number):
    assert derivative_number(number) == number
    name = derivative_name(number)
    assert name == (DERIVATIVE_NAMES[number] if number < 7 else f"derivative {number}")
    if number < 7:
        assert derivative_number(name) == number


def test_numpy_integers_are_numbers():
    assert derivative_number(np.int64(3)) == 3


@pytest.mark.parametrize("name", ["speed", "Jerk", "", "derivative 7"])
def test_unknown_name_is_refused_with_the_known_ones(name):
    with pytest.raises(ValueError, match=f"unknown derivative '{name}'.*velocity.*pop"):
        derivative_number(name)


def test_negative_number_is_refused():
    with pytest.raises(ValueError, match="derivative -1: expected 0"):
        derivative_number(-1)


@pytest.mark.parametrize("value", [1.0, None, [1]])
def test_what_is_no_whole_number_is_refused(value):
    with pytest.raises(TypeError):
        derivative_number(value)
