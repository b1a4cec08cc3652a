"""A survey of which only the figures that are asked for are worked out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

from ..plant import ServoLoop
from ..shaping import JerkFilter
from .disturbed import (
    DisturbanceStep,
    ErrorSource,
    TrackingSurvey,
    disturbance_step,
    error_budget,
    tracking_survey,
)
from .loop_survey import stable_margins
from .margins import LoopMargins
from .peak_gain import PeakGain, peak_gain
from .requirement_checks import figure_of
from .specification import Move, Requirement
from .step_response import StepResponse, step_response
from .surveyed_loop import Poles, decaying_poles
from .surveyed_moves import MoveSurvey, move_survey


class PartialSurvey:
    """The parts of a survey, each found when it is first asked for, by the names of `Survey`.

    Parameters
    ----------
    loop : ServoLoop
    moves : sequence of Move
    jerk_filter : JerkFilter, optional
    conditions : mapping of str to object, optional
        `wind`, `encoder_noise`, `torque_step` and `tracking`, as `survey` takes them.
    """

    def __init__(
        self,
        loop: ServoLoop,
        moves: Sequence[Move],
        *,
        jerk_filter: JerkFilter | None = None,
        conditions: Mapping[str, Any] | None = None,
    ) -> None:
        self.loop = loop
        self._moves = tuple(moves)
        self._jerk_filter = jerk_filter
        self._conditions: Mapping[str, Any] = conditions or {}

    def figures(self, asked: Sequence[Requirement]) -> tuple[float, ...]:
        """Return the figures named, in SI units; a worst one of all moves by its bound.

        Raises
        ------
        UnstableLoopError
            Where the closed loop is unstable.
        ValueError
            For a figure of what there is not, or a move that cannot be driven.
        """
        return tuple(figure_of(self, each) for each in asked)

    @cached_property
    def margins(self) -> LoopMargins:
        """The margins of the loop, which is stable."""
        return stable_margins(self.loop)

    @cached_property
    def _poles(self) -> Poles:
        return decaying_poles(self.margins)

    @cached_property
    def moves(self) -> tuple[MoveSurvey, ...]:
        """Each move, run through the loop with its own feedforward alone."""
        loops = {"with feedforward": self.loop}
        return tuple(
            move_survey(move, loops, self._poles, jerk_filter=self._jerk_filter, modes=())
            for move in self._moves
        )

    @cached_property
    def step(self) -> StepResponse:
        """The step response of the linear part."""
        return step_response(self.loop, self._poles)

    @cached_property
    def compliance(self) -> PeakGain:
        """The peak of PS."""
        return peak_gain(self.loop.sensitivity().PS)

    @cached_property
    def disturbance(self) -> DisturbanceStep | None:
        """The answer to a step of torque, if one is given."""
        step = self._conditions.get("torque_step")
        return None if step is None else disturbance_step(self.loop, step, self._poles)

    @cached_property
    def budget(self) -> tuple[ErrorSource, ...]:
        """The errors by their source."""
        wind, noise = (self._conditions.get(name) for name in ("wind", "encoder_noise"))
        return error_budget(self.loop, wind, noise or 0.0, self._poles)

    @cached_property
    def tracking(self) -> tuple[TrackingSurvey, ...]:
        """The commands that go on."""
        return tuple(tracking_survey(self.loop, each) for each in self._conditions["tracking"])
