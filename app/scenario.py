"""Scenario files: a plant, its loop and the moves asked of it, as TOML with units in strings."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from ..analysis.specification import Bound, Labels, Mode, Move, Requirement, Specification
from ..shaping.frozen import Frozen
from ..shaping.told import Told
from . import scenario_checks as checks
from .counted_units import counted_factor
from .overrides import override
from .scenario_asked import (
    ActingSection,
    DisturbanceSection,
    FeedforwardSection,
    TrackingSection,
)
from .scenario_context import Context, context_of
from .scenario_formats import (
    FORMATS,
    File,
    FileOf2,
    FilterSection,
    GainRule,
    Gains,
    MoveSection,
    PlantOf2,
)
from .scenario_frf import check_measured
from .scenario_messages import Place, lines_of, what_to_write
from .scenario_sections import CascadeSection, ControllerSection, PidSection, PlantSection
from .scenario_shapers import shapers_of
from .standard_input import STANDARD_INPUT
from .text_files import read_toml
from .units import Motion, show, unit_of

__all__ = [
    "CascadeSection",
    "FilterSection",
    "GainRule",
    "Gains",
    "Scenario",
    "ScenarioError",
    "as_scenario",
    "load_scenario",
]

_Table = TypeVar("_Table")


class ScenarioError(ValueError):
    """A scenario file cannot be used; its message has a line for each problem."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Scenario(Told, Frozen):
    """A scenario file's content in SI units.

    Attributes
    ----------
    path : Path
        The file.
    title : str
        Its title, or the file's name without its suffix.
    motion : {"angle", "length"}
        Whether positions are in rad or in m.
    position_unit : str
        The unit in which positions are reported; `position_scale` is its SI value.
    counted : mapping of str to str
        What a "count" of the encoder and a "sample" are, where they are known.
    disturbed : mapping of str to ActingSection
        What acts on the axis during a move, by the moves' names; `scenario_commands.moves_of`
        gives the moves with it.
    inertia : float
        The plant's, in kg m² or kg.
    body : {"inertia", "mass", "chain", "transfer", "frf"}
        The key that says what moves.
    gains : {"design", "published", "tune", "measured"}, Gains or CascadeSection
        The controller's gains, or how they are found.
    specification : Specification or None
        Always given where gains is "design".
    feedforward_inertia : float
        Ĵ of the feedforward Ĵs², in kg m² or kg.
    inertia_error : float
        The fraction by which Ĵ is varied.
    filter : FilterSection or None
        The filter behind the shaper.
    moves : tuple of Move
        At least one, where there is neither tracking nor a torque that goes on; none of a measured
        plant.
    modes : tuple of Mode
        What the moves must not leave ringing.
    overrides : tuple of str
        What was given in place of the file's own, as ``key = value``.
    plant, controller, feedforward
        What a file of format 2 says of them besides the above.
    believed : PlantOf2 or None
        The plant for which feedforward, shapers and gains are made, where it is not the true one.
    tracking : tuple of TrackingSection
        Commands that go on; `limit_sets` are the bounds that scans name.
    disturbances : DisturbanceSection
    requirements : tuple of Requirement
        Bounds on what the survey finds.
    """

    path: Path
    title: str
    motion: Motion
    position_unit: str
    inertia: float
    gains: GainRule | Gains | CascadeSection
    specification: Specification | None
    feedforward_inertia: float
    inertia_error: float
    filter: FilterSection | None
    moves: tuple[Move, ...]
    modes: tuple[Mode, ...] = ()
    overrides: tuple[str, ...] = ()
    plant: PlantSection = field(default_factory=PlantSection)
    controller: ControllerSection = field(default_factory=ControllerSection)
    feedforward: FeedforwardSection = field(default_factory=FeedforwardSection)
    body: str = "inertia"
    counted: Mapping[str, str] = field(default_factory=dict, hash=False)
    disturbed: Mapping[str, ActingSection] = field(default_factory=dict, hash=False)
    tracking: tuple[TrackingSection, ...] = ()
    limit_sets: Mapping[str, tuple[Bound, ...]] = field(default_factory=dict, hash=False)
    disturbances: DisturbanceSection = field(default_factory=DisturbanceSection)
    requirements: tuple[Requirement, ...] = ()
    believed: PlantOf2 | None = None

    @property
    def as_believed(self) -> "Scenario":
        """The same with the plant that is believed to be there."""
        if self.believed is None:
            return self
        return replace(self, **_body(self.believed), believed=None)

    @property
    def believed_told(self) -> tuple[str, ...]:
        """A line where the drive believes in another plant than the true one."""
        what = "designed gains, feedforward and shapers are made for [believed]"
        return () if self.believed is None else (f"the drive knows another plant: {what}",)

    @property
    def overrides_told(self) -> tuple[str, ...]:
        """What stands in place of the file's values, a line each."""
        return tuple(f"with {text}" for text in self.overrides)

    @property
    def position_scale(self) -> float:
        """SI value, in rad or m, of one `position_unit`."""
        return counted_factor(self.position_unit, self.counted)

    @property
    def labels(self) -> Labels:
        """How what is found of it is told."""
        return Labels(self.title, self.motion, self.position_unit, self.position_scale)


