"""The command `jounce frf`: the margins of a measured response as a table and a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from . import cli
from .common_options import QUIET
from .exit_status import CHECK_FAILED
from .one_thread import calculate_in_one_thread
from .printing import print_parts
from .standard_input import file_of

if TYPE_CHECKING:
    from ..analysis.measured import MeasuredResponse


def frf_command(
    file: Annotated[
        Path, cli.Argument(help="Measured response: CSV, UFF 58, .mat; - is standard input.")
    ],
    kind: Annotated[
        str,
        cli.Option(
            help="What it is of: plant, loop, sensitivity, process-sensitivity, complementary."
        ),
    ],
    controller: Annotated[
        Path | None,
        cli.Option(help="Scenario file (TOML) whose controller closes the loop on a plant."),
    ] = None,
    output: Annotated[
        str, cli.Option(help="Of a plant: position, velocity or acceleration.")
    ] = "position",
    columns: Annotated[
        str | None, cli.Option(help='A name for each column, such as "Hz,dB,deg,-".')
    ] = None,
    frequency_unit: Annotated[str | None, cli.Option(help="Hz, kHz or rad/s.")] = None,
    averages: Annotated[
        str | None,
        cli.Option(metavar="INTEGER", help="Independent averages behind the coherence."),
    ] = None,
    dt: Annotated[
        str | None, cli.Option(help='Sample time, such as "2 ms"; in seconds without a unit.')
    ] = None,
    integrators: Annotated[
        str | None,
        cli.Option(metavar="INTEGER", help="In what was measured; default: by slope and phase."),
    ] = None,
    unstable_poles: Annotated[
        str | None, cli.Option(metavar="INTEGER", help="Of the plant.")
    ] = None,
    plot: Annotated[
        Path | None,
        cli.Option(help="Draw to this file (.png, .pdf, .svg); one that is there is replaced."),
    ] = None,
    as_json: Annotated[bool, cli.Option("--json", help="Print the numbers as JSON.")] = False,
    _: QUIET = False,
) -> None:
    """Print the margins of a measured loop with error bars; exit status 1 if it is unstable."""
    calculate_in_one_thread()
    from ..analysis.measured import measured_margins, read_frf
    from ..analysis.measured_tables import margins_report
    from .fmu_options import seconds
    from .option_numbers import whole_number
    from .result_files import check_picture

    if plot is not None:
        check_picture(plot)
    names: Any = int(columns) if columns is not None and columns.isdigit() else columns
    with file_of(file, "a measured response") as path:
        measured = read_frf(
            path,
            kind=kind,  # type: ignore[arg-type]
            output=output,  # type: ignore[arg-type]
            columns=names,
            frequency_unit=frequency_unit,
            averages=whole_number("--averages", averages, 1, 20),
            dt=None if dt is None else seconds("--dt", dt),
            integrators=whole_number("--integrators", integrators, 0, 2),
            unstable_poles=whole_number("--unstable-poles", unstable_poles, 0, 1),
        )
    law = None if controller is None else _controller_of(controller)
    margins = None
    if measured.kind != "plant" or law is not None:
        margins = measured_margins(measured, law)
    if as_json:
        from .json_output import print_json

        print_json(_plant_data(measured) if margins is None else margins.as_dict())
    elif margins is None:
        print_parts(_plant_text(measured))
    else:
        print_parts(*margins_report(measured, margins))
        print_parts(*(f"note: {warning}" for warning in margins.warnings))
    _draw(measured, law, plot, quiet=as_json)
    if margins is not None and margins.stable is False:
        raise SystemExit(CHECK_FAILED)


def _controller_of(path: Path) -> Any:
    from .scenario import load_scenario
    from .scenario_loop import servo_loop_of
    from .scenario_measured import measured_loop_of

    scenario = load_scenario(path)
    if scenario.body == "frf":
        return measured_loop_of(scenario)[1]
    return servo_loop_of(scenario).controller


def _plant_data(measured: MeasuredResponse) -> dict[str, Any]:
    misfits = sorted(measured.fits.curves.misfit)
    return {"lines": len(measured.frequency_hz), "misfit": float(misfits[len(misfits) // 2])}


def _plant_text(measured: MeasuredResponse) -> str:
    misfit = _plant_data(measured)["misfit"]
    return (
        f"{measured!r}\nscatter off smooth curves: {misfit:.3g} times what the error bars say "
        "(mean square); give --controller for the margins of a loop"
    )


def _draw(measured: MeasuredResponse, law: Any, path: Path | None, *, quiet: bool) -> None:
    if path is None:
        return
    from matplotlib.figure import Figure

    from ..plots.measured import plot_measured_response
    from .result_files import save_figure, write_files

    figure = plot_measured_response(measured, controller=law, figure=Figure())
    write_files({path: lambda draft: save_figure(figure, draft)})
    if not quiet:
        print_parts(f"Wrote {path}")
