"""What the gate measures of a loop and of a survey: every number, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Literal

from ...analysis.specification import FIGURES
from ...analysis.survey_of_data import MeasuredSurvey
from ...shaping.derivatives import derivative_name
from ..scenario_messages import key_path

if TYPE_CHECKING:
    from ...analysis.loop_survey import MoveSurvey, Survey
    from ...analysis.margins import LoopMargins
    from ...analysis.measured import MeasuredMargins
    from ...analysis.requirement_checks import RequirementCheck

Key = tuple[str, ...]
"""A number's name in parts: ("moves", "60 arcsec step", "settling_time_s")."""

Better = Literal["higher", "lower"] | None
"""Which way a number improves, where it has one."""

RTOL = 1e-6
"""Relative tolerance of a number for which nothing else is asked."""

_ROUNDING = 1e-6  # of what a position must settle to, and of a percentage
_EPSILON = 1e-12  # of a distance: rounding errors reach a thousandth of it
_MARGINS: dict[str, Better] = {
    "crossover_hz": None,
    "phase_margin_deg": "higher",
    "lower_gain_margin_db": "higher",
    "upper_gain_margin_db": "higher",
    "delay_margin_s": "higher",
    "modulus_margin": "higher",
    "disk_margin": "higher",
    "sensitivity_peak": "lower",
    "complementary_peak": "lower",
    "bandwidth_hz": None,
}
_POSITIONS: dict[str, tuple[str, ...]] = {
    "moves": (
        "peaks",
        "peak_error",
        "overshoot",
        "varied_peak_error",
        "residual_vibration",
        "peak_load_error",
        "left_over",
    ),
    "tracking": ("rms_error", "peak_error"),
    "budget": ("load",),
    "standstill": ("swing", "error"),
}
_REQUIRED = "requirements"
WORST = "worst"
"""What the worst figures of a sweep stand under."""
_STEP: dict[str, Better] = {
    "overshoot_percent": "lower",
    "peak_time_s": None,
    "rise_time_s": None,
    "settling_time_s": "lower",
}


@dataclass(frozen=True)
class Number:
    """One measured number.

    Attributes
    ----------
    key : tuple of str
    value : float
        inf where nothing limits a margin or a response never settles, nan where a number
        without a better side does not exist.
    better : {"higher", "lower"} or None
    atol : float
        Size of its rounding errors: a smaller difference means nothing.
    sigma : float
        Its standard deviation, of one that was measured.
    """

    key: Key
    value: float
    better: Better
    atol: float = 0.0
    sigma: float = 0.0

    def __post_init__(self) -> None:
        """Take a value that does not exist for one that never comes, or for none."""
        if not isfinite(self.value):
            object.__setattr__(self, "value", absent(self.better))

    @property
    def name(self) -> str:
        """The key as the check file writes it: ``moves."60 arcsec step".settling_time_s``."""
        return key_path(self.key)


def absent(better: Better) -> float:
    """Return how a number that does not exist, null in a baseline, counts in comparisons."""
    return nan if better is None else inf


def is_position(key: Key) -> bool:
    """Whether a number is a position or one of its derivatives, in the scenario's unit."""
    if key[0] in (_REQUIRED, WORST):
        return FIGURES[key[1].rpartition(".")[2]] in ("position", "compliance")
    if key in (("disturbance", "peak"), ("peaks", "compliance")):
        return True
    return any(part in _POSITIONS.get(key[0], ()) for part in key[1:3])


def loop_numbers(margins: LoopMargins) -> tuple[Number, ...]:
    """Return the numbers of a stable loop.

    The frequencies at which margins are taken are left out: where two peaks are of nearly
    equal height, such a frequency jumps while no margin changes.
    """
    return tuple(
        Number(("margins", name), float(getattr(margins, name)), better)
        for name, better in _MARGINS.items()
    )


def measured_numbers(margins: MeasuredMargins) -> tuple[Number, ...]:
    """Return the numbers of a measured loop that the data could give, with their deviations."""
    told = [(name, getattr(margins, name), better) for name, better in _MARGINS.items()]
    return tuple(
        Number(("margins", name), value, better, sigma=float(getattr(margins, f"{name}_sigma")))
        for name, value, better in told
        if isfinite(value)
    )


def survey_numbers(survey: Survey | MeasuredSurvey) -> tuple[Number, ...]:
    """Return the numbers of a survey, positions in the scenario's unit.

    Those of an ideal loop are the first ones; a loop with modes, delay, friction or limits has
    the others as well: peaks of PS and CS, disturbance step, error budget, standstill, the load's
    part in each move and its time in saturation. Tracking and requirements are always there.

    Of each move: its duration, the peaks of its derivatives, how the loop with its feedforward
    follows it, the worse of the responses with Ĵ varied either way ("varied"), and the
    vibration that it leaves in each mode of the scenario. Of a measured loop the margins and what
    is required of them, with their deviations.
    """
    if isinstance(survey, MeasuredSurvey):
        required = zip(_requirement_numbers(survey), survey.requirements, strict=True)
        asked = (replace(each, sigma=survey.sigma_of(check)) for each, check in required)
        return (*measured_numbers(survey.margins), *asked)
    step = [
        Number(
            ("step", name),
            float(getattr(survey.step, name)),
            better,
            atol=_ROUNDING if name.endswith("percent") else 0.0,
        )
        for name, better in _STEP.items()
    ]
    moves = [number for move in survey.moves for number in _move_numbers(survey, move)]
    real = () if survey.is_ideal else _real_numbers(survey)
    scaled = map(_scaled(survey), _requirement_numbers(survey))
    of_all = (*loop_numbers(survey.margins), *step, *moves, *real)
    return (*of_all, *_tracking_numbers(survey), *scaled)


