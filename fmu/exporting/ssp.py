"""Export of a servo loop as an SSP: System Structure and Parameterization 1.0."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import ceil
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...plant.servo_loop import ServoLoop
from ...shaping import JerkFilter
from ...shaping.checks import finite, positive
from ...shaping.trajectory import Motion
from .archive import archive, target_file, write_atomically
from .blocks import Block, check_xml_name
from .dispatch import block_of
from .export import export_fmu
from .servo_block import SampledLoop, planned
from .ssp_parts import lasting_of, parts_of
from .units import position_unit
from .xml_ssp import Link, structure_description

SSD = "SystemStructure.ssd"

_NEARLY = 1e-9
_MAX_STEPS = 1e12


@dataclass(frozen=True)
class SspExport:
    """What `export_ssp` wrote.

    Attributes
    ----------
    path : Path
    fmi_version : str
    platforms : tuple of str
        Platforms for which the FMUs hold a binary; none if they hold sources only.
    components : tuple of str
        Names of the components; the FMU of each is resources/NAME.fmu.
    notes : tuple of str
        What the user should know, such as that there was no compiler.
    """

    path: Path
    fmi_version: str
    platforms: tuple[str, ...]
    components: tuple[str, ...]
    notes: tuple[str, ...]


def export_ssp(
    path: str | PathLike[str],
    trajectory: Motion,
    loop: ServoLoop,
    *,
    dt: float | None = None,
    jerk_filter: JerkFilter | None = None,
    duration: float | None = None,
    fmi_version: str = "2.0",
    platforms: Iterable[str] | None = None,
    unit: str = "1",
) -> SspExport:
    """Write shaper, controller and plant, connected, as one file for tools that know SSP.

    The components are `controller` (sampled every dt), `plant`, `filter` if there is one, and
    `shaper`; with a feedforward that looks ahead `ahead`, too. The plant starts at rest where the
    trajectory starts. A digital controller runs as it is, on an axis with friction and all; its
    computing delay, of any length, is the plant's, on which each torque acts so much later.

    Parameters
    ----------
    path : path-like
        Of the file; its folder must exist. An existing file is replaced.
    trajectory : Trajectory
        Of order 2 or more; behind a jerk filter, of any. Of a digital loop, of the order of its
        feedforward.
    loop : ServoLoop
        A PID on a linear plant, or a digital loop.
    dt : float, optional
        Sample time of the controller, which should be the host's step. Default: the digital
        controller's.
    jerk_filter : JerkFilter, optional
        Put between the shaper and the loop; of order 3 or more. It takes the command as a
        polynomial of second degree within each step.
    duration : float, optional
        Of the default experiment. Default: the trajectory's, and the filter's settling time, in
        whole steps.
    fmi_version, platforms
        Of the FMUs, as in `export_fmu`. SSP 1.0 was written for FMI 2.0; some hosts take 3.0.
    unit : str, optional
        Unit of position ("rad", "m", …). Default: none.

    Returns
    -------
    SspExport

    Raises
    ------
    TypeError, ValueError
        For a trajectory or filter of too low an order, or what cannot be exported.
    OSError, CompilerError, ModuleNotFoundError
        As `export_fmu` does.

    Notes
    -----
    SSP does not say in which order a host steps. Stepped in the order of the file (Gauss-Seidel),
    the loop is the sampled loop of `ServoLoop.sampled_loop_transfer` with its own delay, which
    `ServoLoop.respond` runs; a host that steps all at once (Jacobi) adds one sample of delay; in
    its first step acts the torque that the controller shows after initialisation. The description
    in the file says so. libcosim, Ecos and FMPy step all at once (FMPy from zero torque).

    References
    ----------
    System Structure and Parameterization 1.0, Modelica Association, 2019.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import PID, Inertia
    >>> from jounce.shaping import Limits, min_time_move
    >>> move = min_time_move(1.0, Limits(acceleration=1.0))
    >>> loop = ServoLoop(Inertia(1.0), PID(kp=4.0, ki=1.0, kr=4.0))
    >>> with TemporaryDirectory() as folder:
    ...     made = export_ssp(f"{folder}/axis.ssp", move, loop, dt=1e-3, platforms=[])
    >>> made.components
    ('controller', 'plant', 'shaper')
    """
    sampled = SampledLoop(planned(trajectory), loop, dt, jerk_filter)
    unit = position_unit(unit)
    blocks, connections = parts_of(sampled, unit)
    lasting = lasting_of(sampled) if duration is None else positive("duration", duration)
    return export_ssp_of(
        path,
        {name: block_of(block, name=name, unit=unit) for name, block in blocks.items()},
        connections,
        dt=sampled.sample_time,
        start_time=sampled.trajectory.start_time,
        duration=_in_steps(lasting, sampled.sample_time),
        fmi_version=fmi_version,
        platforms=platforms,
        name="servo_loop",
    )


def export_ssp_of(
    path: str | PathLike[str],
    components: Mapping[str, Any],
    connections: Iterable[tuple[str, str]],
    *,
    dt: float,
    duration: float,
    start_time: float = 0.0,
    fmi_version: str = "2.0",
    platforms: Iterable[str] | None = None,
    name: str = "system",
) -> SspExport:
    """Write blocks, connected by name, as one .ssp file.

    Parameters
    ----------
    path : path-like
        Of the file; its folder must exist. An existing file is replaced.
    components : mapping of str to block
        By name, a C identifier; blocks as `export_fmu` takes them.
    connections : iterable of (str, str)
        From "component.output" to "component.input"; an input has one source at most.
    dt : float
        Step that the FMUs suggest.
    duration, start_time : float
        Default experiment.
    fmi_version, platforms
        As in `export_fmu`.
    name : str, optional
        Of the system.

    Returns
    -------
    SspExport

    Raises
    ------
    ValueError
        For names that no component has, an input with two sources, units that differ.
    OSError, CompilerError, ModuleNotFoundError, TypeError
        As `export_fmu` does.
    """
    dt, duration = positive("dt", dt), positive("duration", duration)
    start_time = finite("start_time", start_time)
    check_xml_name("system", name)
    if not components:
        raise ValueError("components = {}: expected at least one block")
    target = target_file(path)
    blocks = {
        own: replace(
            block_of(block, name=own),
            name=own,
            step=dt,
            start_time=start_time,
            stop_time=start_time + duration,
        )
        for own, block in components.items()
    }
    links = _checked(blocks, connections)
    if platforms is not None and not isinstance(platforms, str):  # which export_fmu refuses
        platforms = list(platforms)
    entries = {SSD: structure_description(name, blocks, links, start_time, duration)}
    notes: tuple[str, ...] = ()
    built: tuple[str, ...] = ()
    with TemporaryDirectory(prefix="jounce_ssp_") as folder:
        for own, block in blocks.items():
            made = export_fmu(
                block, f"{folder}/{own}.fmu", fmi_version=fmi_version, platforms=platforms
            )
            entries[f"resources/{own}.fmu"] = made.path.read_bytes()
            notes, built = made.notes, made.platforms
    write_atomically(target, archive(entries))
    return SspExport(target, fmi_version, built, tuple(blocks), notes)


def _in_steps(duration: float, dt: float) -> float:
    """Return the least number of whole steps, as a time, that lasts as long."""
    steps = duration / dt * (1.0 - _NEARLY)
    if not steps < _MAX_STEPS:
        raise ValueError(
            f"dt = {dt!r}: the motion of {duration:.6g} would be {steps:.3g} steps; expected at "
            f"most {_MAX_STEPS:.0e}: give both in seconds"
        )
    return max(ceil(steps), 1) * dt


def _checked(blocks: Mapping[str, Block], connections: Iterable[tuple[str, str]]) -> list[Link]:
    """Return connections, checked."""
    signals = {
        f"{own}.{variable.name}": (own, variable)
        for own, block in blocks.items()
        for variable in block.variables
        if variable.causality in ("input", "output")
    }
    links: dict[str, Link] = {}
    for connection in connections:
        if isinstance(connection, str) or len(connection) != 2:
            raise ValueError(
                f"connection {connection!r}: expected a pair, such as ('controller.u', 'plant.u')"
            )
        source, sink = connection
        for text, causality in ((source, "output"), (sink, "input")):
            if text not in signals or signals[text][1].causality != causality:
                known = [k for k, (_, v) in signals.items() if v.causality == causality]
                raise ValueError(f"no {causality} {text!r}: expected one of {', '.join(known)}")
        (begin, given), (end, taken) = signals[source], signals[sink]
        if sink in links:
            raise ValueError(f"{sink!r} has two sources: add them up in a block of their own")
        if given.unit != taken.unit:
            raise ValueError(
                f"{source!r} is in {given.unit}, {sink!r} in {taken.unit}: export both in one unit"
            )
        links[sink] = (begin, given.name, end, taken.name)
    return list(links.values())
