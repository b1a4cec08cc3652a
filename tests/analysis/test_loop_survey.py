"""Surveys of loops that no file describes."""

import numpy as np
import pytest

from jounce.analysis import (
    Labels,
    Mode,
    Move,
    Specification,
    UnstableLoopError,
    loop_margins,
    residual_vibration,
    survey,
)
from jounce.plant import PID, Inertia, InertiaFeedforward, ServoLoop
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
