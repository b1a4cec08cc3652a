"""A gate report as a table, as JUnit XML and as annotations for GitHub."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions
from rich.table import Table
from rich.text import Text

from .comparison import FAILURES, NOTES, Verdict

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from .check import GateReport
    from .comparison import Row
    from .conditions import Change

_COLUMNS = ("", "was", "is", "allowed", "verdict")
_COLOURS = ("bold red", "green", "")
_QUIET: tuple[Verdict, ...] = ("same", "within", "unchecked")
_ORDER = (*FAILURES, *NOTES, *_QUIET)
_QUIET_WORDS = {"same": "the same", "within": "within bounds", "unchecked": "unchecked"}
_WIDTH = 160
_WIDEST = 10_000


@dataclass(frozen=True)
class BadInput:
    """A scenario that could not be checked, and why."""

    path: Path
    message: str


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


def tally(outcomes: Sequence[GateReport | BadInput]) -> str:
    """Return what the checks of several scenarios come to."""
    bad = sum(isinstance(outcome, BadInput) for outcome in outcomes)
    passed = sum(not isinstance(outcome, BadInput) and outcome.passed for outcome in outcomes)
    counts = {"passed": passed, "FAILED": len(outcomes) - passed - bad, "could not be checked": bad}
    listed = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    return f"{len(outcomes)} scenarios: {listed}"


def _remedies(report: GateReport) -> list[str]:
    """Return what to do about a report's failures and notes."""
    if report.update:
        return ["Nothing is stored while a bound of the check file is broken"] * _broken(report)
    if _broken(report) or report.overrides or not (report.failures or report.notes):
        return []
    asked = "asked and " if any(each not in report.rows for each in report.failures) else ""
    return [f"To accept what is {asked}measured, store it with --update"]


def _broken(report: GateReport) -> bool:
    """Whether a bound is broken, so that `--update` would store nothing."""
    return any(row.verdict == "outside" for row in report.rows)


def report_text(report: GateReport) -> str:
    """Return a report as plain text: its table and what it comes to."""
    parts = [table_text(report.entries, heading(report))] if report.entries else []
    return "\n".join([*parts, summary(report)])


def heading(report: GateReport, *, file: bool = False) -> str:
    """Return the table's title, with the scenario's file where that is wanted."""
    title = f"{report.title} ({report.path})" if file else report.title
    return f"Check of {title}, positions in {report.position_unit}{_overridden(report)}"


def _overridden(report: GateReport) -> str:
    return f", with {'; '.join(report.overrides)}" if report.overrides else ""


def table_text(rows: Sequence[Row | Change], title: str) -> str:
    """Return a table as plain text, without trailing spaces."""
    text = StringIO()
    Console(file=text, width=_WIDTH, color_system=None).print(GateTable(rows, title))
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


def github_lines(report: GateReport) -> list[str]:
    """Return workflow commands that mark a report's failures and notes on the scenario file."""
    title = f"jounce check: {_title(report)}"
    if report.unstable:
        return [_annotation("error", report, title, report.unstable)]
    lines = [_annotation("error", report, title, report.missing)] * bool(report.missing)
    lines += [_annotation("error", report, title, row.message) for row in report.failures]
    if report.notes and not report.update:
        messages = [row.message for row in report.notes]
        remedy = "" if _broken(report) or report.overrides else "; store it with --update"
        heading = f"Better than the baseline, or not in it{remedy}:"
        lines.append(_annotation("warning", report, title, "\n".join([heading, *messages])))
    return lines


def github_error(message: str) -> str:
    """Return the workflow command that tells of bad input."""
    return f"::error ::{_data(message)}"


def junit_text(*outcomes: GateReport | BadInput) -> str:
    """Return the outcomes of checks as JUnit XML, each a suite.

    A suite has a test case for stability, every changed condition and every number, and where
    the baseline is missing one that says so. Where a scenario could not be checked it is a
    single case, an error.
    """
    stems = Counter(outcome.path.stem for outcome in outcomes)
    titles = Counter(_title(outcome) for outcome in outcomes)
    root = ElementTree.Element("testsuites")
    for outcome in outcomes:
        path, title = outcome.path, _title(outcome)
        name = title if titles[title] == 1 or title == str(path) else f"{title} ({path})"
        suite = ElementTree.SubElement(root, "testsuite", name=_xml(name), skipped="0", time="0")
        label = path.stem if stems[path.stem] == 1 else path.with_suffix("").as_posix()
        for case in _cases(outcome):
            _add_case(suite, _xml(f"jounce.check.{label}"), *case)
        suite.set("tests", str(len(suite)))
        for tag in ("failure", "error"):
            suite.set(f"{tag}s", str(len(suite.findall(f"testcase/{tag}"))))
    ElementTree.indent(root)
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{body}\n'


def junit_error(scenario: Path, message: str) -> str:
    """Return JUnit XML that tells of bad input: a single test case, an error."""
    return junit_text(BadInput(scenario, message))


def _title(outcome: GateReport | BadInput) -> str:
    if isinstance(outcome, BadInput):
        return str(outcome.path)
    return f"{outcome.title}{_overridden(outcome)}"


def _cases(outcome: GateReport | BadInput) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, tag, type and message of each test case; the message is empty if it passes."""
    if isinstance(outcome, BadInput):
        yield "input", "error", "bad input", outcome.message
        return
    yield "stable", "failure", "unstable", outcome.unstable
    if outcome.missing:
        yield "baseline", "failure", "missing", outcome.missing
    for each in outcome.entries:
        if each.verdict not in ("unchecked", "redesigned"):
            message = each.message if each in outcome.failures else ""
            yield each.name, "failure", each.verdict, message


def _add_case(
    suite: ElementTree.Element, classname: str, name: str, tag: str, kind: str, message: str
) -> None:
    case = ElementTree.SubElement(suite, "testcase", classname=classname, name=_xml(name), time="0")
    if message:
        text = _xml(message)
        ElementTree.SubElement(case, tag, type=kind, message=text).text = text


def _xml(text: str) -> str:
    """Return a text without the characters that XML has no way to write."""
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in text)


def _urgency(verdict: str) -> int:
    return 0 if verdict in FAILURES else 1 if verdict in (*NOTES, "redesigned") else 2


def _annotation(level: str, report: GateReport, title: str, message: str) -> str:
    file = _property(report.path.as_posix())
    return f"::{level} file={file},title={_property(title)}::{_data(message)}"


def _data(text: str) -> str:
    """Escape the text of a workflow command, as GitHub's own toolkit does."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
