"""The command `jounce explore`: a scenario's loop and moves on a page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from . import cli
from .common_options import AS_JSON, QUIET, SCENARIO
from .one_thread import calculate_in_one_thread
from .printing import print_parts


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
    calculate_in_one_thread()  # a second one waits for the browser's core: margins take thrice
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
