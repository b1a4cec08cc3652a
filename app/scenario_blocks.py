"""The blocks of a scenario that leave as FMUs and C: shaper, filter, controller, plant, loop."""

from __future__ import annotations

from dataclasses import replace
from math import inf, tau
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis.planned_moves import planned
from ..analysis.specification import Move
from ..fmu import (
    CExport,
    DigitalController,
    FmuExport,
    SampledController,
    SampledLoop,
    SampledShaper,
    export_c,
    export_fmu,
)
from ..fmu.exporting.inverse_block import inverse_trajectory_block
from ..fmu.exporting.servo_block import check_bare_pid
from ..plant import Controller, as_controller
from ..shaping import CommandFollower, JerkFilter, Limits, Trajectory
from .block_choice import OF_A_MOVE, BlockChoice
from .scenario import Scenario
from .scenario_commands import FOLLOWED
from .scenario_loop import jerk_filter_of, servo_loop_of
from .scenario_measured import measured_loop_of

if TYPE_CHECKING:
    from ..fmu.exporting.ssp import SspExport

USUAL_SAMPLE_TIME = 1e-3
"""Of what has no sample time of its own, where none is asked for, in s."""


def export_block(
    scenario: Scenario,
    block: BlockChoice,
    path: Path,
    *,
    dt: float | None = None,
    move: str | None = None,
    fmi_version: str = "2.0",
    platforms: list[str] | None = None,
) -> FmuExport | SspExport:
    """Write a block of a scenario as an FMU, or its whole loop as an SSP, in rad or m and s.

    Parameters
    ----------
    scenario : Scenario
    block : BlockChoice
        A loop is an SSP.
    path : Path
        Of the file; its folder must exist. An existing file is replaced.
    dt : float, optional
        Sample time of what is sampled and has none of its own: controller, follower. Default: 1 ms.
    move : str, optional
        Name of the move for a block of a move. Default: the first; of several, the notes say so.
    fmi_version : "2.0" or "3.0", optional
    platforms : list of str, optional
        As in `export_fmu`.

    Returns
    -------
    FmuExport or SspExport

    Raises
    ------
    ValueError
        For a move, or a part, that the scenario does not have; as `export_fmu` does.
    """
    unit = _unit_of(scenario)
    notes = _chosen(scenario, block, move)
    if block is BlockChoice.LOOP:
        from ..fmu.exporting.ssp import export_ssp

        loop = servo_loop_of(scenario)
        made = export_ssp(
            path,
            trajectory_of(scenario, move),
            loop,
            dt=None if loop.is_digital else _running(dt),
            jerk_filter=jerk_filter_of(scenario),
            fmi_version=fmi_version,
            platforms=platforms,
            unit=unit,
        )
        return replace(made, notes=(*notes, *_own_time(loop.controller_noun, dt), *made.notes))
    source, told = _source(scenario, block, dt, move)
    alone = export_fmu(source, path, fmi_version=fmi_version, platforms=platforms, unit=unit)
    return replace(alone, notes=(*notes, *told, *alone.notes))


def export_c_block(
    scenario: Scenario,
    block: BlockChoice,
    folder: Path,
    *,
    dt: float | None = None,
    move: str | None = None,
    name: str | None = None,
) -> tuple[CExport, tuple[str, ...]]:
    """Write a block of a scenario as C99, in rad or m and s.

    Parameters
    ----------
    scenario : Scenario
    block : BlockChoice
        A loop is the servo.
    folder : Path
        As in `export_c`.
    dt : float, optional
        Sample time of what is sampled and has none of its own: controller, follower, shaper.
        Default: 1 ms.
    move : str, optional
        As in `export_block`.
    name : str, optional
        What names in C begin with. Default: the block's.

    Returns
    -------
    CExport, and notes for the user

    Raises
    ------
    ValueError
        For a move, or a part, that the scenario does not have.
    OSError
        As `export_c` does.
    """
    unit = _unit_of(scenario)
    source, told = _source(scenario, block, dt, move)
    made = export_c(source, folder, name=block.value if name is None else name, unit=unit)
    return made, (*_chosen(scenario, block, move), *told)


def _unit_of(scenario: Scenario) -> str:
    return "rad" if scenario.motion == "angle" else "m"


def _chosen(scenario: Scenario, block: BlockChoice, move: str | None) -> tuple[str, ...]:
    """Return what is to be said where a block takes the first of several moves."""
    names = [own.name for own in scenario.moves]
    if block not in OF_A_MOVE or move is not None or len(names) < 2:
        return ()
    others = ", ".join(map(repr, names[1:]))
    return (f"The move is {names[0]!r}, the first; --move takes another: {others}",)


def _running(asked: float | None) -> float:
    return USUAL_SAMPLE_TIME if asked is None else asked


