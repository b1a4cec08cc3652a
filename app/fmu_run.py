"""The command `jounce fmu run`: an FMU by itself, or a system of FMUs, over time."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from . import cli
from .common_options import AS_JSON, QUIET
from .standard_input import file_of

if TYPE_CHECKING:
    from ..fmu.cosimulation.cosimulation_result import CosimulationResult
    from ..fmu.cosimulation.fmu_system import FmuSystem
    from ..fmu.importing.description import FmuDescription, FmuError, FmuUnit
    from ..shaping.pieces import FloatArray

    Table = tuple[FloatArray, FloatArray]

_MAX_PANELS = 40
_NEARLY = 1e-9


def run_command(
    file: Annotated[
        Path,
        cli.Argument(
            help="FMU for co-simulation, FMI 2.0 or 3.0, or SSP; file, folder, or - for standard "
            "input."
        ),
    ],
    duration: Annotated[
        str | None, cli.Option(help="In seconds, or such as '20 ms'. Default: to the stop time.")
    ] = None,
    step: Annotated[
        str | None, cli.Option(help="In seconds, or such as '1 ms'. Default: the FMU's own.")
    ] = None,
    setting: Annotated[
        list[str] | None,
        cli.Option("--set", help="Parameter or input, name=value; may be repeated."),
    ] = None,
    inputs: Annotated[
        Path | None,
        cli.Option(
            "--input",
            help="CSV file: time, then inputs by name. A unit in brackets may follow; - is "
            "standard input.",
        ),
    ] = None,
    record: Annotated[
        list[str] | None, cli.Option(help="Variable to show, too; may be repeated.")
    ] = None,
    csv: Annotated[
        Path | None,
        cli.Option(help="Write all signals to this file; one that is there is replaced."),
    ] = None,
    plot: Annotated[
        Path | None,
        cli.Option(
            help="Draw the outputs to this file (.png, .pdf, .svg); one that is there is replaced."
        ),
    ] = None,
    stop_time: Annotated[
        str | None,
        cli.Option(help="End of the run, told to the FMU. Default: its own, not told."),
    ] = None,
    tolerance: Annotated[
        str | None,
        cli.Option(metavar="FLOAT", help="Of the FMU's solver, relative. Default: the FMU's own."),
    ] = None,
    log: Annotated[
        bool, cli.Option("--log", help="Print what the FMU logs, as errors are printed.")
    ] = False,
    isolated: Annotated[
        bool, cli.Option(help="Run FMUs in processes of their own, which may crash.")
    ] = True,
    timeout: Annotated[
        str, cli.Option(help="The longest that a call of an isolated FMU may take.")
    ] = "60 s",
    max_size: Annotated[
        str | None, cli.Option(help="What the file may unpack to, such as '4 GB'.")
    ] = None,
    sha256: Annotated[
        str | None, cli.Option(help="What the file must be, or none of it is run.")
    ] = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Run an FMU or an SSP. This runs native code: only files you trust.

    Parameters and inputs are those of the file, or as --set and --input say.

    Between the rows of --input, inputs go in straight lines, discrete ones are held; before its
    first and after its last row, all are held.

    In an SSP, names are those of its own inputs and outputs, and component.variable.
    """
    from ..fmu.importing.description import FmuError
    from .fmu_options import check_files, check_readable, seconds, size_in_bytes
    from .fmu_report import run_table
    from .native_output import ended_in_order, printed_as_errors
    from .option_numbers import positive_number
    from .printing import print_parts

    check_files(file, {"--csv": csv, "--plot": plot}, inputs)
    until = None if stop_time is None else seconds("--stop-time", stop_time)
    wanted = None if duration is None else seconds("--duration", duration)
    options = {
        "dt": None if step is None else seconds("--step", step),
        "stop_time": until,
        "tolerance": positive_number("--tolerance", tolerance, 1e-6),
        "log": log,
        "record": record or [],
        "max_unpacked_bytes": None if max_size is None else size_in_bytes("--max-size", max_size),
        "isolated": isolated,
        "timeout": seconds("--timeout", timeout) if isolated else None,
    }
    # a call that never returns would keep Python from hearing of a signal
    orderly = ended_in_order() if isolated else nullcontext()
    with file_of(file, "an FMU or SSP") as path, printed_as_errors(), orderly:
        check_readable(path)
        loaded, tables = _loaded(_Asked(path, setting or [], inputs, sha256, options))
        with loaded as system:
            try:
                result = system.run(_lasting(system, wanted, until), inputs=tables)
            except FmuError as error:
                raise _kept(error, system, csv, plot) from None
            finally:
                _print_log(system)
            written = _write(result, system, csv, plot)
    if as_json:
        from .json_output import print_json, run_data

        print_json(run_data(result, _unit_names(system)))
        return
    print_parts(run_table(result, result.outputs, _unit_names(system)), *result.notes)
    print_parts(*([result.ended] if result.ended else []))
    if plot is not None and len(result.outputs) > _MAX_PANELS:
        print_parts(f"The picture shows the first {_MAX_PANELS} of {len(result.outputs)} outputs")
    print_parts(*(f"Wrote {path}" for path in written))


@dataclass(frozen=True)
class _Asked:
    """What the command line asks of a file: settings, inputs, a pinned digest, options."""

    file: Path
    settings: Sequence[str]
    inputs: Path | None
    sha256: str | None
    options: Mapping[str, Any]

    def tables(self, units: Mapping[str, FmuUnit | None]) -> Mapping[str, Table]:
        """Return the inputs over time, converted to these units."""
        from .fmu_inputs import read_inputs

        return {} if self.inputs is None else read_inputs(self.inputs, units)

    @property
    def largest(self) -> int | None:
        """How large the file may be when unpacked."""
        size: int | None = self.options["max_unpacked_bytes"]
        return size


