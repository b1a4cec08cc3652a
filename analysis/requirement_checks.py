"""Requirements beside what a survey found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Any

from .disturbed import total_of
from .specification import OF_MOVES, Labels, Requirement

OF_MARGINS = {
    "crossover": "crossover_hz",
    "bandwidth": "bandwidth_hz",
    "phase_margin": "phase_margin_deg",
    "lower_gain_margin": "lower_gain_margin_db",
    "upper_gain_margin": "upper_gain_margin_db",
    "delay_margin": "delay_margin_s",
    "modulus_margin": "modulus_margin",
    "disk_margin": "disk_margin",
    "sensitivity_peak": "sensitivity_peak",
    "complementary_peak": "complementary_peak",
}
"""Figures of the margins alone, with the names of their fields."""
_OF_RESPONSES = {
    "settling": "settling_time_s",
    "load_settling": "load_settling_time_s",
    "saturated_time": "saturated_time_s",
}
_MISSING = {
    "residual_vibration": "modes=…, [[modes]] of a file",
    "disturbance_peak": "torque_step=…",
    "disturbance_recovery": "torque_step=…",
    "rms_load": "wind=…, encoder_noise=… or an encoder's step",
    "rms_torque": "wind=…, encoder_noise=… or an encoder's step",
    "friction_spike": "the axis a friction",
    "tracking_rms": "tracking=…",
    "tracking_peak": "tracking=…",
}


@dataclass(frozen=True)
class RequirementCheck:
    """A requirement, what the loop has in SI units, and by how much it misses.

    `missed_by` is 0 where it is met, infinite where there is no such value, as of a move that
    never settles.
    """

    requirement: Requirement
    achieved: float

    @property
    def missed_by(self) -> float:
        """How far the figure is outside its bounds."""
        least, most = self.requirement.bounds
        if isnan(self.achieved):
            return float("inf")
        return max(least - self.achieved, self.achieved - most, 0.0)

    @property
    def met(self) -> bool:
        """Whether the figure is within its bounds."""
        return self.missed_by == 0.0

    def shown(self, labels: Labels) -> tuple[str, str, str]:
        """Return what is asked, what is achieved, and the verdict, for reading."""
        unit, scale = labels.unit_of(self.requirement.unit)
        least, most = self.requirement.least, self.requirement.most
        asked = [f"≥ {least / scale:.4g}"] if least is not None else []
        asked += [f"≤ {most / scale:.4g}"] if most is not None else []
        known = "not reached" if self.requirement.unit == "time" else "none"
        finite = abs(self.achieved) < float("inf")
        achieved = f"{self.achieved / scale:.4g} {unit}".strip() if finite else known
        by = f" by {self.missed_by / scale:.3g} {unit}".rstrip() if finite else ""
        return f"{', '.join(asked)} {unit}".strip(), achieved, "met" if self.met else f"missed{by}"

    def sentence(self, labels: Labels) -> str:
        """Return the check as a sentence."""
        asked, achieved, verdict = self.shown(labels)
        return f"Required {self.requirement.name} {asked} is {achieved}: {verdict}."


def requirement_checks(
    survey: Any, requirements: Sequence[Requirement]
) -> tuple[RequirementCheck, ...]:
    """Return each requirement beside its figure.

    Raises
    ------
    ValueError
        For a figure of a move that there is not, or of what the survey was not told.
    """
    return tuple(RequirementCheck(asked, figure_of(survey, asked)) for asked in requirements)


def figure_of(survey: Any, asked: Requirement) -> float:
    """Return the figure that a requirement bounds, in SI units."""
    name = asked.figure
    if name in OF_MOVES:
        return _worst(asked, {move.name: _of_move(asked, move) for move in survey.moves})
    if name in ("tracking_rms", "tracking_peak"):
        part = {"tracking_rms": "rms_error", "tracking_peak": "peak_error"}[name]
        return _worst(asked, {each.name: getattr(each, part) for each in survey.tracking})
    if asked.owner:
        raise ValueError(
            f"requirement {asked.name!r}: {name} is a figure of the whole loop; write {name!r}"
        )
    if name in OF_MARGINS:
        return float(getattr(survey.margins, OF_MARGINS[name]))
    value = _OTHERS[name](survey)
    if value is None:
        raise _no_such(asked)
    return value


def _of_move(asked: Requirement, move: Any) -> float:
    name = asked.figure
    if name == "duration":
        return float(move.duration_s)
    if name != "residual_vibration":
        return float(getattr(move.configured, _OF_RESPONSES.get(name, name)))
    if not move.residual_vibration:
        raise _no_such(asked)
    return float(max(move.residual_vibration.values()))


def _worst(asked: Requirement, values: Mapping[str, float]) -> float:
    """Return the value of the owner, or without one that which is farthest from its bound."""
    if asked.owner:
        if asked.owner not in values:
            raise ValueError(
                f"requirement {asked.name!r}: there is no {asked.owner!r}; "
                f"there are {', '.join(map(repr, values)) or 'none'}"
            )
        return values[asked.owner]
    if not values:
        raise _no_such(asked)
    checks = [RequirementCheck(asked, value) for value in values.values()]
    worst = max(checks, key=lambda check: check.missed_by)
    if worst.missed_by:
        return worst.achieved
    return (max if asked.most is not None else min)(values.values())


def _no_such(asked: Requirement) -> ValueError:
    remedy = _MISSING.get(asked.figure, "moves")
    return ValueError(
        f"requirement {asked.name!r}: the survey has no such figure; give {remedy}, or leave the "
        "requirement out"
    )


def _rms(survey: Any, which: int) -> float | None:
    random = [source for source in survey.budget if source.kind == "random"]
    return total_of(random)[which] if random else None


def _friction(survey: Any) -> float | None:
    known = [source.load for source in survey.budget if source.kind == "deterministic"]
    return known[0] if known else None


def _disturbance(survey: Any, part: str) -> float | None:
    step = survey.disturbance
    return None if step is None else float(getattr(step, part))


_OTHERS: Mapping[str, Callable[[Any], float | None]] = {
    "compliance_peak": lambda survey: survey.compliance.value,
    "step_overshoot": lambda survey: survey.step.overshoot_percent,
    "disturbance_peak": lambda survey: _disturbance(survey, "peak"),
    "disturbance_recovery": lambda survey: _disturbance(survey, "recovery_time_s"),
    "rms_load": lambda survey: _rms(survey, 0),
    "rms_torque": lambda survey: _rms(survey, 1),
    "friction_spike": _friction,
}