def _source(
    scenario: Scenario, block: BlockChoice, asked: float | None, move: str | None
) -> tuple[Any, tuple[str, ...]]:
    """Return what is to leave, and what is to be said of its sample time."""
    dt = _running(asked)
    if block is BlockChoice.TRAJECTORY:
        return _trajectory(scenario, move), ()
    if block is BlockChoice.SHAPER and find_move(scenario, move).shapers:
        return _shaper_of(find_move(scenario, move), dt), ()
    if block in (BlockChoice.FOLLOWER, BlockChoice.SHAPER):
        return _follower_of(scenario, dt, move)
    if block is BlockChoice.FILTER:
        found = jerk_filter_of(scenario)
        if found is None:
            raise ValueError(f"{scenario.path}: has no [filter]; add one, or export another block")
        return found, ()
    if scenario.body == "frf" and block is BlockChoice.CONTROLLER:
        return _controller_on_data(scenario, asked)
    loop = servo_loop_of(scenario)
    if block is BlockChoice.PLANT:
        return loop.plant, ()
    told = _own_time(loop.controller_noun, asked)
    if block in (BlockChoice.LOOP, BlockChoice.SERVO):
        running, behind = None if loop.is_digital else dt, jerk_filter_of(scenario)
        return SampledLoop(trajectory_of(scenario, move), loop, running, behind), told
    if loop.is_digital:
        return DigitalController.of(loop), told
    check_bare_pid(loop)
    return SampledController(loop.controller_noun.law, dt, loop.feedforward), told  # type: ignore[arg-type]


def _trajectory(scenario: Scenario, move: str | None) -> Any:
    """Return a trajectory, with what the inverse of a damped axis remembers of it."""
    motion = trajectory_of(scenario, move)
    if not scenario.feedforward.inverse:
        return motion
    dynamics = servo_loop_of(scenario).feedforward_noun.dynamics
    unit = _unit_of(scenario)
    return (
        motion
        if dynamics is None
        else inverse_trajectory_block(motion, dynamics, "trajectory", unit)
    )


def _controller_on_data(scenario: Scenario, asked: float | None) -> tuple[Any, tuple[str, ...]]:
    """Return the digital controller of a measured plant, without feedforward and limit."""
    controller = measured_loop_of(scenario)[1]
    if controller is None:
        raise ValueError(
            f"{scenario.path}: controller.gains: 'measured' is known by its response alone; write "
            "the gains as a table { kp, ki, kr } beside a measured plant"
        )
    noun = as_controller(controller)
    if noun.sample_time is None:
        raise ValueError(
            f"{scenario.path}: controller: is continuous, and code runs in samples; write "
            'sample_time = "1 ms", that of the measured records'
        )
    return DigitalController(noun), _own_time(noun, asked)


def _own_time(controller: Controller, asked: float | None) -> tuple[str, ...]:
    """Return what is to be said where a controller's own sample time is another than asked for."""
    own = controller.sample_time
    if None in (own, asked) or own == asked:
        return ()
    return (
        f"The controller runs every {own!r} s, as the scenario says; --sample-time is for what has "
        "none of its own",
    )


def _shaper_of(move: Move, dt: float) -> SampledShaper:
    """Return the input shapers of a move, one behind the other, for a command of samples."""
    whole, *others = move.shapers
    for other in others:
        whole = whole.then(other)
    return SampledShaper(whole, dt)


def _follower_of(
    scenario: Scenario, dt: float, move: str | None
) -> tuple[CommandFollower, tuple[str, ...]]:
    """Return a follower of a move's limits, and what is to be said of bounds above the jerk."""
    chosen, behind = find_move(scenario, move), jerk_filter_of(scenario)
    told: tuple[str, ...] = ()
    try:
        bounds = chosen.bounds
        if len(bounds) > FOLLOWED:
            behind = _lags_within(Limits.from_bounds(bounds), behind)
            told = (
                f"Bounds above the jerk are kept by lags behind the follower, {behind.order} of "
                f"{behind.corner_hz:.4g} Hz",
            )
        limits = Limits.from_bounds(bounds[:FOLLOWED])
        return CommandFollower(limits, dt=dt, jerk_filter=behind), told
    except ValueError as error:
        raise ValueError(f"{scenario.path}: move {chosen.name!r}: {error}") from None


def _lags_within(limits: Limits, behind: JerkFilter | None) -> JerkFilter:
    """Return equal lags, one for each derivative above the jerk, that keep the bounds on them.

    Behind n lags of rate ω derivative 3 + k of the motion, k ≤ n, is at most ω^k·2^(k − 1) times
    the span of the jerk. Lags that are there anyway count: no corner is higher than theirs.
    """
    low, high = limits.bounds(FOLLOWED)
    if high - low == inf:
        raise ValueError(
            f"has limits of order {limits.order}, and a follower keeps bounds up to the jerk, by "
            "lags those above: give a bound on the jerk, or export the trajectory"
        )
    span = 0.5 * (high - low)
    sides = (limits.bounds(FOLLOWED + k) for k in range(1, limits.order - FOLLOWED + 1))
    rates = (
        0.5 * (min(-below, above) / span) ** (1.0 / k)
        for k, (below, above) in enumerate(sides, start=1)
    )
    corner, order = min(rates) / tau, limits.order - FOLLOWED
    if behind is not None:
        corner, order = min(corner, behind.corner_hz), max(order, behind.order)
    return JerkFilter(corner, order)


def find_move(scenario: Scenario, name: str | None) -> Move:
    """Return the move of this name, or the first; ValueError that lists them otherwise."""
    names = [move.name for move in scenario.moves]
    if not names:
        raise ValueError(f"{scenario.path}: has no moves; write [[moves]], or export another block")
    if name is None:
        return scenario.moves[0]
    if name not in names:
        listed = ", ".join(map(repr, names))
        raise ValueError(f"{scenario.path}: has no move {name!r}; give --move one of {listed}")
    return scenario.moves[names.index(name)]


def trajectory_of(scenario: Scenario, move: str | None) -> Trajectory:
    """Return the trajectory of a move, in rad or m."""
    chosen = find_move(scenario, move)
    try:
        return planned(chosen)
    except ValueError as error:
        raise ValueError(f"{scenario.path}: move {chosen.name!r}: {error}") from None
