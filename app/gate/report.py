"""A gate report: what the gate found, and as a table and text."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions
from rich.table import Table
from rich.text import Text

from ...shaping.told import table
from .baseline import Baseline
from .comparison import FAILURES, NOTES, Row, Verdict
from .conditions import Change

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from .comparison import Row
    from .conditions import Change


_COLUMNS = ("", "was", "is", "allowed", "verdict")
_COLOURS = ("bold red", "green", "")
_QUIET: tuple[Verdict, ...] = ("unsure", "same", "within", "unchecked")
_ORDER = (*FAILURES, *NOTES, *_QUIET)
_QUIET_WORDS = {
    "unsure": "within bounds by less than their error",
    "same": "the same",
    "within": "within bounds",
    "unchecked": "unchecked",
}
_WIDTH = 160
_WIDEST = 10_000


@dataclass(frozen=True)
class GateTable:
    """Was, is, allowed and verdict of each row: failures first, then notes.

    Where a console is too narrow for that, each row is a sentence.
    """

    rows: Sequence[Row | Change]
    title: str

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table | Text]:
        """Yield the title, then the table or the sentences."""
        ordered = sorted(self.rows, key=lambda row: _urgency(row.verdict))
        table = _table(ordered)
        wanted = console.measure(table, options=options.update(max_width=_WIDEST)).maximum
        yield Text(self.title, "bold")
        if wanted <= options.max_width or options.max_width >= _WIDTH:
            yield table
            return
        for row in ordered:
            yield Text(row.message, _COLOURS[_urgency(row.verdict)], overflow="fold")


def _table(rows: Sequence[Row | Change]) -> Table:
    table = Table(box=SIMPLE_HEAD)
    for i, column in enumerate(_COLUMNS):
        table.add_column(column, justify="right" if 0 < i < 4 else "left", overflow="fold")
    for row in rows:
        verdict = Text(row.verdict, _COLOURS[_urgency(row.verdict)])
        texts = (row.name, row.was_shown, row.now_shown, row.allowed)
        table.add_row(*map(Text, texts), verdict)
    return table


def shown_rows(
    report: GateReport, *, everything: bool, brief: bool = False
) -> tuple[tuple[Row | Change, ...], str]:
    """Return what changed and the rows to show, and a line that counts those left out.

    Where a check fails, or a `brief` report is wanted, what is as it should be is left out,
    unless `everything` is asked for.
    """
    left_out = Counter(row.verdict for row in report.rows if row.verdict in _QUIET)
    if everything or not left_out or (report.passed and not brief):
        return report.entries, ""
    shown = tuple(each for each in report.entries if each.verdict not in _QUIET)
    if not shown:
        return (), ""
    counts = [(left_out[verdict], _QUIET_WORDS[verdict]) for verdict in _QUIET if left_out[verdict]]
    (first, words), *others = counts
    listed = [f"{first} number{'s' * (first != 1)} {words}", *(f"{n} {w}" for n, w in others)]
    return shown, f"and {', '.join(listed)} (--all shows them)"


def summary(report: GateReport) -> str:
    """Return what a report comes to, in a line or a few."""
    if report.unstable:
        return f"FAILED: {report.unstable}"
    verdicts = Counter(row.verdict for row in report.rows)
    listed = ", ".join(f"{verdicts[verdict]} {verdict}" for verdict in _ORDER if verdicts[verdict])
    changed = sum(each not in report.rows for each in report.failures)
    failed = len(report.failures) - changed
    counts = [f"{changed} condition{'s' * (changed != 1)} changed"] * bool(changed)
    counts.append(f"{f'{failed} of ' * bool(failed)}{len(report.rows)} numbers ({listed})")
    outcome = "FAILED: " if report.failures else "Passed: " if report.passed else ""
    missing = [f"FAILED: {report.missing}"] * bool(report.missing)
    return "\n".join([*missing, f"{outcome}{', '.join(counts)}", *_remedies(report)])


def _remedies(report: GateReport) -> list[str]:
    """Return what to do about a report's failures and notes."""
    if report.update:
        return ["Nothing is stored while a bound is broken"] * broken(report)
    if broken(report) or report.overrides or not (report.failures or report.notes):
        return []
    asked = "asked and " if any(each not in report.rows for each in report.failures) else ""
    return [f"To accept what is {asked}measured, store it with --update"]


