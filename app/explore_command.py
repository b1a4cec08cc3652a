"""The command `jounce explore`: a scenario's loop and moves on a page in the browser."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

from . import cli
from .common_options import AS_JSON, QUIET, SCENARIO
from .printing import print_parts

_ONE_THREAD = ("OPENBLAS", "MKL", "OMP")
"""Of libraries whose second thread waits for a core that the browser has: margins take thrice."""


def explore_command(
    scenario: SCENARIO,
    frf: Annotated[Path | None, cli.Option(help="Measured response to lay over the model.")] = None,
    kind: Annotated[
        str,
        cli.Option(
            help="What it is of: plant, loop, sensitivity, process-sensitivity, complementary."
        ),
    ] = "plant",
    port: Annotated[int, cli.Option(help="Port on this machine; any that is free.")] = 0,
    browser: Annotated[bool, cli.Option(help="Open the page in the browser.")] = True,
    stay: Annotated[bool, cli.Option("--stay", help="Go on when the page is closed.")] = False,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Open a page to shape a scenario's loop and moves in; it ends with the page, or Ctrl-C."""
    for library in _ONE_THREAD:  # read when numpy is first imported
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    from .explorer.serving import serve_scenario

    def started(address: str) -> None:
        if as_json:
            from .json_output import print_json

            print_json({"address": address})
        else:
            print_parts(f"{address}\nclose the page, or press Ctrl-C, to end")
        if browser:
            import webbrowser

            webbrowser.open(address)

    serve_scenario(scenario, frf=frf, kind=kind, port=port, stay=stay, started=started)
