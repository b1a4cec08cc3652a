"""The commands `jounce fmu export` and `jounce fmu inspect`: FMUs written and looked into."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

from . import cli
from .block_choice import BLOCK_AS_FMU, BlockChoice, check_move
from .common_options import AS_JSON, OVERRIDES, QUIET, SCENARIO
from .fmu_options import check_readable, is_ssp, seconds, size_in_bytes
from .standard_input import STANDARD_INPUT, file_of


class FmiVersion(StrEnum):
    """Versions of FMI that are written."""

    FMI_2 = "2.0"
    FMI_3 = "3.0"


def export_command(
    scenario: SCENARIO,
    block: BLOCK_AS_FMU,
    move: Annotated[
        str | None,
        cli.Option(help="Name of the move, of a block of a move. Default: the first."),
    ] = None,
    fmi: Annotated[FmiVersion, cli.Option(help="Version of FMI.")] = FmiVersion.FMI_2,
    output: Annotated[
        Path | None,
        cli.Option(
            "--output",
            "-o",
            help="File to write; one that is there is replaced. Default: SCENARIO_BLOCK.fmu.",
        ),
    ] = None,
    sample_time: Annotated[
        str | None,
        cli.Option(
            help="Of what has none of its own: a continuous controller, the follower. "
            "Default: 1 ms."
        ),
    ] = None,
    platform: Annotated[
        list[str] | None,
        cli.Option(
            help="host, x86_64-linux, x86_64-windows, … or none (sources only); may be repeated. "
            "Default: the host's, and with ziglang Linux and Windows."
        ),
    ] = None,
    overrides: OVERRIDES = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Write a block of a scenario as an FMU that needs no Python; in rad or m, and s."""
    from ..fmu import CompilerError
    from .overrides import read_overrides
    from .printing import print_parts
    from .scenario import load_scenario
    from .scenario_blocks import export_block

    check_move(block, move)
    read = load_scenario(scenario, overrides=read_overrides(overrides or ()))
    path = output or Path(_file_name(scenario, block, move))
    _check_target(path, scenario, ".ssp" if block is BlockChoice.LOOP else ".fmu")
    try:
        made = export_block(
            read,
            block,
            path,
            dt=None if sample_time is None else seconds("--sample-time", sample_time),
            move=move,
            fmi_version=fmi.value,
            platforms=_platforms(platform),
        )
    except (CompilerError, ModuleNotFoundError) as error:
        raise ValueError(" ".join(str(error).split())) from None
    except OSError as error:
        told = error.strerror or error
        raise ValueError(f"--output {path}: {told}; give a path that can be written") from None
    if as_json:
        from .json_output import print_json

        print_json(made)
        return
    binaries = ", ".join(made.platforms) or "no binary, sources only"
    print_parts(*read.overrides_told)
    print_parts(f"Wrote {made.path}: {block.value}, FMI {made.fmi_version}, {binaries}")
    print_parts(*made.notes)


def inspect_command(
    file: Annotated[
        Path,
        cli.Argument(help="FMU, FMI 2.0 or 3.0, or SSP; file, folder, or - for standard input."),
    ],
    local: Annotated[bool, cli.Option("--local", help="Show local variables, too.")] = False,
    max_size: Annotated[
        str | None, cli.Option(help="What the file may unpack to, such as '4 GB'.")
    ] = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Print what an FMU or SSP says of itself; nothing of it is run or unpacked for good."""
    from ..fmu.cosimulation.load_ssp import inspect_ssp
    from ..fmu.importing.reading import inspect_fmu
    from .fmu_report import fmu_tables, ssp_tables
    from .printing import print_parts

    limit = None if max_size is None else size_in_bytes("--max-size", max_size)
    with file_of(file, "an FMU or SSP") as path:
        check_readable(path)
        system = is_ssp(path)
        inspect: Callable[..., Any] = inspect_ssp if system else inspect_fmu
        found = inspect(path, max_unpacked_bytes=limit)
    if as_json:
        from .json_output import print_json

        print_json(found)
        return
    print_parts(*(ssp_tables(found) if system else fmu_tables(found, local=local)))


def _platforms(given: Sequence[str] | None) -> list[str] | None:
    if not given:
        return None
    if "none" in given and len(given) > 1:
        raise ValueError("--platform none: sources only; leave the other platforms out")
    return [] if "none" in given else list(given)


def _file_name(scenario: Path, block: BlockChoice, move: str | None) -> str:
    from .result_files import slug

    stem = "scenario" if scenario == STANDARD_INPUT else scenario.stem
    parts = [stem, block.value] + ([] if move is None else [slug(move)])
    return "_".join(parts) + (".ssp" if block is BlockChoice.LOOP else ".fmu")


def _check_target(path: Path, scenario: Path, suffix: str) -> None:
    if path.suffix.lower() != suffix:
        raise ValueError(f"--output {path}: expected a file name that ends in {suffix}")
    if path.is_dir() or path.is_symlink() or (path.exists() and not path.is_file()):
        raise ValueError(f"--output {path}: is a folder, link or device; name a file to be written")
    if path.resolve() == scenario.resolve():
        raise ValueError(f"--output {path}: is the scenario; name another file")