def broken(report: GateReport) -> bool:
    """Whether a bound is broken, so that `--update` would store nothing."""
    return any(row.verdict == "outside" for row in report.rows)


def report_text(report: GateReport) -> str:
    """Return a report as plain text: its table and what it comes to."""
    parts = [table_text(report.entries, heading(report))] if report.entries else []
    return "\n".join([*parts, summary(report)])


def heading(report: GateReport, *, file: bool = False) -> str:
    """Return the table's title, with the scenario's file where that is wanted."""
    title = f"{report.title} ({report.path})" if file else report.title
    return f"Check of {title}, positions in {report.position_unit}{overridden(report)}"


def overridden(report: GateReport) -> str:
    """Return what was given in place of the file's own, behind a title."""
    return f", with {'; '.join(report.overrides)}" if report.overrides else ""


def table_text(rows: Sequence[Row | Change], title: str) -> str:
    """Return a table as plain text, without trailing spaces."""
    text = StringIO()
    Console(file=text, width=_WIDTH, color_system=None).print(GateTable(rows, title))
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def _urgency(verdict: str) -> int:
    return 0 if verdict in FAILURES else 1 if verdict in (*NOTES, "redesigned") else 2


@dataclass(frozen=True, repr=False)
class GateReport:
    """What the gate found.

    Attributes
    ----------
    title : str
        The scenario's.
    path : Path
        The scenario's file.
    position_unit : str
        The unit of positions in `rows`.
    rows : tuple of Row
        One for every number, measured or stored; none where the loop is unstable.
    unstable : str
        What is wrong with an unstable loop; empty for a stable one.
    measured : Baseline or None
        What was measured, to be stored; None where the loop is unstable.
    update : bool
        Whether the baseline is about to be replaced, so that only the bounds count.
    changes : tuple of Change
        What the numbers depend on and is not as it was stored: conditions, and the design.
    missing : str
        What to do about a baseline that is missing; empty where it is there, or need not be.
    overrides : tuple of str
        What was given in place of the file's own, as ``key = value``.
    """

    title: str
    path: Path
    position_unit: str
    rows: tuple[Row, ...]
    unstable: str = ""
    measured: Baseline | None = None
    update: bool = False
    changes: tuple[Change, ...] = ()
    missing: str = ""
    overrides: tuple[str, ...] = ()

    @property
    def entries(self) -> tuple[Row | Change, ...]:
        """All that there is to show: what changed, then the rows."""
        return (*self.changes, *self.rows)

    @property
    def failures(self) -> tuple[Row | Change, ...]:
        """What fails: changed conditions, and rows out of bounds, worse, changed or gone."""
        failing = ("outside",) if self.update else FAILURES
        return tuple(each for each in self.entries if each.verdict in failing)

    @property
    def notes(self) -> tuple[Row, ...]:
        """The rows that pass, but that a new baseline would settle: better and new."""
        return tuple(row for row in self.rows if row.verdict in NOTES)

    @property
    def passed(self) -> bool:
        """Whether the loop is stable, its baseline there, and nothing fails."""
        return not (self.unstable or self.missing or self.failures)

    def _repr_html_(self) -> str:
        """Return the verdict as a table: what is wrong, then each number that fails or changed."""
        rows = [("passed", "yes" if self.passed else "no"), ("numbers", str(len(self.rows)))]
        rows += [
            (name, getattr(self, name)) for name in ("unstable", "missing") if getattr(self, name)
        ]
        rows += [
            (each.name, f"{each.was_shown} → {each.now_shown}: {each.verdict}")
            for each in (*self.failures, *self.notes)
        ]
        return table(self.title, rows)

    def __repr__(self) -> str:
        return f"GateReport({self.title!r}, rows={len(self.rows)}, passed={self.passed})"

    def __str__(self) -> str:
        return report_text(self)
