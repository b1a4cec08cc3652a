"""Checks of a caller's numbers: what passes, and what the error says."""

from fractions import Fraction
from math import exp, inf, ldexp, nan

import numpy as np
import pytest

from jounce.shaping.checks import finite, in_range, positive, whole

TINY, HUGE = 5e-324, 1.7976931348623157e308


@pytest.mark.parametrize("check", [finite, positive])
@pytest.mark.parametrize("value", [3, 3.0, np.float64(3.5), np.int32(3), Fraction(3), np.array(3)])
def test_numbers_of_any_kind_come_back_as_floats(check, value):
    result = check("speed", value)
    assert type(result) is float
    assert result == value


@pytest.mark.parametrize("value", [0.0, -1.5, TINY, -HUGE, HUGE])
def test_finite_accepts_every_double(value):
    assert finite("place", value) == value


@pytest.mark.parametrize("value", [TINY, 1e-300, HUGE])
def test_positive_accepts_the_ends_of_the_range(value):
    assert positive("gap", value) == value


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_finite_refuses_with_name_value_and_remedy(value):
    with pytest.raises(ValueError, match=r"^place = .*(nan|inf).*: expected a finite number$"):
        finite("place", value)


@pytest.mark.parametrize("value", [0, 0.0, -0.0, -TINY, -3, nan, inf, -inf])
def test_positive_refuses_with_name_value_and_remedy(value):
    with pytest.raises(ValueError, match=r"^gap = .*: expected a positive, finite number$") as info:
        positive("gap", value)
    assert repr(value).replace("-0.0", "0.0") in str(info.value)


@pytest.mark.parametrize("check", [finite, positive])
@pytest.mark.parametrize("value", ["fast", None, [1.0, 2.0], 1j, True])
def test_what_is_no_number_is_refused(check, value):
    with pytest.raises((TypeError, ValueError)):
        check("speed", value)


@pytest.mark.parametrize("value", [2, 5, np.int64(3), np.uint8(4)])
def test_whole_returns_an_int_within_its_ends(value):
    result = whole("count", value, 2, 5)
    assert type(result) is int
    assert result == value


@pytest.mark.parametrize("value", [1, 6, -3, 3.0, 2.5, nan, inf, "3", None, np.float64(4), True])
def test_whole_refuses_with_name_value_and_range(value):
    message = r"^count = .*: expected a whole number from 2 to 5$"
    with pytest.raises(ValueError, match=message) as info:
        whole("count", value, 2, 5)
    assert str(value) in str(info.value)


@pytest.mark.parametrize("result", [3.5, None, [1, 2], inf, nan])
def test_in_range_returns_what_the_plan_returns(result):
    assert in_range(lambda: result) is result


def _overflow_of_numpy():
    with np.errstate(over="raise"):
        return np.float64(HUGE) * 2.0


OUT_OF_RANGE = {
    "of numpy": _overflow_of_numpy,
    "power": lambda: HUGE**2,
    "exponential": lambda: exp(1e3),
    "ldexp": lambda: ldexp(1.0, 10_000),
    "conversion": lambda: float(Fraction(10) ** 400),
}


@pytest.mark.parametrize("plan", OUT_OF_RANGE.values(), ids=OUT_OF_RANGE)
def test_in_range_tells_overflows_as_numbers_out_of_range(plan):
    message = (
        r"^the duration or a state leaves the range of a double: choose distance and time units "
        r"nearer to the problem's own$"
    )
    with pytest.raises(ValueError, match=message) as info:
        in_range(plan)
    assert isinstance(info.value.__cause__, ArithmeticError)


@pytest.mark.parametrize("error", [ValueError, TypeError, KeyError, ZeroDivisionError])
def test_in_range_lets_other_errors_through(error):
    def plan():
        raise error("as it was")

    with pytest.raises(error, match="as it was"):
        in_range(plan)
