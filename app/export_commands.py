"""The command `jounce export c`: a block of a scenario as C99 for firmware."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

from . import cli
from .common_options import AS_JSON, QUIET, SCENARIO
from .fmu_options import seconds

export_app = cli.Commands("Blocks of a scenario as C for firmware.", "jounce export")


class FirmwareChoice(StrEnum):
    """What of a scenario `jounce export c` writes."""

    SHAPER = "shaper"
    TRAJECTORY = "trajectory"
    FOLLOWER = "follower"
    FILTER = "filter"
    CONTROLLER = "controller"
    PLANT = "plant"
    SERVO = "servo"


@export_app.command("c")
def export_c_command(
    scenario: SCENARIO,
    block: Annotated[
        FirmwareChoice,
        cli.Option(
            help="What to export; shaper: the follower, which keeps a move's limits on the way "
            "to any command; servo: the whole loop."
        ),
    ],
    output: Annotated[
        Path,
        cli.Option(
            "--output",
            "-o",
            help="Folder to write: new, empty or an earlier export, which is replaced.",
        ),
    ],
    move: Annotated[
        str | None,
        cli.Option(help="Name of the move, of a block of a move. Default: the first."),
    ] = None,
    name: Annotated[
        str | None, cli.Option(help="What names in C begin with. Default: the block's.")
    ] = None,
    sample_time: Annotated[
        str,
        cli.Option(help="Of what has none of its own: a continuous controller, follower, shaper."),
    ] = "1 ms",
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Write C99 for firmware, with an example and a Makefile; in rad or m, and s."""
    from .printing import print_parts
    from .scenario import load_scenario
    from .scenario_blocks import OF_A_MOVE, export_c_block

    if move is not None and block not in OF_A_MOVE:
        raise ValueError(f"--move: a {block.value} belongs to no move; leave it out")
    read = load_scenario(scenario)
    try:
        made, notes = export_c_block(
            read,
            block.value,
            output,
            dt=seconds("--sample-time", sample_time),
            move=move,
            name=name,
        )
    except OSError as error:
        told = error.strerror or str(error).partition(": ")[2] or error
        raise ValueError(f"--output {output}: {told}") from None
    if as_json:
        from .json_output import print_json

        print_json({"folder": made.folder, "files": made.files, "notes": notes})
        return
    print_parts(f"Wrote {made.folder}: {block.value}, C99, {len(made.files)} files")
    print_parts(*notes)
