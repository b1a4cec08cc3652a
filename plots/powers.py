"""Labels of logarithmic axes as plain text, 10⁻³: matplotlib's own take a parser of mathematics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.ticker import LogFormatterSciNotation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BEFORE, _BEHIND = r"$\mathdefault{", "}$"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class PlainPowers(LogFormatterSciNotation):
    """Powers of ten, and their multiples on short axes, in superscript digits."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick; empty for those that have none."""
        told = super().__call__(x, pos).removeprefix(_BEFORE).removesuffix(_BEHIND)
        base, _, power = told.replace(r"\times", "×").partition("^")
        return base.replace("-", "−") + power.strip("{}").translate(_RAISED)


def label_powers(ax: Axes) -> None:
    """Let the logarithmic ones of both axes have plain labels."""
    for axis in (ax.xaxis, ax.yaxis):
        if type(axis.get_major_formatter()) is LogFormatterSciNotation:
            axis.set_major_formatter(PlainPowers())
        if type(axis.get_minor_formatter()) is LogFormatterSciNotation:
            axis.set_minor_formatter(PlainPowers())
