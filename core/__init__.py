"""The core in C99, what is simulated and what is shipped: evaluation and planning of motions."""

from .binding import (
    CHATTER,
    FMI2_MARK,
    NO_DURATION,
    OK,
    RANGE,
    UNREACHABLE,
    Follower,
    Motion,
    Pieces,
    advance_lags,
    bounds,
    evaluate_lanes,
    fmi2_logger,
    move,
    move_durations,
    move_pieces,
    possible_durations,
    run_loop,
    together,
    transfer,
    transfer_lasting,
    transfer_pieces,
    transfers,
    velocity_transfer,
)

__all__ = [
    "CHATTER",
    "FMI2_MARK",
    "NO_DURATION",
    "OK",
    "RANGE",
    "UNREACHABLE",
    "Follower",
    "Motion",
    "Pieces",
    "advance_lags",
    "bounds",
    "evaluate_lanes",
    "fmi2_logger",
    "move",
    "move_durations",
    "move_pieces",
    "possible_durations",
    "run_loop",
    "together",
    "transfer",
    "transfer_lasting",
    "transfer_pieces",
    "transfers",
    "velocity_transfer",
]


def __dir__() -> list[str]:
    return sorted(__all__)
