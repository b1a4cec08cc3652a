"""The command `jounce`: survey a scenario, check its numbers, plan a move."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from . import cli
from .check_command import CHECK_FAILED, check_command
from .common_options import AS_JSON, OVERRIDES, QUIET, SCENARIO
from .completion import Shell, completion_script
from .explore_command import explore_command
from .export_commands import export_app
from .fmu_commands import fmu_app
from .frf_command import frf_command
from .printing import message_of, print_parts, print_text
from .sweep_command import sweep_command

if TYPE_CHECKING:
    from rich.table import Table

    from ..shaping import Certificate
    from ..shaping.plain_moves import Method
    from .plan import Plan
    from .scenario_measured import MeasuredScenarioSurvey
    from .scenario_survey import ScenarioSurvey

BAD_INPUT = 2


def _print_version() -> None:
    from importlib.metadata import version

    print(f"jounce {version('jounce')}")


app = cli.Commands(
    "Command shaping with bounded derivatives, and surveys of servo loops.",
    "jounce",
    _print_version,
)
app.command("check")(check_command)
app.command("explore")(explore_command)
app.command("frf")(frf_command)
app.command("sweep")(sweep_command)
app.add(fmu_app)
app.add(export_app)


def main() -> None:
    """Run the command line; exit status 0 done, 1 a check failed, 2 bad input."""
    if isinstance(sys.stdout, TextIOWrapper):  # not every terminal has a Ĵ
        sys.stdout.reconfigure(errors="replace")
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _warner()
            try:
                app(sys.argv[1:])
            finally:  # also where a command ends with a status of its own
                sys.stdout.flush()
    except KeyboardInterrupt:
        raise SystemExit(CHECK_FAILED) from None
    except BrokenPipeError:  # who reads has seen enough
        sys.stdout = open(os.devnull, "w")  # noqa: PTH123, SIM115 (for Python to close at the end)
        raise SystemExit(CHECK_FAILED) from None
    except (ValueError, OSError) as error:
        from ..analysis.unstable_loop import UnstableLoopError

        _fail(error, CHECK_FAILED if isinstance(error, UnstableLoopError) else BAD_INPUT)
    raise SystemExit(0)


@app.command("survey")
def survey_command(
    scenario: SCENARIO,
    output: Annotated[
        Path | None,
        cli.Option(
            "--output",
            "-o",
            help="Folder for survey.json, CSV and the picture; files of the same names are "
            "replaced. Default: none is written.",
        ),
    ] = None,
    details: Annotated[
        bool, cli.Option("--details", help="With --output: a second page with the details, too.")
    ] = False,
    pdf: Annotated[
        bool, cli.Option("--pdf", help="With --output: the pictures as PDF, too.")
    ] = False,
    overrides: OVERRIDES = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Print a loop's margins, design check and moves; with --output write them with a picture.

    Exit status 1 where a requirement of the scenario is missed, or the loop is unstable.
    """
    from .overrides import read_overrides
    from .scenario_survey import survey_file

    asked = next((name for name, given in (("--details", details), ("--pdf", pdf)) if given), None)
    if output is None and asked:
        raise ValueError(f"{asked} without --output: name the folder that pictures go to")
    found = survey_file(scenario, overrides=read_overrides(overrides or ()))
    written = [] if output is None else [_write_survey(found, output, details=details, pdf=pdf)]
    if as_json:
        from .json_output import print_json
        from .result_files import data_of

        print_json(data_of(found))
    else:
        print_parts(*found.page(), *written)
    if not all(check.met for check in found.requirements):
        raise SystemExit(CHECK_FAILED)


def _write_survey(
    found: ScenarioSurvey | MeasuredScenarioSurvey, output: Path, *, details: bool, pdf: bool
) -> str:
    from .result_files import write_survey

    files = write_survey(found, output, details=details, pdf=pdf)
    return f"Wrote {', '.join(path.name for path in files)} to {output}"


@app.command("schema")
def schema_command(
    number: Annotated[
        str,
        cli.Option("--format", metavar="INTEGER", help="Format of the scenario files: 2, or 1."),
    ] = "2",
    _: AS_JSON = False,
    __: QUIET = False,
) -> None:
    """Print the JSON schema of scenario files, by which editors complete and check keys."""
    from .scenario_schema import shipped_schema

    if not number.isdecimal():
        raise ValueError(f"--format {number!r}: expected 1 or 2, such as --format 2")
    print_text(shipped_schema(int(number)))


