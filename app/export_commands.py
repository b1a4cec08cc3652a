"""The command `jounce export c`: a block of a scenario as C99 for firmware."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from . import cli
from .block_choice import BLOCK_AS_C, check_move
from .common_options import AS_JSON, OVERRIDES, QUIET, SCENARIO
from .fmu_options import seconds


def export_c_command(
    scenario: SCENARIO,
    block: BLOCK_AS_C,
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
        str | None,
        cli.Option(
            help="Of what has none of its own: a continuous controller, follower, shaper. "
            "Default: 1 ms."
        ),
    ] = None,
    overrides: OVERRIDES = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Write C99 for firmware, with an example and a Makefile; in rad or m, and s."""
    from .overrides import read_overrides
    from .printing import print_parts
    from .scenario import load_scenario
    from .scenario_blocks import export_c_block

    check_move(block, move)
    read = load_scenario(scenario, overrides=read_overrides(overrides or ()))
    try:
        made, notes = export_c_block(
            read,
            block,
            output,
            dt=None if sample_time is None else seconds("--sample-time", sample_time),
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
    print_parts(*read.overrides_told)
    print_parts(f"Wrote {made.folder}: {block.value}, C99, {len(made.files)} files")
    print_parts(*notes)
