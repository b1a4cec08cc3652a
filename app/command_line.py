"""The command `jounce`: all its commands, what ends them, how warnings and errors are told."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from io import TextIOWrapper

from .cli import Commands
from .exit_status import BAD_INPUT, CHECK_FAILED
from .printing import message_of


def _print_version() -> None:
    from importlib.metadata import version

    print(f"jounce {version('jounce')}")


app = Commands(
    "jounce",
    "Command shaping with bounded derivatives, and surveys of servo loops.",
    {
        "survey": "survey_command:survey_command",
        "check": "check_command:check_command",
        "plan": "plan_command:plan_command",
        "sweep": "sweep_command:sweep_command",
        "explore": "explore_command:explore_command",
        "frf": "frf_command:frf_command",
        "fmu": Commands(
            "jounce fmu",
            "FMUs, FMI 2.0 and 3.0: export blocks of a scenario, inspect, run.",
            {
                "export": "fmu_commands:export_command",
                "inspect": "fmu_commands:inspect_command",
                "run": "fmu_run:run_command",
            },
        ),
        "export": Commands(
            "jounce export",
            "Blocks of a scenario as C for firmware.",
            {"c": "export_commands:export_c_command"},
        ),
        "schema": "schema_command:schema_command",
        "completion": "completion:completion_command",
    },
    _print_version,
)


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
    except (ValueError, OSError, ImportError) as error:  # what an extra would bring
        from ..analysis.unstable_loop import UnstableLoopError

        _fail(error, CHECK_FAILED if isinstance(error, UnstableLoopError) else BAD_INPUT)
    raise SystemExit(0)


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
