"""The survey of a servo loop: margins, disturbances, moves, limit cycles, what is required."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from ..plant import ServoLoop, TorqueSteps
from ..shaping import JerkFilter
from ..shaping.checks import of_kind
from ..shaping.drawing import draw
from ..shaping.real_numbers import shown
from ..shaping.told import Rows, Told
from .disturbed import (
    DisturbanceStep,
    ErrorSource,
    Noises,
    TrackingSurvey,
    Winds,
    disturbance_step,
    error_budget,
    tracking_survey,
)
from .limit_cycles import LimitCycles, limit_cycles, shown_cycles
from .margins import LoopMargins, loop_margins
from .margins.result import shown_intervals, worst_pole
from .peak_gain import PeakGain, peak_gain
from .requirement_checks import RequirementCheck, requirement_checks
from .specification import Labels, Mode, Move, Requirement, Specification, Tracking
from .step_response import StepResponse, step_response
from .surveyed_loop import compared_loops, decaying_poles, is_ideal, left_out, not_waited_for
from .surveyed_moves import MoveResponse, MoveSurvey, move_survey
from .unstable_loop import UnstableLoopError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["MoveResponse", "MoveSurvey", "Survey", "UnstableLoopError", "survey"]

_NO_GAIN = PeakGain(float("nan"), float("nan"))


@dataclass(frozen=True)
class SpecificationCheck:
    """One line of the design check: what was asked, what the loop has."""

    name: str
    unit: str
    asked: float
    achieved: float

    @property
    def shown(self) -> str:
        """The achieved value with the digits that its unit deserves."""
        return f"{self.achieved:.3f}" if self.unit == "Hz" else f"{self.achieved:.1f}"

    @property
    def met(self) -> bool:
        """Whether the two agree to 0.1 %."""
        return abs(self.achieved - self.asked) <= 1e-3 * abs(self.asked)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Survey(Told):
    """Everything that the survey of a loop found, in SI units.

    Attributes
    ----------
    loop : ServoLoop
    jerk_filter : JerkFilter or None
    margins : LoopMargins
        With delay and sampling as they are, of the linear part; peaks of S and T among them.
    compliance, noise_gain : PeakGain
        Peaks of PS, position per disturbing torque, and CS, torque per measured position.
    checks : tuple of SpecificationCheck
    step : StepResponse
        Of the linear part.
    moves : tuple of MoveSurvey
    disturbance : DisturbanceStep or None
        Where a torque step was given.
    budget : tuple of ErrorSource
    limit_cycles : LimitCycles or None
        Of a loop with friction or resolution.
    tracking : tuple of TrackingSurvey
    modes : tuple of Mode
        Those that the commands alone are held against, in open loop.
    requirements : tuple of RequirementCheck
    labels : Labels
    """

    loop: ServoLoop
    jerk_filter: JerkFilter | None
    margins: LoopMargins
    checks: tuple[SpecificationCheck, ...]
    step: StepResponse
    moves: tuple[MoveSurvey, ...]
    labels: Labels = field(default_factory=Labels)
    compliance: PeakGain = _NO_GAIN
    noise_gain: PeakGain = _NO_GAIN
    disturbance: DisturbanceStep | None = None
    budget: tuple[ErrorSource, ...] = ()
    limit_cycles: LimitCycles | None = None
    tracking: tuple[TrackingSurvey, ...] = ()
    modes: tuple[Mode, ...] = ()
    requirements: tuple[RequirementCheck, ...] = ()

    @property
    def is_ideal(self) -> bool:
        """Whether the loop is a rigid inertia under a continuous PID, without any limit."""
        return is_ideal(self.loop)

    @property
    def missed(self) -> str:
        """The specifications that are not met, and the step's overshoot; empty if all are."""
        missed = [check for check in self.checks if not check.met]
        if not missed:
            return ""
        listed = ", ".join(
            f"{check.name} {check.shown} {check.unit} (asked {check.asked:.4g})" for check in missed
        )
        return f"{listed}; step overshoot {self.step.overshoot_percent:.1f} %"

    @property
    def findings(self) -> tuple[str, ...]:
        """Plain sentences on what does not meet its specification or a requirement."""
        missed = f"The gains miss their specifications: {self.missed}."
        return ((missed,) if self.missed else ()) + self.unmet

    @property
    def unmet(self) -> tuple[str, ...]:
        """A sentence on each requirement that is not met."""
        return tuple(check.sentence(self.labels) for check in self.requirements if not check.met)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on what is idealised, where, and on limit cycles."""
        return tuple(_notes(self))

    @property
    def heading(self) -> tuple[str, ...]:
        """The lines above the tables."""
        return (self.labels.title,) if self.labels.title else ()

    def page(self) -> tuple[Any, ...]:
        """Return what is printed: heading, tables (of rich), notes and findings."""
        from .survey_tables import survey_tables

        return (*self.heading, *survey_tables(self), *self.notes, *self.findings)

    def __str__(self) -> str:
        """Return the page as text, as wide as the terminal, else 160 characters."""
        from .tables import as_text

        return as_text(self.page())

    def table_rows(self) -> Rows:
        """Return margins, moves and requirements."""
        margins = self.margins
        yield "crossover", f"{margins.crossover_hz:.5g} Hz"
        yield "phase margin", f"{margins.phase_margin_deg:.5g} deg"
        lower, upper = margins.lower_gain_margin_db, margins.upper_gain_margin_db
        yield "gain margins", f"lower {lower:.5g} dB, upper {upper:.5g} dB"
        yield "peaks", f"S {margins.sensitivity_peak:.5g}, T {margins.complementary_peak:.5g}"
        for move in self.moves:
            settled = move.configured.load_settling_time_s
            yield move.name, f"{move.duration_s:.5g} s, load settled after {settled:.5g} s"
        for check in self.requirements:
            asked, achieved, verdict = check.shown(self.labels)
            yield check.requirement.name, f"asked {asked}, achieved {achieved}, {verdict}"

    def plot(self) -> Figure:
        """Draw the survey in pyplot's current figure, or a new one if that is not empty."""
        drawn: Figure = draw(self)
        return drawn