def bounds_of(survey: Survey | MeasuredSurvey) -> dict[Key, tuple[float, float]]:
    """Return the bounds of the numbers that are required, by key."""
    bounds: dict[Key, tuple[float, float]] = {}
    for check in survey.requirements:
        _, scale = survey.labels.unit_of(check.requirement.unit)
        least, most = check.requirement.bounds
        bounds[_REQUIRED, check.requirement.name] = (least / scale, most / scale)
    return bounds


def _scaled(survey: Survey) -> Callable[[Number], Number]:
    """Return what puts a number of a position into the scenario's unit."""

    def scaled(number: Number) -> Number:
        if not is_position(number.key):
            return number
        scale = survey.labels.position_scale
        return replace(number, value=number.value / scale, atol=number.atol / scale)

    return scaled


def _requirement_numbers(survey: Survey | MeasuredSurvey) -> Iterator[Number]:
    for check in survey.requirements:
        yield Number((_REQUIRED, check.requirement.name), check.achieved, _side(check))


def _side(check: RequirementCheck) -> Better:
    if check.requirement.least is not None and check.requirement.most is not None:
        return None
    return "lower" if check.requirement.least is None else "higher"


def _tracking_numbers(survey: Survey) -> Iterator[Number]:
    scale = survey.labels.position_scale
    for each in survey.tracking:
        for name in ("rms_error", "peak_error"):
            value = getattr(each, name) / scale
            yield Number(("tracking", each.name, name), value, "lower", _rounding(survey))


def _rounding(survey: Survey) -> float:
    """Return the size of rounding errors of positions where no move gives one."""
    asked = [move.move.settle_to for move in survey.moves]
    return _ROUNDING * min(asked, default=0.0) / survey.labels.position_scale


def _real_numbers(survey: Survey) -> Iterator[Number]:
    """Yield what only a loop has that is not ideal."""
    scale, rounding = survey.labels.position_scale, _rounding(survey)
    yield Number(("peaks", "compliance"), survey.compliance.value / scale, "lower")
    yield Number(("peaks", "noise_gain"), survey.noise_gain.value, "lower")
    if survey.disturbance is not None:
        step = survey.disturbance
        yield Number(("disturbance", "peak"), step.peak / scale, "lower", rounding)
        yield Number(("disturbance", "recovery_time_s"), step.recovery_time_s, "lower")
    for source in survey.budget:
        yield Number(("budget", source.name, "load"), source.load / scale, "lower", rounding)
        if isfinite(source.torque):
            yield Number(("budget", source.name, "torque"), source.torque, "lower")
    if survey.limit_cycles is not None:
        still = survey.limit_cycles.standstill
        yield Number(("standstill", "swing"), still.swing / scale, "lower", rounding)
        yield Number(("standstill", "error"), still.error / scale, "lower", rounding)
        yield Number(("standstill", "slips"), float(still.slips), "lower")
    for move in survey.moves:
        found, key = move.configured, ("moves", move.name)
        yield Number((*key, "load_settling_time_s"), found.load_settling_time_s, "lower")
        for name in ("peak_load_error", "left_over"):
            yield Number((*key, name), getattr(found, name) / scale, "lower", rounding)
        yield Number((*key, "saturated_time_s"), found.saturated_time_s, "lower")


def _move_numbers(survey: Survey, move: MoveSurvey) -> Iterator[Number]:
    scale = survey.labels.position_scale
    asked = move.move
    rounding = max(_ROUNDING * asked.settle_to, _EPSILON * abs(asked.distance)) / scale
    found = move.configured
    varied = [r for name, r in move.responses.items() if not name.endswith("feedforward")]

    def number(*name: str, value: float, better: Better, atol: float = 0.0) -> Number:
        return Number(("moves", move.name, *name), value, better, atol)

    yield number("duration_s", value=move.duration_s, better="lower")
    for k in range(1, move.trajectory.order + 1):
        name = derivative_name(k).replace(" ", "_")
        yield number("peaks", name, value=move.trajectory.peak(k) / scale, better=None)
    yield number("settling_time_s", value=found.settling_time_s, better="lower")
    yield number("peak_error", value=found.peak_error / scale, better="lower", atol=rounding)
    yield number("peak_torque", value=found.peak_torque, better="lower")
    yield number("overshoot", value=found.overshoot / scale, better="lower", atol=rounding)
    settled = max(response.settling_time_s for response in varied)
    yield number("varied_settling_time_s", value=settled, better="lower")
    error = max(response.peak_error for response in varied) / scale
    yield number("varied_peak_error", value=error, better="lower", atol=rounding)
    for mode, left in move.residual_vibration.items():
        value = left / scale
        yield number("residual_vibration", mode, value=value, better="lower", atol=rounding)
