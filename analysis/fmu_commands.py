"""The commands `jounce fmu`: export a block of a scenario, inspect an FMU, run one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ..plant.fmu.cosimulation.cosimulation_result import CosimulationResult
    from ..plant.fmu.importing.description import FmuDescription, FmuVariable
    from ..plant.fmu.importing.stepping import Fmu

_NEARLY = 1e-9

fmu_app = typer.Typer(
    help="FMUs, FMI 2.0 and 3.0: export blocks of a scenario, inspect, run.",
    no_args_is_help=True,
)


class BlockChoice(StrEnum):
    """What of a scenario `jounce fmu export` writes."""

    TRAJECTORY = "trajectory"
    FOLLOWER = "follower"
    FILTER = "filter"
    CONTROLLER = "controller"
    PLANT = "plant"
    LOOP = "loop"


class FmiVersion(StrEnum):
    """Versions of FMI that are written."""

    FMI_2 = "2.0"
    FMI_3 = "3.0"


@fmu_app.command("export")
def export_command(
    scenario: Annotated[Path, typer.Argument(help="Scenario file (TOML), see examples/.")],
    block: Annotated[
        BlockChoice, typer.Option(help="What to export; loop: all together, as an .ssp.")
    ],
    move: Annotated[
        str | None,
        typer.Option(
            help="Name of the move, if the scenario has several; a loop's default: the first."
        ),
    ] = None,
    fmi: Annotated[FmiVersion, typer.Option(help="Version of FMI.")] = FmiVersion.FMI_2,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File to write. Default: SCENARIO_BLOCK.fmu, here."),
    ] = None,
    sample_time: Annotated[
        str, typer.Option(help="Of the controller and the follower, such as '1 ms'.")
    ] = "1 ms",
    platform: Annotated[
        list[str] | None,
        typer.Option(
            help="host, x86_64-linux, x86_64-windows, … or none (sources only); may be repeated. "
            "Default: the host's, and with ziglang Linux and Windows."
        ),
    ] = None,
) -> None:
    """Write a block of a scenario as an FMU that needs no Python; in rad or m, and s."""
    from ..plant.fmu import CompilerError
    from .command_line import print_parts
    from .scenario import load_scenario
    from .scenario_blocks import OF_A_MOVE, export_block

    if move is not None and block not in OF_A_MOVE:
        raise ValueError(f"--move: a {block.value} belongs to no move; leave it out")
    read = load_scenario(scenario)
    path = output or Path(_file_name(scenario, block, move))
    _check_target(path, scenario, ".ssp" if block is BlockChoice.LOOP else ".fmu")
    try:
        made = export_block(
            read,
            block.value,
            path,
            dt=_seconds("--sample-time", sample_time),
            move=move,
            fmi_version=fmi.value,
            platforms=_platforms(platform),
        )
    except (CompilerError, ModuleNotFoundError) as error:
        raise ValueError(" ".join(str(error).split())) from None
    except OSError as error:
        told = error.strerror or error
        raise ValueError(f"--output {path}: {told}; give a path that can be written") from None
    binaries = ", ".join(made.platforms) or "no binary, sources only"
    print_parts(f"Wrote {made.path}: {block.value}, FMI {made.fmi_version}, {binaries}")
    print_parts(*made.notes)


@fmu_app.command("inspect")
def inspect_command(
    file: Annotated[Path, typer.Argument(help="FMU, FMI 2.0 or 3.0.")],
    local: Annotated[bool, typer.Option("--local", help="Show local variables, too.")] = False,
) -> None:
    """Print what an FMU says of itself; nothing of it is run or unpacked."""
    from ..plant.fmu.importing.reading import inspect_fmu
    from .command_line import print_parts
    from .fmu_report import fmu_tables

    _check_readable(file)
    print_parts(*fmu_tables(inspect_fmu(file), local=local))


@fmu_app.command("run")
def run_command(
    file: Annotated[Path, typer.Argument(help="FMU for co-simulation, FMI 2.0 or 3.0.")],
    duration: Annotated[
        str | None, typer.Option(help="In seconds, or such as '20 ms'. Default: the FMU's own.")
    ] = None,
    step: Annotated[
        str | None, typer.Option(help="In seconds, or such as '1 ms'. Default: the FMU's own.")
    ] = None,
    setting: Annotated[
        list[str] | None,
        typer.Option("--set", help="Parameter or input, name=value; may be repeated."),
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Write all signals to this file.")] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the outputs to this file (.png, .pdf, .svg).")
    ] = None,
    sha256: Annotated[
        str | None, typer.Option(help="What the file must be, or none of it is run.")
    ] = None,
) -> None:
    """Run an FMU by itself, its inputs held. This runs native code: only files you trust.

    Parameters and inputs are those of the FMU, or as --set says.
    """
    from ..plant.fmu.importing.load import load_fmu
    from ..plant.fmu.importing.reading import inspect_fmu
    from .command_line import print_parts
    from .fmu_report import run_table

    _check_readable(file)
    _check_files(file, csv, plot)
    description = inspect_fmu(file)
    values = dict(_setting(description, text) for text in setting or ())
    dt = None if step is None else _seconds("--step", step)
    pinned = description.sha256 if sha256 is None else sha256
    with load_fmu(file, sha256=pinned, dt=dt, parameters=values) as fmu:
        result = _run(fmu, None if duration is None else _seconds("--duration", duration))
    units = _units(description)
    written = _write_run(result, units, description, csv, plot)
    print_parts(run_table(result, result.outputs, units), *(f"Wrote {path}" for path in written))


def _run(fmu: Fmu, duration: float | None) -> CosimulationResult:
    from ..plant.fmu.cosimulation.cosimulate import cosimulate

    name = fmu.description.model_name
    if not fmu.output_names:
        raise ValueError(f"{name} has no outputs that are numbers: there is nothing to show")
    if fmu.dt is None:
        raise ValueError(f"{name} suggests no step size: give --step")
    if duration is None:
        stop = fmu.description.default_experiment.stop_time
        if stop is None or not stop > fmu.time:
            raise ValueError(f"{name} suggests no stop time: give --duration")
        steps = max(math.ceil((stop - fmu.time) / fmu.dt * (1.0 - _NEARLY)), 1)
        duration = steps * fmu.dt
    return cosimulate({fmu.description.model_identifier: fmu}, (), dt=fmu.dt, duration=duration)


def _write_run(
    result: CosimulationResult,
    units: dict[str, str],
    description: FmuDescription,
    csv: Path | None,
    plot: Path | None,
) -> list[Path]:
    from .output import save_figure, write_files

    writers: dict[Path, Callable[[Path], object]] = {}
    if csv is not None:
        writers[csv] = result.to_csv
    if plot is not None:
        from matplotlib.figure import Figure

        from .plots.cosimulation import plot_cosimulation
        from .plots.style import plain

        figure = plot_cosimulation(result, figure=Figure())  # without pyplot and a display
        figure.suptitle(plain(f"{description.model_name}: {description.description}"), fontsize=11)
        for ax, name in zip(figure.axes, result.outputs, strict=True):
            ax.set_ylabel(f"[{plain(units[name] or '1')}]")
        writers[plot] = lambda draft: save_figure(figure, draft)
    write_files(writers)
    return list(writers)


def _units(description: FmuDescription) -> dict[str, str]:
    """Return the unit of each input and output by its name in a run."""
    block = description.model_identifier
    signals = description.of_causality("input", "output")
    return {f"{block}.{label}": v.unit for v in signals for label in v.labels}


def _setting(description: FmuDescription, text: str) -> tuple[str, object]:
    """Return name and value of --set, the value as the FMU declares it."""
    name, separator, value = text.partition("=")
    if not separator or not name.strip():
        raise ValueError(f"--set {text!r}: expected NAME=VALUE, such as --set u=1.5")
    variable = description.variable(name.strip())
    return variable.name, _value(variable, text, value.strip())


def _value(variable: FmuVariable, text: str, value: str) -> object:
    if variable.type == "String":
        return value
    if variable.type == "Boolean":
        if value.lower() not in ("true", "false", "1", "0"):
            raise ValueError(f"--set {text!r}: {variable.name} is true or false")
        return float(value.lower() in ("true", "1"))
    try:
        numbers = [float(part) for part in value.split(",")]
    except ValueError:
        numbers = [math.nan]
    if not all(map(math.isfinite, numbers)) or len(numbers) != variable.size:
        wanted = f"{variable.size} numbers, separated by commas" if variable.shape else "a number"
        unit = f", in {variable.unit}" if variable.unit not in ("", "1") else ""
        raise ValueError(f"--set {text!r}: expected {wanted}{unit}")
    return numbers if variable.shape else numbers[0]


def _seconds(option: str, text: str) -> float:
    """Return a duration given as a number of seconds, or with its unit."""
    from .units import DURATION, UnitError, parse_quantity

    try:
        value = float(text)
    except ValueError:
        try:
            return parse_quantity(text, DURATION)
        except UnitError as error:
            raise ValueError(f"{option}: {error}") from None
    if not 0.0 < value < math.inf:
        raise ValueError(f"{option} {text!r}: expected a positive duration, such as '2 ms'")
    return value


def _platforms(given: Sequence[str] | None) -> list[str] | None:
    if not given:
        return None
    if "none" in given and len(given) > 1:
        raise ValueError("--platform none: sources only; leave the other platforms out")
    return [] if "none" in given else list(given)


def _file_name(scenario: Path, block: BlockChoice, move: str | None) -> str:
    from .output import slug

    parts = [scenario.stem, block.value] + ([] if move is None else [slug(move)])
    return "_".join(parts) + (".ssp" if block is BlockChoice.LOOP else ".fmu")


def _check_target(path: Path, scenario: Path, suffix: str) -> None:
    if path.suffix.lower() != suffix:
        raise ValueError(f"--output {path}: expected a file name that ends in {suffix}")
    if path.is_dir() or path.is_symlink() or (path.exists() and not path.is_file()):
        raise ValueError(f"--output {path}: is a folder, link or device; name a file to be written")
    if path.resolve() == scenario.resolve():
        raise ValueError(f"--output {path}: is the scenario; name another file")


def _check_readable(file: Path) -> None:
    if not file.is_file():
        problem = "is a folder" if file.is_dir() else "is not there"
        raise ValueError(f"{file}: {problem}; give the path of an FMU")


def _check_files(file: Path, csv: Path | None, plot: Path | None) -> None:
    """Refuse, before anything is run, files that cannot be what they are to be."""
    from .output import check_picture

    if plot is not None:
        check_picture(plot)
    given: dict[str, Any] = {"--csv": csv, "--plot": plot}
    for option, path in given.items():
        if path is not None and path.resolve() == file.resolve():
            raise ValueError(f"{option} {path}: is the FMU that is run; name another file")
    if csv is not None and plot is not None and csv.resolve() == plot.resolve():
        raise ValueError(f"--csv and --plot are both {csv}: name two files")
