"""The figures of Thompson's "Snap, Crackle, and Pop", by their numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .paper_loops import figure_7, figure_8, figure_10
from .paper_moves import figure_1, figure_2, figure_3, figure_4, figure_6

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "FIGURES",
    "figure_1",
    "figure_2",
    "figure_3",
    "figure_4",
    "figure_6",
    "figure_7",
    "figure_8",
    "figure_10",
]

FIGURES: dict[int, Callable[[], Figure]] = {
    1: figure_1,
    2: figure_2,
    3: figure_3,
    4: figure_4,
    6: figure_6,
    7: figure_7,
    8: figure_8,
    10: figure_10,
}
"""What draws each figure, by the figure's number in the paper."""