def survey(
    loop: ServoLoop,
    moves: Sequence[Move],
    *,
    jerk_filter: JerkFilter | None = None,
    modes: Sequence[Mode] = (),
    specification: Specification | None = None,
    wind: Winds = None,
    encoder_noise: Noises = 0.0,
    torque_step: float | TorqueSteps | None = None,
    tracking: Sequence[Tracking] = (),
    requirements: Sequence[Requirement] = (),
    inertia_error: float = 0.1,
    labels: Labels | None = None,
) -> Survey:
    """Survey a servo loop: its margins, step response, and what it makes of moves.

    Margins and frequency curves are those of the linear part, delay and sampling as they are;
    moves, tracking, the torque step and the standstill are simulated with friction, limit and
    resolution, exactly.

    Parameters
    ----------
    loop : ServoLoop
        Its feedforward is the one that is varied.
    moves : sequence of Move
        In rad or m.
    jerk_filter : JerkFilter, optional
        Behind the shaper, in front of a continuous, linear loop.
    modes : sequence of Mode, optional
        What the commands alone must not leave ringing, in open loop. Those of the plant belong
        to the `Axis`: the loop then shows what it leaves of them.
    specification : Specification, optional
        What the loop is to achieve.
    wind : Wind, Spectrum or a list of them, optional
        Random torques, for the error budget.
    encoder_noise : float, Spectrum or a list of them, optional
        Standard deviation of each sample of a digital controller, or the spectrum of errors of
        the measured position, for the error budget.
    torque_step : float or TorqueSteps, optional
        A torque on the load, or steps, against which the loop holds its position.
    tracking : sequence of Tracking, optional
        Commands that go on.
    requirements : sequence of Requirement, optional
        Bounds on figures.
    inertia_error : float, optional
        The fraction by which Ĵ, the feedforward of the acceleration, is varied.
    labels : Labels, optional
        How the results are told. Default: without a title, in rad.

    Returns
    -------
    Survey

    Raises
    ------
    UnstableLoopError
        Where the closed loop is unstable.
    ValueError
        Where a move cannot be planned or driven, a tracking command cannot be followed, or a
        requirement is of what there is not.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section VII.

    Examples
    --------
    >>> from jounce.plant import Axis, Controller, FlexibleMode, InertiaFeedforward, PID
    >>> axis = Axis(1.0, modes=[FlexibleMode(20.0, 0.01, load_fraction=0.3)], torque_limit=4.0)
    >>> controller = Controller(PID(90.0, 200.0, 12.0), sample_time=1e-3, delay=1.5e-3)
    >>> there = Move(
    ...     name="there", distance=3.0, bounds=(1.0, 2.0, 9.0), limits_name="axis", settle_to=1e-3
    ... )
    >>> asked = Requirement("load_settling", most=4.5)
    >>> loop = ServoLoop(axis, controller, InertiaFeedforward(1.0))
    >>> found = survey(loop, [there], requirements=[asked])
    >>> found.requirements[0].met, round(found.moves[0].configured.load_settling_time_s, 2)
    (True, 3.64)
    """
    of_kind("loop", loop, ServoLoop, "a ServoLoop")
    _check_lists(moves=moves, modes=modes, tracking=tracking, requirements=requirements)
    labels = Labels() if labels is None else of_kind("labels", labels, Labels, "Labels(…)")
    margins = stable_margins(loop)
    poles = decaying_poles(margins)
    loops = compared_loops(loop, inertia_error)
    compliance, noise_gain = _peaks(loop)
    found = Survey(
        loop=loop,
        jerk_filter=jerk_filter,
        margins=margins,
        compliance=compliance,
        noise_gain=noise_gain,
        checks=_specification_checks(specification, margins),
        step=step_response(loop, poles),
        moves=tuple(
            move_survey(move, loops, poles, jerk_filter=jerk_filter, modes=modes) for move in moves
        ),
        disturbance=None if torque_step is None else disturbance_step(loop, torque_step, poles),
        budget=error_budget(loop, wind, encoder_noise, poles),
        limit_cycles=limit_cycles(loop, margins, poles),
        tracking=tuple(tracking_survey(loop, each) for each in tracking),
        modes=tuple(modes),
        labels=labels,
    )
    return replace(found, requirements=requirement_checks(found, requirements))


