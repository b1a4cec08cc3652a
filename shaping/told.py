"""Results told briefly: a line or two in a console, a small table in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_LONGEST = 60  # characters of a part
_FEW = 4  # numbers that are told one by one

Rows = Iterable[tuple[str, Any]]


class Told:
    """A result whose arrays are told by their shapes, and that a notebook shows as a table.

    What is None or nan is left out of the line.

    A dataclass that is told so has `repr=False`; one with a `__repr__` of its own keeps that.
    """

    def __repr__(self) -> str:
        known = ((name, brief(value)) for name, value in fields_of(self))
        told = (f"{name}={text}" for name, text in known if text not in ("nan", "None"))
        return f"{type(self).__name__}({', '.join(told)})"

    def _repr_html_(self) -> str:
        return table(type(self).__name__, self.table_rows(), self.picture())

    def table_rows(self) -> Rows:
        """Return the rows of the table: names and values."""
        return fields_of(self)

    def picture(self) -> str:
        """Return a picture beside the table, as SVG; empty for none."""
        return ""


def fields_of(noun: Any) -> Rows:
    """Return names and values of the fields that a dataclass shows."""
    return [(field.name, getattr(noun, field.name)) for field in fields(noun) if field.repr]


def brief(value: Any) -> str:
    """Return a value on one short line: arrays by their shape, nouns by their name."""
    if isinstance(value, np.ndarray) and value.size > _FEW:
        return f"<{' × '.join(map(str, value.shape))} array>"
    if isinstance(value, np.ndarray):
        return brief(value.tolist())
    if isinstance(value, float | np.floating):
        return f"{value:.7g}"
    if isinstance(value, complex):
        return f"{value:.5g}"
    if isinstance(value, Mapping):
        return _counted("{", [f"{key!r}: {brief(value[key])}" for key in value], "}")
    if isinstance(value, list | tuple) and not hasattr(value, "_fields"):
        return _counted("(", [brief(part) for part in value], ",)" if len(value) == 1 else ")")
    if is_dataclass(value):
        told = repr(value) if type(value).__repr__ is not Told.__repr__ else ""
        return told if 0 < len(told) <= _LONGEST else f"{type(value).__name__}(…)"
    told = " ".join(repr(value).split())
    return told if len(told) <= _LONGEST else f"{told[: _LONGEST - 2]} …"


def _counted(left: str, parts: Sequence[str], right: str) -> str:
    """Return parts in brackets; of many, or long ones, how many there are."""
    whole = f"{left}{', '.join(parts)}{right}"
    if len(whole) <= _LONGEST:
        return whole
    return f"{left}{len(parts)} of them{right[-1]}"


def table(title: str, rows: Rows, picture: str = "") -> str:
    """Return a table in HTML, of two columns under a title, a picture below."""
    from html import escape  # asked for by notebooks alone

    lines = (
        f"<tr><th style='text-align:left'>{escape(str(name))}</th>"
        f"<td style='text-align:left'>{escape(value if isinstance(value, str) else brief(value))}"
        "</td></tr>"
        for name, value in rows
    )
    caption = f"<caption style='text-align:left'><b>{escape(title)}</b></caption>"
    return f"<table>{caption}{''.join(lines)}</table>{picture}"


def curve(values: Sequence[float], label: str) -> str:
    """Return numbers at equal distances as a small curve in SVG."""
    from html import escape

    low, high = min(values), max(values)
    span, last = (high - low) or 1.0, max(len(values) - 1, 1)
    points = " ".join(
        f"{5.0 + 230.0 * i / last:.1f},{55.0 - 50.0 * (value - low) / span:.1f}"
        for i, value in enumerate(values)
    )
    return (
        "<svg width='240' height='60' role='img' xmlns='http://www.w3.org/2000/svg'>"
        f"<title>{escape(label)}</title>"
        f"<polyline points='{points}' fill='none' stroke='#0072b2' stroke-width='1.5'/></svg>"
    )
