"""What the margins of a loop are as a result, and what is refused."""

import dataclasses
import json
import math

import control
import numpy as np
import pytest
from one_loops import S, exact_pid, pid_loop

from jounce.analysis.margins import LoopMargins, loop_margins


def test_result_is_frozen_json_able_and_reads_as_text():
    margins = loop_margins(pid_loop(*exact_pid()))
    assert isinstance(margins, LoopMargins)
    with pytest.raises(ValueError, match="read-only"):
        margins.closed_loop_poles[0] = 0
    with pytest.raises(AttributeError):
        margins.stable = False
    plain = json.loads(json.dumps(margins.as_dict(), allow_nan=False))
    assert list(plain) == [field.name for field in dataclasses.fields(LoopMargins)]
    assert plain["upper_gain_margin_db"] is None
    assert plain["crossovers_hz"] == list(margins.crossovers_hz)
    assert plain["closed_loop_poles"][0] == [margins.closed_loop_poles[0].real, 0]
    assert "phase margin             45 deg at 1 Hz" in margins.summary()
    assert "upper gain margin        inf dB\n" in str(margins)


@pytest.mark.parametrize(
    ("system", "error", "message"),
    [
        (control.ss(-np.eye(2), np.eye(2), np.eye(2), 0), ValueError, "2 inputs and 2 outputs"),
        (control.tf([1], [1, 0.5], True), ValueError, "dt = True names no sampling time"),
        (control.tf([1, 0, 0], [1, 0.5], 0.1), ValueError, "2 zeros and 1 poles"),
        (control.frd([1, 1j], [1, 2]), ValueError, "response of 2 lines: expected 8"),
        (3.0, TypeError, "system is a float"),
        (control.tf([math.inf], [1, 1]), ValueError, "nan or inf"),
        (control.ss([[math.nan]], [[1]], [[1]], 0), ValueError, "nan or inf"),
        (-(S + 2) / (S + 1), ValueError, "ill-posed"),
        (control.ss([[-1]], [[1]], [[1]], -1), ValueError, r"1 \+ L\(∞\) = 0"),
    ],
)
def test_what_is_not_accepted_is_named_with_a_remedy(system, error, message):
    with pytest.raises(error, match=message):
        loop_margins(system)


@pytest.mark.parametrize(
    ("system", "delay", "message"),
    [
        (1 / S, -0.1, r"delay = -0.1: expected a number of seconds, 0 or more"),
        (1 / S, math.nan, "delay"),
        (1 / S, math.inf, "delay"),
        (control.tf([1], [1, -1], 0.1), 0.1, "zero_order_hold"),
    ],
    ids=["negative", "nan", "infinite", "discrete"],
)
def test_a_delay_that_is_not_accepted_is_named_with_a_remedy(system, delay, message):
    with pytest.raises(ValueError, match=message):
        loop_margins(system, delay=delay)
