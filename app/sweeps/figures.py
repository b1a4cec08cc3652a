"""The figures of a scenario at one point of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import inf, nan
from pathlib import Path
from typing import Any

from ...analysis.margins.shared_margins import AnyMargins, SharedLoops
from ...analysis.partial_survey import PartialSurvey
from ...analysis.specification import FIGURES, HIGHER_IS_BETTER, Requirement, unknown_figure
from ...plant import PID, ServoLoop, as_controller
from ...shaping.warned import untold
from ..overrides import parts_of
from ..scenario import CascadeSection, Gains, Scenario, scenario_of
from ..scenario_commands import moves_of, survey_conditions
from ..scenario_loop import jerk_filter_of, servo_loop_of
from ..scenario_measured import measured_loop_of, survey_measured
from .sampling import Point

_MOST_DESIGNS = 1024  # that are kept
_TRIED = 64  # points, for one of which there is a scenario


@dataclass(frozen=True)
class Problem:
    """What is worked out at every point: a scenario's content, and which figures of it.

    It is sent to other processes and machines, which need not have the file. With `hold_gains`
    what is made for the plant and the delay (designed gains, feedforward, shapers) is made for
    those that stand in the file, and stays what it is however these vary.
    """

    path: Path
    content: Mapping[str, Any]
    keys: tuple[str, ...]
    figures: tuple[str, ...]
    hold_gains: bool = True
    _designed: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    _prepared: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def overrides(self, values: Sequence[object]) -> dict[str, object]:
        """Return what is put into the file at a point, what is held included."""
        given = dict(zip(self.keys, values, strict=True))
        if not self.hold_gains:
            return given
        given |= self._believed
        if not any(key.startswith("controller.gains") for key in self.keys):
            gains = self._gains(given)
            if gains is not None:
                given["controller.gains"] = gains
        return given

    @cached_property
    def _believed(self) -> dict[str, object]:
        """What keeps feedforward and shapers as the file has them, however plant and delay vary."""
        held: dict[str, object] = {}
        plant, said = self.content["plant"], self.content.get("feedforward", {})
        varies = any(key.partition(".")[0] == "plant" for key in self.keys)
        if self.content.get("format") != 2:
            if varies and "inertia" not in said:
                held["feedforward.inertia"] = plant["inertia"]
            return held
        if varies and "frf" not in plant and "believed" not in self.content:
            held["believed"] = plant
        held |= self._believed_modes
        if said.get("lead") == "auto" and "controller.delay" in self.keys:
            clock = self.with_overrides({}).controller
            held["feedforward.lead"] = f"{clock.delay + 0.5 * (clock.sample_time or 0.0)!r} s"
        return held

    @property
    def _believed_modes(self) -> dict[str, object]:
        """What keeps shapers of modes that the plant does not feel, however these vary."""
        swept = [tuple(parts_of(key)) for key in self.keys]
        held: dict[str, object] = {}
        for k, mode in enumerate(self.content.get("modes", ())):
            for name in ("frequency", "damping"):
                of_it = {("modes", place, name) for place in (mode["name"], k)}
                if of_it & set(swept) and f"believed_{name}" not in mode:
                    held[f"modes[{k}].believed_{name}"] = mode.get(name, "0 %")
        return held

    def scenario(self, values: Sequence[object]) -> Scenario:
        """Return the scenario at a point."""
        return self.with_overrides(self.overrides(values))

    @untold()  # what the first point is warned of, `refuse_missing` has told
    def prepared(self, points: Sequence[Sequence[object]]) -> Problem:
        """Return one that works these points out together, with less work than one by one.

        Threads that work on other points have one of their own; designed gains are common to all.
        """
        known = {_name(values): self._begun(values) for values in points}
        servo = [each for each in known.values() if isinstance(each, _Servo)]
        shared = SharedLoops([each.loop for each in servo])
        for k, each in enumerate(servo):
            each.margins = partial(shared.margins, k)
        return replace(self, _prepared=known)

    def _begun(self, values: Sequence[object]) -> _Servo | _Measured | Exception:
        try:
            given = self.overrides(values)
            scenario = self.with_overrides(given)
            return _Measured(scenario) if scenario.body == "frf" else self._servo(scenario, given)
        except MemoryError:
            raise
        except Exception as error:
            return error

    def _servo(self, scenario: Scenario, given: Mapping[str, object]) -> _Servo:
        """Return a point's loop, its feedforward that of a point before if all of it is held."""
        if scenario.believed is None or not self.hold_gains:
            return _Servo(scenario, servo_loop_of(scenario))
        name = "fed as " + repr({key: value for key, value in given.items() if _feeds(key)})
        loop = servo_loop_of(scenario, self._designed.get(name))
        _keep(self._designed, name, loop.feedforward)
        return _Servo(scenario, loop)

    def first_sound(self, points: Sequence[Point]) -> Point:
        """Return the first point of which there is a scenario, among the first and some others.

        Raises
        ------
        ScenarioError
            For the first, where there is none: a key leads nowhere, or a unit is not its own.
        """
        step = max(1, len(points) // _TRIED)
        try:
            self.scenario(points[0])
        except ValueError as error:
            for point in points[step::step]:
                with suppress(ValueError):
                    self.scenario(point)
                    return point
            raise error
        return points[0]

    def refuse_missing(self, values: Sequence[object]) -> None:
        """Raise ValueError for a figure of what there is not, which no point would have."""
        begun = self._begun(values)
        try:
            if not isinstance(begun, Exception):
                begun.figures([requirement_of(name) for name in self.figures])
        except ValueError as error:
            told = str(error)
            if told.startswith("requirement "):
                raise ValueError(told.replace("requirement", "figure")) from None

    @untold()
    def evaluate(self, values: Sequence[object]) -> tuple[tuple[float, ...], str]:
        """Return the figures at a point in the scenario's units; nan with the reason if it fails.

        Whatever goes wrong at a point does not end the sweep, unless memory runs out.
        """
        found: Any = self._prepared.get(_name(values)) or self._begun(values)
        try:
            if isinstance(found, Exception):
                raise found
            asked = [requirement_of(name) for name in self.figures]
            units = [found.scenario.labels.unit_of(each.unit)[1] for each in asked]
            figures = found.figures(asked)
        except MemoryError:
            raise
        except Exception as error:
            return (nan,) * len(self.figures), _told(error)
        return tuple(x / unit for x, unit in zip(figures, units, strict=True)), ""

    def with_overrides(self, overrides: Mapping[str, object]) -> Scenario:
        """Return the scenario with values in place of the file's."""
        return scenario_of(self.path, deepcopy(dict(self.content)), overrides)

    def _gains(self, given: Mapping[str, object]) -> dict[str, str] | None:
        """Return the designed gains as a file has them; None where the file gives its own."""
        believed = {key: value for key, value in given.items() if _is_believed(key)}
        name = repr(believed)
        if name not in self._designed:
            with untold():  # the point's own loop tells it
                _keep(self._designed, name, _designed_gains(self.with_overrides(believed)))
        known: dict[str, str] | None = self._designed[name]
        return known


def _is_believed(key: str) -> bool:
    """Whether a key is known to who designs the gains: the controller's, but not its delay."""
    return key.startswith("controller.") and key != "controller.delay"


def _feeds(key: str) -> bool:
    """Whether the feedforward for a believed plant, its lead given or held, may hang on a key."""
    return key.partition(".")[0] in ("believed", "feedforward") or _is_believed(key)


def _keep(kept: dict[str, Any], name: str, value: Any) -> None:
    if len(kept) >= _MOST_DESIGNS:
        kept.clear()
    kept[name] = value


class _Servo:
    """A scenario's loop, built, and what is worked out of it."""

    def __init__(self, scenario: Scenario, loop: ServoLoop) -> None:
        self.scenario, self.loop = scenario, loop
        self.margins: Callable[[], AnyMargins] | None = None

    def figures(self, asked: Sequence[Requirement]) -> Sequence[float]:
        """Return figures in SI units."""
        behind = jerk_filter_of(self.scenario)
        conditions = survey_conditions(self.scenario) | {"modes": self.scenario.modes}
        moves = moves_of(self.scenario)
        survey = PartialSurvey(
            self.loop, moves, jerk_filter=behind, conditions=conditions, margins=self.margins
        )
        return survey.figures(asked)


@dataclass(frozen=True)
class _Measured:
    """A scenario of a measured plant, whose margins alone are known."""

    scenario: Scenario

    def figures(self, asked: Sequence[Requirement]) -> Sequence[float]:
        """Return figures in SI units."""
        return [check.achieved for check in survey_measured(self.scenario, asked).requirements]


def _told(error: Exception) -> str:
    """Return the message of an error; its kind too where it is not of the input."""
    return str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"


def _name(values: Sequence[object]) -> str:
    return repr(tuple(values))


def _designed_gains(scenario: Scenario) -> dict[str, str] | None:
    if isinstance(scenario.gains, Gains | CascadeSection) or scenario.gains == "measured":
        return None
    if scenario.body == "frf":
        law = as_controller(measured_loop_of(scenario)[1]).law
    else:
        law = servo_loop_of(scenario).controller_noun.law
    assert isinstance(law, PID)  # which alone is designed
    torque, per = ("N m", "rad") if scenario.motion == "angle" else ("N", "m")
    return {
        "kp": f"{law.kp!r} {torque}/{per}",
        "ki": f"{law.ki!r} {torque}/({per} s)",
        "kr": f"{law.kr!r} {torque} s/{per}",
    }


def requirement_of(name: str) -> Requirement:
    """Return a figure as what can be asked of a survey, by its worse side without a bound."""
    if name.rpartition(".")[2] in HIGHER_IS_BETTER:
        return Requirement(name, least=-inf)
    return Requirement(name, most=inf)


def check_figures(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of figures; ValueError for none, one twice, and one that there is not."""
    if isinstance(names, str):
        names = (names,)
    if not names:
        raise ValueError(
            "figures = []: nothing is asked for; give some of " + ", ".join(FIGURES) + ", or leave "
            "figures out and write [requirements] into the scenario"
        )
    for name in names:
        if not isinstance(name, str):
            raise ValueError(f"figures: {name!r}: expected a name, such as 'phase_margin'")
        if name.rpartition(".")[2] not in FIGURES:
            raise ValueError(f"figures: {unknown_figure(name)}")
        if list(names).count(name) > 1:
            raise ValueError(f"figures: {name!r} is given twice; give it once")
    return tuple(names)
