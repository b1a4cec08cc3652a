"""Surveys of loops that no file describes."""

import math

import numpy as np
import pytest

from jounce.analysis import (
    Labels,
    Mode,
    Move,
    Specification,
    Tracking,
    UnstableLoopError,
    loop_margins,
    residual_vibration,
    survey,
)
from jounce.plant import PID, Inertia, InertiaFeedforward, Ramp, ServoLoop
from jounce.shaping import JerkFilter, Limits, min_time_move

LOOP = ServoLoop(Inertia(1.0), PID(1.0, 1.0, 2.0), InertiaFeedforward(1.0))
MOVE = Move(name="there", distance=3.0, bounds=(1.0, 2.0), limits_name="axis", settle_to=1e-3)


def test_margins_and_moves_are_those_of_the_parts():
    found = survey(LOOP, [MOVE], modes=[Mode("first", 2.0, 0.01)])
    move = min_time_move(3.0, Limits(1.0, 2.0))
    assert found.margins.as_dict() == loop_margins(LOOP.loop_transfer()).as_dict()
    assert found.moves[0].duration_s == move.duration == 3.5
    assert found.moves[0].configured.peak_error < 1e-12
    left = found.moves[0].residual_vibration["first"]
    assert left == float(residual_vibration(move, 2.0, 0.01))
    assert found.findings == ()


def test_a_wrong_inertia_costs_what_the_loop_without_that_part_does():
    found = survey(LOOP, [MOVE], inertia_error=0.25)
    responses = found.moves[0].responses
    ratio = responses["Ĵ -25 %"].peak_error / responses["without feedforward"].peak_error
    assert ratio == pytest.approx(0.25, rel=1e-6)


def test_specifications_that_are_missed_are_told():
    asked = Specification(crossover_hz=9.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    found = survey(LOOP, [MOVE], specification=asked)
    [line] = found.findings
    assert line.startswith("The gains miss their specifications: crossover ")


def test_a_filter_behind_the_shaper_smooths_the_command():
    found = survey(LOOP, [MOVE], jerk_filter=JerkFilter(2.0, 3))
    assert found.moves[0].configured.overshoot < 1e-9
    assert np.abs(found.moves[0].configured.response.command).max() <= 3.0 + 1e-9


def test_an_unstable_loop_has_no_survey():
    loop = ServoLoop(Inertia(1.0), PID(1.0, 9.0, 1.0))
    with pytest.raises(UnstableLoopError, match=r"^the closed loop is UNSTABLE"):
        survey(loop, [MOVE])


def test_a_move_that_cannot_be_planned_is_named():
    move = Move(name="far", distance=3.0, bounds=(), limits_name="axis", settle_to=1e-3)
    with pytest.raises(ValueError, match=r"^move 'far': "):
        survey(LOOP, [move])


def test_labels_are_those_given():
    labels = Labels("an axis", "length", "mm", 1e-3)
    assert survey(LOOP, [MOVE], labels=labels).plot().get_suptitle() == "an axis"


@pytest.mark.parametrize("noun", ["moves", "modes", "tracking"])
def test_two_of_one_name_are_refused(noun):
    each = {"modes": Mode("first", 2.0), "tracking": Tracking("there", Ramp(1.0), 2.0)}
    given = {"moves": [MOVE]} | {noun: [each.get(noun, MOVE)] * 2}
    with pytest.raises(ValueError, match=f"^{noun}: '(there|first)' is there twice: give each a"):
        survey(LOOP, **given)


@pytest.mark.parametrize(
    ("noun", "values", "message"),
    [
        (Specification, (0, 45.0, 12.0), "crossover_hz = 0: expected a positive, finite number"),
        (Specification, (1.0, -45.0, 12.0), "phase_margin_deg = -45.0: expected a positive"),
        (Specification, (1.0, 90.0, 12.0), "phase_margin_deg = 90.0: expected an angle between 0"),
        (Specification, (1.0, 45.0, math.nan), "lower_gain_margin_db = nan: expected a positive"),
        (Mode, ("a", -1.0), "frequency_hz = -1.0: expected a positive, finite number"),
        (Mode, ("a", math.inf), "frequency_hz = inf: expected a positive, finite number"),
        (Mode, ("a", 1.0, 1.0), "damping = 1.0: expected a ratio from 0 to below 1"),
        (Mode, ("a", 1.0, -0.1), "damping = -0.1: expected a ratio from 0 to below 1"),
    ],
)
def test_what_no_loop_can_have_is_refused(noun, values, message):
    with pytest.raises(ValueError, match=f"^{message}") as refused:
        noun(*values)
    assert "\n" not in str(refused.value)
