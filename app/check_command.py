"""The command `jounce check`: scenarios held to stored numbers and bounds, in one report."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from . import cli
from .common_options import AS_JSON, OVERRIDES, QUIET
from .exit_status import BAD_INPUT, CHECK_FAILED
from .one_thread import calculate_in_one_thread
from .standard_input import STANDARD_INPUT

if TYPE_CHECKING:
    from .gate import GateReport
    from .gate.ci_reports import BadInput

    Outcomes: TypeAlias = Sequence[GateReport | BadInput]


class CheckFormat(StrEnum):
    """What `jounce check` prints."""

    TABLE = "table"
    GITHUB = "github"


@dataclass(frozen=True)
class _Files:
    """The files beside the scenarios that a command names."""

    baseline: Path | None
    checks: Path | None
    junit: Path | None

    def read(self, scenario: Path) -> list[Path]:
        """Return what is read for a scenario."""
        from .gate.check import baseline_beside, checks_beside

        beside = self.checks or checks_beside(scenario)
        return [scenario, self.baseline or baseline_beside(scenario), beside]


def check_command(
    scenarios: Annotated[
        list[str],
        cli.Argument(
            help="Scenario files (TOML), see examples/; patterns, 'axes/*.toml'; - is standard "
            "input."
        ),
    ],
    baseline: Annotated[
        Path | None,
        cli.Option(help="Stored numbers (JSON). Default: SCENARIO.baseline.json."),
    ] = None,
    checks: Annotated[
        Path | None,
        cli.Option(help="Bounds, tolerances (TOML). Default: SCENARIO.check.toml, if there."),
    ] = None,
    update: Annotated[
        bool,
        cli.Option(
            "--update", help="Store the numbers, in place of those before, if they keep the bounds."
        ),
    ] = False,
    overrides: OVERRIDES = None,
    junit: Annotated[
        Path | None,
        cli.Option(
            help="Write the outcome to this file, as JUnit XML; one that is there is replaced."
        ),
    ] = None,
    output: Annotated[
        CheckFormat, cli.Option("--format", help="github: print annotations, too.")
    ] = CheckFormat.TABLE,
    everything: Annotated[
        bool, cli.Option("--all", help="Show what stayed the same, too.")
    ] = False,
    as_json: AS_JSON = False,
    sweep: Annotated[
        Path | None,
        cli.Option(help="Judge the yield and the worst cases of this sweep (TOML) instead."),
    ] = None,
    _: QUIET = False,
) -> None:
    """Compare loops' margins and moves with stored numbers and bounds; status 1 if worse.

    An improvement beyond tolerance passes, with a note.

    A number without a better side may change neither way: crossover, bandwidth,
    rise and peak time of the step, peaks of a move.

    What is asked and given (plant, specification, moves with their limits, filter and
    tolerances, modes) must be as it was stored.

    With --sweep so must be what varies. Its numbers and bounds lie beside the sweep file, in
    SWEEP.baseline.json and SWEEP.check.toml.
    """
    calculate_in_one_thread()
    from .gate.ci_reports import BadInput, github_error, tally
    from .gate.scenario_files import scenario_files
    from .overrides import read_overrides
    from .printing import message_of, print_parts

    files = _Files(baseline, checks, junit)
    outcomes: Outcomes = [BadInput(Path(scenarios[0]), "")]
    try:
        paths = scenario_files(scenarios)
        _refuse_several(paths, files, sweep)
        if STANDARD_INPUT in paths and sweep is None:
            _refuse_without_files(files, update=update)
        given = read_overrides(overrides or ())
        _refuse_overrides(given, sweep)
        outcomes = [_outcome(path, files, given, update=update, sweep=sweep) for path in paths]
        written = _write(outcomes, files)
    except (ValueError, OSError) as error:
        _replace_junit([BadInput(each.path, message_of(error)) for each in outcomes], files)
        if output is CheckFormat.GITHUB:
            print(github_error(message_of(error)))
        raise
    if as_json:
        _print_json(outcomes)
    else:
        for outcome in outcomes:
            _print(outcome, output, everything=everything, several=len(outcomes) > 1)
        told = [tally(outcomes)] * (len(outcomes) > 1)
        print_parts(*told, *(f"Wrote {path}" for path in written))
    if any(isinstance(outcome, BadInput) for outcome in outcomes):
        raise SystemExit(BAD_INPUT)
    if not all(outcome.passed for outcome in outcomes if not isinstance(outcome, BadInput)):
        raise SystemExit(CHECK_FAILED)


def _refuse_several(paths: Sequence[Path], files: _Files, sweep: Path | None) -> None:
    """Refuse one baseline, one check file, or one sweep, of several scenarios."""
    given = ("--baseline", files.baseline), ("--checks", files.checks), ("--sweep", sweep)
    for option, path in given:
        if path is not None and len(paths) > 1:
            raise ValueError(
                f"{option} {path}: is of one scenario, and {len(paths)} are given; leave it out: "
                "each has its own beside it"
            )


def _refuse_without_files(files: _Files, *, update: bool) -> None:
    """Refuse a scenario of standard input, beside which nothing lies, with nothing to hold to."""
    if files.baseline is None and (update or files.checks is None):
        raise ValueError("-: no baseline lies beside standard input; give --baseline FILE")
    if files.baseline == STANDARD_INPUT and update:
        raise ValueError("--baseline -: standard input cannot be written; name a file")


def _refuse_overrides(overrides: Mapping[str, Any], sweep: Path | None) -> None:
    if sweep is not None and overrides:
        raise ValueError(
            f"--set {next(iter(overrides))}: is for the check of a scenario alone; with --sweep "
            "write it into the scenario file, or into the sweep file as a list of one value"
        )


def _outcome(
    path: Path, files: _Files, overrides: Mapping[str, Any], *, update: bool, sweep: Path | None
) -> GateReport | BadInput:
    from .gate import check_scenario, check_sweep
    from .gate.ci_reports import BadInput
    from .printing import message_of

    at: dict[str, Any] = {"baseline": files.baseline, "checks": files.checks}
    try:
        if sweep is not None:
            return check_sweep(path, sweep, **at, update=update)
        return check_scenario(path, **at, update=update, overrides=overrides)
    except (ValueError, OSError) as error:
        return BadInput(path, message_of(error))


def _write(outcomes: Outcomes, files: _Files) -> list[Path]:
    """Write baselines that are to be updated and the JUnit file, all or none; return which."""
    from .gate.ci_reports import BadInput
    from .result_files import write_files

    if all(isinstance(outcome, BadInput) for outcome in outcomes):
        _replace_junit(outcomes, files)
        return []
    writers: dict[Path, Callable[[Path], object]] = {}
    for outcome in outcomes:
        if isinstance(outcome, BadInput) or not (outcome.update and outcome.passed):
            continue
        if outcome.measured is not None:
            writers[files.read(outcome.path)[1]] = outcome.measured.write
    write_files({**writers, **_junit_writer(outcomes, files)})
    return [*writers, *([files.junit] if files.junit else [])]


def _replace_junit(outcomes: Outcomes, files: _Files) -> None:
    """Put bad input in the place of an earlier run's JUnit file, if that can be written."""
    from .result_files import write_files

    with suppress(ValueError, OSError):  # the error itself is what to tell
        write_files(_junit_writer(outcomes, files))


