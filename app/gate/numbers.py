"""What the gate measures of a loop and of a survey: every number, by name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Literal

from ...shaping.derivatives import derivative_name
from ..scenario_messages import key_path

if TYPE_CHECKING:
    from ...analysis.loop_survey import MoveSurvey, Survey
    from ...analysis.margins import LoopMargins

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
_POSITIONS = ("peaks", "peak_error", "overshoot", "varied_peak_error", "residual_vibration")
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
    """

    key: Key
    value: float
    better: Better
    atol: float = 0.0

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
    return key[0] == "moves" and key[2:3] != () and key[2] in _POSITIONS


def loop_numbers(margins: LoopMargins) -> tuple[Number, ...]:
    """Return the numbers of a stable loop.

    The frequencies at which margins are taken are left out: where two peaks are of nearly
    equal height, such a frequency jumps while no margin changes.
    """
    return tuple(
        Number(("margins", name), float(getattr(margins, name)), better)
        for name, better in _MARGINS.items()
    )


def survey_numbers(survey: Survey) -> tuple[Number, ...]:
    """Return the numbers of a survey, positions in the scenario's unit.

    Of each move: its duration, the peaks of its derivatives, how the loop with its feedforward
    follows it, the worse of the responses with Ĵ varied either way ("varied"), and the
    vibration that it leaves in each mode of the scenario.
    """
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
    return (*loop_numbers(survey.margins), *step, *moves)


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
