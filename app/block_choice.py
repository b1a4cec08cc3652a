"""The blocks of a scenario that leave it, under one set of names, and what the commands say."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from . import cli


class BlockChoice(StrEnum):
    """What of a scenario `jounce fmu export` and `jounce export c` write."""

    TRAJECTORY = "trajectory"
    SHAPER = "shaper"
    FOLLOWER = "follower"
    FILTER = "filter"
    CONTROLLER = "controller"
    PLANT = "plant"
    LOOP = "loop"
    SERVO = "servo"


OF_A_MOVE = (
    BlockChoice.TRAJECTORY,
    BlockChoice.SHAPER,
    BlockChoice.FOLLOWER,
    BlockChoice.LOOP,
    BlockChoice.SERVO,
)
"""Blocks that need a move of the scenario: the one that is named, or else the first."""

_SHAPER = (
    "shaper: the move's input shaper for a sampled command, or else the follower, which keeps the "
    "move's limits on the way to any command"
)

BLOCK_AS_FMU = Annotated[
    BlockChoice,
    cli.Option(
        "--block",
        help=f"What to export. {_SHAPER}; loop: all together, as an .ssp; servo: the same as one "
        "FMU.",
    ),
]
BLOCK_AS_C = Annotated[
    BlockChoice,
    cli.Option("--block", help=f"What to export. {_SHAPER}; loop or servo: the whole loop."),
]


def check_move(block: BlockChoice, move: str | None) -> None:
    """Refuse a move for a block that belongs to none."""
    if move is not None and block not in OF_A_MOVE:
        raise ValueError(f"--move: a {block.value} belongs to no move; leave it out")