def load_scenario(
    path: str | PathLike[str], *, overrides: Mapping[str, Any] | None = None
) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : path-like
        A TOML file, UTF-8, laid out as the files in ``examples/`` explain; ``-`` is standard input.
    overrides : mapping of str to object, optional
        Values in place of the file's, by their keys, as TOML would have them:
        ``{"limits.axis.jerk": "3 deg/s^3", 'moves."60 arcsec step".settle_to': "20 mas"}``.

    Returns
    -------
    Scenario
        All of it, checked, in SI units.

    Raises
    ------
    ScenarioError
        If the file cannot be read, or for what it or an override says: a line for every
        problem, with the file, the key, the value, and what to write.
    """
    path = Path(path)
    return scenario_of(path, read_content(path), overrides)


def scenario_of(
    path: Path, content: dict[str, Any], overrides: Mapping[str, Any] | None = None
) -> Scenario:
    """Return the scenario that a file's content makes, as `load_scenario` does.

    Parameters
    ----------
    path : Path
        Of the file; what the scenario names is looked for beside it.
    content : dict
        As TOML has it; it is changed.
    overrides : mapping of str to object, optional
    """
    try:
        placed = override(content, overrides or {})
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}") from None
    number = _format(path, content)
    context, problems = context_of(content), []
    told = context, content, tuple(placed.values())
    try:
        checked: Any = FORMATS[number].model_validate(content, context=context)
    except ValidationError as error:
        problems = error.errors(include_url=False)
    else:
        try:
            return _as_it_is(checked, _scenario(path, _as_believed(checked), *told))
        except ValueError as error:
            raise ScenarioError(f"{path}: {error}") from None
    lines = (f"{path}: {_whose(p, placed)}{line}" for p, line in lines_of(problems, number))
    raise ScenarioError("\n".join(lines))


def _format(path: Path, content: dict[str, Any]) -> int:
    """Return the number of a file's format, 1 where it says none."""
    number = content.get("format", 1)
    if number == 1 and type(number) is int:
        content.pop("format", None)
    elif number != 2 or type(number) is not int:
        raise ScenarioError(
            f"{path}: format: {show(number)} is not known; write format = 2, or leave it out for "
            "a file of format 1"
        )
    return number


def as_scenario(
    scenario: Scenario | str | PathLike[str], overrides: Mapping[str, Any] | None
) -> Scenario:
    """Return a scenario, read from its file where a path is given; only there can be overrides."""
    if not isinstance(scenario, Scenario):
        return load_scenario(scenario, overrides=overrides)
    if overrides:
        raise ScenarioError(
            f"{scenario.path}: overrides are for a scenario's file, not for one that is read; "
            "give load_scenario(path, overrides=…) or dataclasses.replace"
        )
    return scenario


def _whose(problem: Any, placed: Mapping[Place, str]) -> str:
    """Return the word that tells an override from what the file says."""
    where = problem["loc"]
    given = any(place[: len(where)] == where[: len(place)] for place in placed)
    return "override " if given else ""


def read_content(path: Path) -> dict[str, Any]:
    """Return what a scenario file holds, unchecked; ScenarioError where it cannot be read."""
    try:
        content = read_toml(path, "a scenario file (TOML)")
    except ValueError as error:
        raise ScenarioError(str(error)) from None
    if not content:
        sections = ", ".join(
            what_to_write(key) for key in ("plant", "controller", "limits", "moves")
        )
        raise ScenarioError(f"{path}: holds no scenario; write {sections}")
    return content


def _scenario(
    path: Path,
    checked: File | FileOf2,
    context: Context,
    content: dict[str, Any],
    overrides: tuple[str, ...],
) -> Scenario:
    if isinstance(checked, FileOf2):
        check_measured(checked)
    if not checked.moves and isinstance(checked, FileOf2) and not _is_held(checked):
        raise ValueError(
            f"moves: is missing; write {what_to_write('moves')}, or [[tracking]] for a command "
            "that goes on"
        )
    asked = checked.controller.specification
    inertia, assumed = _inertia(checked), checked.feedforward.inertia
    more = _more(checked) if isinstance(checked, FileOf2) else {"inertia": inertia}
    return Scenario(
        path=path,
        title=checked.title or ("scenario" if path == STANDARD_INPUT else path.stem),
        motion=context.motions[0],
        position_unit=checked.position_unit or _position_unit(content, context),
        gains=_gains(checked.controller.gains),
        specification=None if asked is None else Specification(**vars(asked)),
        feedforward_inertia=inertia if assumed is None else assumed,
        inertia_error=checked.feedforward.error / 100.0,
        filter=checked.filter,
        moves=tuple(_move(move, checked) for move in checked.moves),
        modes=tuple(Mode(m.name, m.frequency, m.damping / 100.0) for m in checked.modes),
        overrides=overrides,
        counted=context.counted,
        **more,
    )