@app.command("completion")
def completion_command(
    shell: Annotated[Shell, cli.Argument(help="bash, zsh or fish.")],
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Print what a shell needs to complete commands and options.

    bash: eval "$(jounce completion bash)" in ~/.bashrc.

    zsh: eval "$(jounce completion zsh)" in ~/.zshrc.

    fish: jounce completion fish > ~/.config/fish/completions/jounce.fish
    """
    script = completion_script(app, shell)
    if as_json:
        from .json_output import print_json

        print_json({"shell": shell.value, "script": script})
        return
    print_text(script)


@app.command("plan")
def plan_command(
    distance: Annotated[
        list[str] | None, cli.Argument(help='Such as "60 arcsec" or "-2 mm"; or give --to.')
    ] = None,
    velocity: Annotated[str | None, cli.Option(help='Such as "1 deg/s".')] = None,
    acceleration: Annotated[
        str | None,
        cli.Option(help='Such as "0.2 deg/s^2", or "-0.1 deg/s^2, 0.2 deg/s^2" for each way.'),
    ] = None,
    jerk: Annotated[str | None, cli.Option(help='Such as "2 deg/s^3".')] = None,
    snap: Annotated[str | None, cli.Option(help='Such as "20 deg/s^4".')] = None,
    crackle: Annotated[str | None, cli.Option(help='Such as "200 deg/s^5".')] = None,
    pop: Annotated[str | None, cli.Option(help='Such as "76.8 deg/s^6".')] = None,
    limit: Annotated[
        list[str] | None,
        cli.Option(help='Any derivative, such as "7=2e4 deg/s^7"; may be repeated.'),
    ] = None,
    position: Annotated[
        str | None, cli.Option(help='Lowest and highest position, such as "-4 mm, 4 mm".')
    ] = None,
    rise_time: Annotated[
        str | None,
        cli.Option(help="Rise time of the acceleration, in place of the highest limit."),
    ] = None,
    order: Annotated[
        str | None,
        cli.Option(metavar="INTEGER", help="Derivative that the rise time bounds: 6 for pop."),
    ] = None,
    start: Annotated[
        str | None, cli.Option("--from", "--start", help="Position at the start.")
    ] = None,
    to: Annotated[str | None, cli.Option(help="Position at the end, for a distance.")] = None,
    deceleration: Annotated[
        str | None,
        cli.Option(
            "--deceleration", "--decel", help="S-curve: largest acceleration while slowing down."
        ),
    ] = None,
    deceleration_jerk: Annotated[
        str | None, cli.Option(help="S-curve: largest jerk while slowing down.")
    ] = None,
    jerk_percent: Annotated[
        str | None,
        cli.Option(help='S-curve: share of each ramp with jerk, such as "50 %", for a jerk.'),
    ] = None,
    percent_keeps: Annotated[
        str | None,
        cli.Option(help="S-curve: what a jerk percent keeps, duration or acceleration."),
    ] = None,
    closed_form: Annotated[
        bool,
        cli.Option("--closed-form", help="From order 4 on: few pieces, but slower than need be."),
    ] = False,
    certify: Annotated[
        bool, cli.Option("--certify", help="Prove how near the move is to the minimum time.")
    ] = False,
    pieces: Annotated[
        bool, cli.Option("--pieces", help="Print the switch table from order 4 on, too.")
    ] = False,
    csv: Annotated[
        Path | None,
        cli.Option(help="Write the switch table to this file; one that is there is replaced."),
    ] = None,
    plot: Annotated[
        Path | None,
        cli.Option(
            help="Draw the move to this file (.png, .pdf, .svg); one that is there is replaced."
        ),
    ] = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Plan the fastest move between rests: its duration, its peaks and what limits them.

    With --deceleration, --deceleration-jerk or --jerk-percent it is an S-curve, as motion
    controllers have it.
    """
    from .plan import plan_move
    from .plan_report import certificate_table, excess_text, plan_tables
    from .plan_s_curve import SCurveText, plan_s_curve

    asked = _one_distance(distance or ())
    rates = SCurveText(
        velocity, acceleration, deceleration, jerk, deceleration_jerk, jerk_percent, percent_keeps
    )
    if rates.asked_for:
        _refuse_beside_s_curve(
            {"--snap": snap, "--crackle": crackle, "--pop": pop, "--limit": limit}
            | {"--position": position}
            | {"--rise-time": rise_time, "--order": order, "--closed-form": closed_form}
            | {"--certify": certify}
        )
        plan = plan_s_curve(asked, rates, start=start, to=to)
    else:
        bounds = _bounds((velocity, acceleration, jerk, snap, crackle, pop), limit)
        method: Method = "closed-form" if closed_form else "optimal"
        bounded = None if order is None else _order(order)
        plan = plan_move(
            asked,
            bounds,
            start=start,
            to=to,
            position=position,
            rise_time=rise_time,
            order=bounded,
            method=method,
        )
    proofs: list[Table | str] = []
    certificate = _certificate(plan) if certify else None
    if certificate is not None:
        proofs.append(certificate_table(plan, certificate))
    elif closed_form:
        proofs.append(excess_text(plan))
    if csv is not None or plot is not None:
        _write_plan(plan, csv, plot)
    if as_json:
        from .json_output import plan_data, print_json

        print_json(plan_data(plan, certificate))
        return
    print_parts(*plan_tables(plan, pieces=pieces), *proofs, *plan.remarks)
    for path in (csv, plot):
        if path is not None:
            print_parts(f"Wrote {path}")


def _certificate(plan: Plan) -> Certificate:
    from ..shaping import certify

    return certify(plan.trajectory, plan.limits)


def _one_distance(words: Sequence[str]) -> str | None:
    """Return the distance; ValueError where several words look like one."""
    if len(words) > 1:
        raise ValueError(
            f"unexpected {words[1]!r} behind the distance {words[0]!r}: write each quantity in "
            'quotation marks, such as "60 arcsec"'
        )
    return next(iter(words), None)


def _refuse_beside_s_curve(options: Mapping[str, object]) -> None:
    """Refuse options that say nothing about an S-curve."""
    given = next((name for name, value in options.items() if value), None)
    if given is not None:
        raise ValueError(
            f"{given} does not go with an S-curve, which --deceleration, --deceleration-jerk, "
            "--jerk-percent and --percent-keeps ask for: leave one or the other out"
        )


def _bounds(named: Sequence[str | None], limit: Sequence[str] | None) -> dict[int, str]:
    """Return the bounds by derivative, those with a name first."""
    bounds = {k: text for k, text in enumerate(named, start=1) if text is not None}
    for text in limit or ():
        k, quantity = _limit(text)
        if k in bounds:
            raise ValueError(f"--limit {text!r}: derivative {k} is already limited; give it once")
        bounds[k] = quantity
    return bounds


def _order(text: str) -> int:
    from .plan import derivative_key

    try:
        return derivative_key(text)
    except ValueError as error:
        raise ValueError(f"--order: {error}") from None


def _limit(text: str) -> tuple[int, str]:
    from .plan import derivative_key

    name, separator, quantity = text.partition("=")
    if not separator:
        raise ValueError(f'--limit {text!r}: expected DERIVATIVE=QUANTITY, such as "7=2e4 deg/s^7"')
    return derivative_key(name), quantity


def _write_plan(plan: Plan, csv: Path | None, plot: Path | None) -> None:
    from .plan_report import switch_rows
    from .result_files import check_picture, save_figure, write_files, write_rows

    writers: dict[Path, Callable[[Path], object]] = {}
    if csv is not None:
        header, rows = switch_rows(plan)
        writers[csv] = lambda draft: write_rows(draft, header, rows)
    if plot is not None:
        check_picture(plot)
        from matplotlib.figure import Figure

        from ..plots import plot_trajectory

        figure = plot_trajectory(
            plan.trajectory,
            limits=plan.limits,
            unit=plan.unit,
            scale=plan.scale,
            figure=Figure(),  # of its own, without pyplot and a display
        )
        writers[plot] = lambda draft: save_figure(figure, draft)
    write_files(writers)


def _warner() -> Callable[..., None]:
    """Return what prints a warning as one line, without its place in the code, and only once."""
    told = set()

    def warn(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in told:
            told.add(str(message))
            print(f"jounce: warning: {message}", file=sys.stderr)

    return warn


def _fail(error: Exception, status: int) -> None:
    print(f"jounce: {message_of(error)}", file=sys.stderr)
    raise SystemExit(status)
