"""A survey of which only the figures that are asked for are worked out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
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
from .early_end import exact_figures
from .loop_survey import stable_margins
from .margins.shared_margins import AnyMargins
from .peak_gain import PeakGain, peak_gain
from .planned_moves import planned
from .requirement_checks import figure_of
from .specification import Move, Requirement
from .step_response import StepResponse, step_response
from .surveyed_loop import Poles, decaying_poles
from .surveyed_moves import MoveSurvey, left_ringing, move_survey, on_a_grid


class _Figures:
    """Figures of a response to a move by the names of `MoveResponse`, each found when asked for."""

    def __init__(self, found: Callable[[str], float]) -> None:
        self._found = found

    def __getattr__(self, name: str) -> float:
        if name.startswith("_"):
            raise AttributeError(name)
        return self._found(name)


@dataclass(frozen=True)
class _PartialMove:
    """What `MoveSurvey` has of a move, as far as figures go."""

    name: str
    duration_s: float
    configured: _Figures
    ringing: Callable[[], Mapping[str, float]]

    @property
    def residual_vibration(self) -> Mapping[str, float]:
        return self.ringing()


class PartialSurvey:
    """The parts of a survey, each found when it is first asked for, by the names of `Survey`.

    Parameters
    ----------
    loop : ServoLoop
    moves : sequence of Move
    jerk_filter : JerkFilter, optional
    conditions : mapping of str to object, optional
        `modes`, `wind`, `encoder_noise`, `torque_step` and `tracking`, as `survey` takes them.
    margins : callable, optional
        Gives the loop's margins where they are found together with those of other loops.
    """

    def __init__(
        self,
        loop: ServoLoop,
        moves: Sequence[Move],
        *,
        jerk_filter: JerkFilter | None = None,
        conditions: Mapping[str, Any] | None = None,
        margins: Callable[[], AnyMargins] | None = None,
    ) -> None:
        self.loop = loop
        self._moves = tuple(moves)
        self._jerk_filter = jerk_filter
        self._conditions: Mapping[str, Any] = conditions or {}
        self._margins = margins

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
    def margins(self) -> AnyMargins:
        """The margins of the loop, which is stable."""
        found = None if self._margins is None else self._margins()
        return found if found is not None and found.stable else stable_margins(self.loop)

    @cached_property
    def _poles(self) -> Poles:
        return decaying_poles(self.margins)

    @cached_property
    def moves(self) -> tuple[MoveSurvey | _PartialMove, ...]:
        """Each move, run through the loop with its own feedforward alone."""
        return tuple(map(self._move, self._moves))

    def _move(self, move: Move) -> MoveSurvey | _PartialMove:
        modes, behind = self._conditions.get("modes", ()), self._jerk_filter
        try:
            if on_a_grid(self.loop, move, behind):
                loops = {"with feedforward": self.loop}
                return move_survey(move, loops, self._poles, jerk_filter=behind, modes=modes)
            trajectory = planned(move)
            figures = exact_figures(self.loop, trajectory, move, self._poles)
        except ValueError as error:
            raise ValueError(f"move {move.name!r}: {error}") from None
        ringing = partial(left_ringing, trajectory, behind, modes)
        return _PartialMove(move.name, trajectory.duration, _Figures(figures), ringing)

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
