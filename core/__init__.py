"""The core in C99, what is simulated and what is shipped: evaluation and planning of motions."""

from .binding import (
    NO_DURATION,
    OK,
    RANGE,
    UNREACHABLE,
    Follower,
    Motion,
    Pieces,
    advance_lags,
    evaluate_lanes,
    move,
    possible_durations,
    transfer,
    transfer_lasting,
    transfer_pieces,
    transfers,
    velocity_transfer,
)

__all__ = [
    "NO_DURATION",
    "OK",
    "RANGE",
    "UNREACHABLE",
    "Follower",
    "Motion",
    "Pieces",
    "advance_lags",
    "evaluate_lanes",
    "move",
    "possible_durations",
    "transfer",
    "transfer_lasting",
    "transfer_pieces",
    "transfers",
    "velocity_transfer",
]