def _as_believed(checked: Any) -> Any:
    """Return a file with the plant that is believed in place of the true one."""
    believed = getattr(checked, "believed", None)
    if believed is None:
        return checked
    if checked.plant.frf is not None or believed.frf is not None:
        raise ValueError("believed: a measured plant is what it is; leave believed out")
    return checked.model_copy(update={"plant": believed})


def _as_it_is(checked: Any, scenario: Scenario) -> Scenario:
    """Return a scenario with the true plant, its feedforward and shapers as they are."""
    believed = getattr(checked, "believed", None)
    if believed is None:
        return scenario
    return replace(scenario, **_body(checked.plant), believed=believed)


def _is_held(checked: FileOf2) -> bool:
    """Whether there is something for the loop to do besides moves, or no time to do it in."""
    torques = (checked.disturbances.torque_sine, checked.disturbances.torque_file)
    held = bool(checked.tracking) or any(each is not None for each in torques)
    return held or checked.plant.frf is not None


def _position_unit(content: dict[str, Any], context: Context) -> str:
    """Return the unit of the first move; without one that of a tracking's distances, or usual."""
    found = [move["distance"] for move in content.get("moves", ())]
    for tracking in content.get("tracking", ()):
        found += [
            tracking[key][part]
            for key, part in (("sine", "amplitude"), ("scan", "length"), ("onto", "distance"))
            if key in tracking
        ]
    usual = {"angle": "1 deg", "length": "1 mm"}[context.motions[0]]
    return unit_of(str(context.plain(([*found, usual])[0])))


def _gains(gains: Any) -> GainRule | Gains | CascadeSection:
    return Gains(gains.kp, gains.ki, gains.kr) if isinstance(gains, PidSection) else gains


def _inertia(checked: File | FileOf2) -> float:
    """Return the inertia of all that moves; nan of one given by its response."""
    if isinstance(checked, File):
        return checked.plant.inertia
    return _moved(checked.plant)


def _moved(plant: PlantOf2) -> float:
    given = plant.inertia or plant.mass
    return given or (sum(plant.chain.masses) if plant.chain else math.nan)


def _more(checked: FileOf2) -> dict[str, Any]:
    """Return what only files of format 2 say."""
    return {
        "disturbed": {m.name: m.disturbances for m in checked.moves if m.disturbances is not None},
        **_body(checked.plant),
        "controller": _part(ControllerSection, checked.controller),
        "feedforward": _part(FeedforwardSection, checked.feedforward),
        "tracking": checked.tracking,
        "limit_sets": {name: bounds_of(limits) for name, limits in checked.limits.items()},
        "disturbances": checked.disturbances,
        "requirements": checked.requirements,
    }


def _body(plant: PlantOf2) -> dict[str, Any]:
    """Return what a scenario keeps of a plant."""
    return {
        "inertia": _moved(plant),
        "body": plant.body,
        "plant": _part(PlantSection, plant),
    }


def _part(kind: type[_Table], whole: Any) -> _Table:
    """Return the part of a table that is of a kind."""
    return kind(**{field.name: getattr(whole, field.name) for field in fields(kind)})  # type: ignore[arg-type]


def _move(move: MoveSection, checked: File | FileOf2) -> Move:
    limits = checked.limits[move.limits]
    own = {} if isinstance(checked, File) else _shaped(move, checked)
    return Move(
        name=move.name,
        distance=move.distance,
        bounds=bounds_of(limits),
        limits_name=move.limits,
        settle_to=move.settle_to,
        **own,
    )


def bounds_of(limits: Mapping[str, Bound]) -> tuple[Bound, ...]:
    """Return a set of limits as bounds on the derivatives from the first on."""
    order = 1 + max(checks.LIMIT_KEYS.index(key) for key in limits)
    return tuple(limits.get(key, math.inf) for key in checks.LIMIT_KEYS[:order])


def _shaped(move: Any, checked: FileOf2) -> dict[str, Any]:
    """Return what only a move of format 2 has."""
    shaper = checked.shaper if move.shaper is None else move.shaper
    try:
        shapers = () if shaper in (None, "none") else shapers_of(shaper, checked)
    except ValueError as error:
        where = "shaper" if move.shaper is None else f"moves.{move.name}.shaper"
        raise ValueError(f"{where}: {error}") from None
    return {"shapers": shapers} | {
        name: getattr(move, name) for name in ("duration", "round_to", "minimum_jerk")
    }
