"""A gate report as a table, as JUnit XML and as annotations for GitHub."""

from __future__ import annotations

from collections import Counter
from io import StringIO
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from .comparison import FAILURES, NOTES, Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from .check import GateReport
    from .comparison import Row

_COLUMNS = ("", "was", "is", "allowed", "verdict")
_COLOURS = ("bold red", "green", "")
_QUIET: tuple[Verdict, ...] = ("same", "within", "unchecked")
_ORDER = (*FAILURES, *NOTES, *_QUIET)
_QUIET_WORDS = {"same": "the same", "within": "within bounds", "unchecked": "unchecked"}
_WIDTH = 160


def gate_table(rows: Sequence[Row], title: str) -> Table:
    """Return was, is, allowed and verdict of each row: failures first, then notes."""
    table = Table(title=Text(title), title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for i, column in enumerate(_COLUMNS):
        table.add_column(column, justify="right" if 0 < i < 4 else "left", overflow="fold")
    for row in sorted(rows, key=lambda row: _urgency(row.verdict)):
        verdict = Text(row.verdict, _COLOURS[_urgency(row.verdict)])
        texts = (row.name, row.was_shown, row.now_shown, row.allowed)
        table.add_row(*map(Text, texts), verdict)
    return table


def shown_rows(report: GateReport, *, everything: bool) -> tuple[tuple[Row, ...], str]:
    """Return the rows to show, and a line that counts those left out.

    Where a check fails, what is as it should be is left out, unless `everything` is asked for.
    """
    left_out = Counter(row.verdict for row in report.rows if row.verdict in _QUIET)
    if everything or report.passed or not left_out:
        return report.rows, ""
    shown = tuple(row for row in report.rows if row.verdict not in _QUIET)
    counts = [(left_out[verdict], _QUIET_WORDS[verdict]) for verdict in _QUIET if left_out[verdict]]
    (first, words), *others = counts
    listed = [f"{first} number{'s' * (first != 1)} {words}", *(f"{n} {w}" for n, w in others)]
    return shown, f"and {', '.join(listed)} (--all shows them)"


def summary(report: GateReport) -> str:
    """Return what a report comes to, in a line or two."""
    if report.unstable:
        return f"FAILED: {report.unstable}"
    counts = Counter(row.verdict for row in report.rows)
    listed = ", ".join(f"{counts[verdict]} {verdict}" for verdict in _ORDER if counts[verdict])
    failed = len(report.failures)
    outcome = f"FAILED: {failed} of" if failed else "Passed:"
    return "\n".join([f"{outcome} {len(report.rows)} numbers ({listed})", *_remedies(report)])


def _remedies(report: GateReport) -> list[str]:
    """Return what to do about a report's failures and notes."""
    if report.update:
        return ["Nothing is stored while a bound of the check file is broken"] * _broken(report)
    if _broken(report) or all(row.verdict in _QUIET for row in report.rows):
        return []
    return ["To accept what is measured, store it with --update"]


def _broken(report: GateReport) -> bool:
    """Whether a bound is broken, so that `--update` would store nothing."""
    return any(row.verdict == "outside" for row in report.rows)


def report_text(report: GateReport) -> str:
    """Return a report as plain text: its table and what it comes to."""
    parts = [table_text(report.rows, heading(report))] if report.rows else []
    return "\n".join([*parts, summary(report)])


def heading(report: GateReport) -> str:
    """Return the table's title."""
    return f"Check of {report.title}, positions in {report.position_unit}"


def table_text(rows: Sequence[Row], title: str) -> str:
    """Return a table as plain text, without trailing spaces."""
    text = StringIO()
    Console(file=text, width=_WIDTH, color_system=None).print(gate_table(rows, title))
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def github_lines(report: GateReport) -> list[str]:
    """Return workflow commands that mark a report's failures and notes on the scenario file."""
    title = f"jounce check: {report.title}"
    if report.unstable:
        return [_annotation("error", report, title, report.unstable)]
    lines = [_annotation("error", report, title, row.message) for row in report.failures]
    if report.notes and not report.update:
        messages = [row.message for row in report.notes]
        remedy = "" if _broken(report) else "; store it with --update"
        heading = f"Better than the baseline, or not in it{remedy}:"
        lines.append(_annotation("warning", report, title, "\n".join([heading, *messages])))
    return lines


def github_error(message: str) -> str:
    """Return the workflow command that tells of bad input."""
    return f"::error ::{_data(message)}"


def junit_text(report: GateReport) -> str:
    """Return a report as JUnit XML: a test case for stability and for every number."""
    suite = _suite(report.title)
    _add_case(suite, report.path, "stable", ("failure", "unstable", report.unstable))
    failures = {row.key for row in report.failures}
    for row in report.rows:
        if row.verdict != "unchecked":
            failure = row.message if row.key in failures else ""
            _add_case(suite, report.path, row.name, ("failure", row.verdict, failure))
    return _document(suite)


def junit_error(scenario: Path, message: str) -> str:
    """Return JUnit XML that tells of bad input: a single test case, an error."""
    suite = _suite(str(scenario))
    _add_case(suite, scenario, "input", ("error", "bad input", message))
    return _document(suite)


def _suite(name: str) -> ElementTree.Element:
    return ElementTree.Element("testsuite", name=_xml(name), skipped="0", time="0")


def _document(suite: ElementTree.Element) -> str:
    suite.set("tests", str(len(suite)))
    for outcome in ("failure", "error"):
        suite.set(f"{outcome}s", str(len(suite.findall(f"testcase/{outcome}"))))
    root = ElementTree.Element("testsuites")
    root.append(suite)
    ElementTree.indent(root)
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{body}\n'


def _add_case(
    suite: ElementTree.Element, scenario: Path, name: str, outcome: tuple[str, str, str]
) -> None:
    """Add a test case with its outcome: tag, type and message, which is empty if it passes."""
    classname = _xml(f"jounce.check.{scenario.stem}")
    case = ElementTree.SubElement(suite, "testcase", classname=classname, name=name, time="0")
    tag, kind, message = outcome
    if message:
        text = _xml(message)
        ElementTree.SubElement(case, tag, type=kind, message=text).text = text


def _xml(text: str) -> str:
    """Return a text without the characters that XML has no way to write."""
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in text)


def _urgency(verdict: Verdict) -> int:
    return 0 if verdict in FAILURES else 1 if verdict in NOTES else 2


def _annotation(level: str, report: GateReport, title: str, message: str) -> str:
    file = _property(report.path.as_posix())
    return f"::{level} file={file},title={_property(title)}::{_data(message)}"


def _data(text: str) -> str:
    """Escape the text of a workflow command, as GitHub's own toolkit does."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