def _check_lists(**given: Any) -> None:
    """Refuse what is not a list of the nouns that a survey takes."""
    kinds = {"moves": Move, "modes": Mode, "tracking": Tracking, "requirements": Requirement}
    for name, values in given.items():
        noun = f"{kinds[name].__name__}(…)"
        of_kind(name, values, Sequence, f"a list of {noun}")  # type: ignore[type-abstract]
        for value in values:
            of_kind(name, value, kinds[name], noun)
        if name != "requirements":
            _check_names(name, [value.name for value in values])


def _check_names(of: str, names: Sequence[str]) -> None:
    """Refuse two of one name, of which results would be told apart by nothing."""
    twice = next((each for each in names if names.count(each) > 1), None)
    if twice is not None:
        raise ValueError(f"{of}: {shown(twice)} is there twice: give each a name of its own")


def stable_margins(loop: ServoLoop) -> LoopMargins:
    """Return the margins of a loop; UnstableLoopError if it is unstable."""
    margins = loop_margins(loop)
    if not margins.stable:
        raise UnstableLoopError(_unstable(margins))
    return margins


def _unstable(margins: LoopMargins) -> str:
    gains = shown_intervals(margins.stabilizing_gains)
    remedy = f"by a common factor {gains}" if margins.stabilizing_gains else "one by one"
    return (
        f"the closed loop is UNSTABLE, with a pole at {worst_pole(margins)}; "
        f"there are no margins to report. Change the gains {remedy}"
    )


def _peaks(loop: ServoLoop) -> tuple[PeakGain, PeakGain]:
    """Return the peaks of PS and CS."""
    curves = loop.sensitivity_models()
    return peak_gain(curves.PS), peak_gain(curves.CS)


def _notes(survey: Survey) -> Iterator[str]:
    """Yield what is idealised on the page, where it concerns this loop."""
    labels, axis = survey.labels, survey.loop.axis
    if survey.is_ideal and survey.modes:
        yield (
            "The moves are those of a rigid axis without limit: modes take no part in their times "
            "and errors. What the commands alone leave ringing in them, in open loop, stands "
            "apart; give modes to the axis for what the loop leaves."
        )
    if survey.is_ideal:
        yield from _beyond_tolerance(survey)
        return
    without = left_out(survey.loop, labels.torque_name)
    if without:
        yield (
            "Margins, S, T, PS, CS, unit step and error budget are those of the linear part: "
            f"without {without}. Moves, tracking, {labels.torque_name} step and standstill are "
            "simulated with all of it."
        )
    slow = not_waited_for(survey.loop, decaying_poles(survey.margins))
    if slow:
        yield slow
    if axis.encoder_step and not survey.loop.is_digital:
        yield "A continuous controller does not see the encoder's resolution: give a sample time."
    for move in survey.moves:
        yield from (f"Move {move.name}: {told}" for told in move.configured.response.remarks)
    if survey.limit_cycles is not None:
        yield from shown_cycles(survey.limit_cycles, labels.position_unit, labels.position_scale)


def _beyond_tolerance(survey: Survey) -> Iterator[str]:
    """Yield the modes in which a command leaves more than the move's tolerance."""
    unit, scale = survey.labels.position_unit, survey.labels.position_scale
    for move in survey.moves:
        for mode, left in move.residual_vibration.items():
            ratio = left / move.move.settle_to
            if ratio > 1.0:
                yield (
                    f"Move {move.name}: its command leaves {left / scale:.3g} {unit} ringing in "
                    f"{mode}, {ratio:.3g} times the tolerance: the load settles later than the "
                    "rigid axis does."
                )


def _specification_checks(
    asked: Specification | None, margins: LoopMargins
) -> tuple[SpecificationCheck, ...]:
    if asked is None:
        return ()
    return (
        SpecificationCheck("crossover", "Hz", asked.crossover_hz, margins.crossover_hz),
        SpecificationCheck("phase margin", "deg", asked.phase_margin_deg, margins.phase_margin_deg),
        SpecificationCheck(
            "lower gain margin", "dB", asked.lower_gain_margin_db, margins.lower_gain_margin_db
        ),
    )