def _loaded(asked: _Asked) -> tuple[FmuSystem, Mapping[str, Table]]:
    """Return the system of a file, initialised with the inputs at its start, and its inputs.

    The file is the one that was looked into, or the pinned one.
    """
    from .fmu_options import is_ssp

    return _loaded_ssp(asked) if is_ssp(asked.file) else _loaded_fmu(asked)


def _loaded_ssp(asked: _Asked) -> tuple[FmuSystem, Mapping[str, Table]]:
    from ..fmu.cosimulation.load_ssp import inspect_ssp, load_ssp
    from .fmu_inputs import value_at
    from .fmu_options import settings_within

    plan = inspect_ssp(asked.file, max_unpacked_bytes=asked.largest)
    units, own = plan.units(), plan.structure.inputs
    tables = asked.tables({name: units.get(name) for name in (*own, *plan.free_inputs())})
    values = settings_within(plan, asked.settings)
    for name, table in tables.items():
        block, _, variable = name.partition(".")
        steps = name not in own and _in_steps(plan.descriptions[block], variable)
        values[name] = value_at(table, plan.structure.start_time or 0.0, steps=steps)
    pinned = plan.sha256 if asked.sha256 is None else asked.sha256
    return load_ssp(asked.file, sha256=pinned, parameters=values, **asked.options), tables


def _loaded_fmu(asked: _Asked) -> tuple[FmuSystem, Mapping[str, Table]]:
    from ..fmu.cosimulation.fmu_system import system_of
    from ..fmu.cosimulation.participants import units_of
    from ..fmu.importing.load import load_fmu
    from ..fmu.importing.reading import inspect_fmu
    from .fmu_inputs import value_at
    from .fmu_options import settings_of

    description = inspect_fmu(asked.file, max_unpacked_bytes=asked.largest)
    units, prefix = units_of(description), f"{description.model_identifier}."
    labels = [label for v in description.of_causality("input") for label in v.labels]
    tables = asked.tables({n + label: units.get(label) for n in ("", prefix) for label in labels})
    start = description.default_experiment.start_time or 0.0
    values = settings_of(description, asked.settings)
    for name, table in tables.items():
        own = name if name in labels else name.removeprefix(prefix)
        values[own] = value_at(table, start, steps=_in_steps(description, own))
    pinned = description.sha256 if asked.sha256 is None else asked.sha256
    fmu = load_fmu(asked.file, sha256=pinned, parameters=values, **asked.options)
    return system_of(fmu), tables


def _in_steps(description: FmuDescription, name: str) -> bool:
    return description.variable(name).variability != "continuous"


def _lasting(system: FmuSystem, duration: float | None, stop_time: float | None) -> float | None:
    """Return how long to run; None where the file says it."""
    start = next(iter(system.blocks.values())).time
    if duration is not None and stop_time is not None:
        if start + duration > stop_time + _NEARLY * duration:
            raise ValueError(
                f"--duration {duration:g} s from {start:g} s goes beyond --stop-time {stop_time:g} "
                "s; leave one of them out"
            )
    elif duration is None and stop_time is not None:
        return stop_time - start
    elif duration is None and (system.stop_time is None or not system.stop_time > start):
        raise ValueError(f"{system.name} suggests no stop time: give --duration")
    return duration


def _print_log(system: FmuSystem) -> None:
    """Print what the FMUs logged and no error has told."""
    for name, fmu in system.blocks.items():
        for message in fmu.messages:
            print(f"jounce: {name}: {message}", file=sys.stderr)


def _kept(error: FmuError, system: FmuSystem, csv: Path | None, plot: Path | None) -> FmuError:
    """Write the rows before an error, and return it with word of them."""
    if error.result is None:
        return error
    files = _write(error.result, system, csv, plot)
    if not files:
        return error
    told = f"wrote {', '.join(map(str, files))} up to time {error.result.time[-1]:.12g}"
    return type(error)(f"{error}; {told}")


def _unit_names(system: FmuSystem) -> dict[str, str]:
    return {name: unit.name for name, unit in system.units.items()}


def _write(
    result: CosimulationResult,
    system: FmuSystem,
    csv: Path | None,
    plot: Path | None,
) -> list[Path]:
    from .result_files import save_figure, write_files

    writers: dict[Path, Callable[[Path], object]] = {}
    if csv is not None:
        writers[csv] = result.to_csv
    if plot is not None:
        from matplotlib.figure import Figure

        from ..plots.cosimulation import plot_cosimulation
        from ..plots.style import plain

        shown, units = result.outputs[:_MAX_PANELS], _unit_names(system)
        figure = plot_cosimulation(result, shown, figure=Figure())  # without pyplot and a display
        figure.suptitle(plain(_title(system)), fontsize=11)
        for ax, name in zip(figure.axes, shown, strict=True):
            ax.set_ylabel(f"[{plain(units.get(name) or '1')}]")
        writers[plot] = lambda draft: save_figure(figure, draft)
    write_files(writers)
    return list(writers)


def _title(system: FmuSystem) -> str:
    descriptions = [fmu.description.description for fmu in system.blocks.values()]
    return f"{system.name}: {descriptions[0]}" if len(descriptions) == 1 else system.name