def _junit_writer(outcomes: Outcomes, files: _Files) -> dict[Path, Callable[[Path], object]]:
    from .gate.ci_reports import junit_text

    junit = files.junit
    if junit is None:
        return {}
    inputs = {path.resolve() for outcome in outcomes for path in files.read(outcome.path)}
    if junit.resolve() in inputs:
        raise ValueError(f"--junit {junit}: is a file that is read; name another one")
    text = junit_text(*outcomes).encode("utf-8")
    return {junit: lambda draft: draft.write_bytes(text)}


def _print_json(outcomes: Outcomes) -> None:
    from .gate.ci_reports import BadInput
    from .json_output import print_json, report_data

    print_json(
        [
            {"scenario": str(each.path), "passed": False, "bad_input": each.message}
            if isinstance(each, BadInput)
            else report_data(each)
            for each in outcomes
        ]
    )


def _print(
    outcome: GateReport | BadInput, output: CheckFormat, *, everything: bool, several: bool
) -> None:
    from .gate.ci_reports import BadInput, github_error, github_lines
    from .gate.report import GateTable, heading, shown_rows, summary
    from .printing import print_parts

    if isinstance(outcome, BadInput):
        print(f"jounce: {outcome.message}", file=sys.stderr)
        if output is CheckFormat.GITHUB:
            print(github_error(outcome.message))
        return
    title = heading(outcome, file=several)
    rows, left_out = shown_rows(outcome, everything=everything, brief=several)
    if rows:
        print_parts(GateTable(rows, title))
    elif several:
        print_parts(title)
    if left_out:
        print_parts(f"{left_out}\n")
    if output is CheckFormat.GITHUB:
        for line in github_lines(outcome):
            print(line)
    print_parts(summary(outcome), *[""] * several)
