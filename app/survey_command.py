"""The command `jounce survey`: the numbers of a scenario, as tables and as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from . import cli
from .common_options import AS_JSON, OVERRIDES, QUIET, SCENARIO
from .exit_status import CHECK_FAILED
from .one_thread import calculate_in_one_thread
from .printing import print_parts

if TYPE_CHECKING:
    from .scenario_measured import MeasuredScenarioSurvey
    from .scenario_survey import ScenarioSurvey


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
    calculate_in_one_thread()
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
