"""A gate report for others to read: JUnit XML and annotations for GitHub."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from .report import GateReport, broken, overridden

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from .report import GateReport


@dataclass(frozen=True)
class BadInput:
    """A scenario that could not be checked, and why."""

    path: Path
    message: str


def tally(outcomes: Sequence[GateReport | BadInput]) -> str:
    """Return what the checks of several scenarios come to."""
    bad = sum(isinstance(outcome, BadInput) for outcome in outcomes)
    passed = sum(not isinstance(outcome, BadInput) and outcome.passed for outcome in outcomes)
    counts = {"passed": passed, "FAILED": len(outcomes) - passed - bad, "could not be checked": bad}
    listed = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    return f"{len(outcomes)} scenarios: {listed}"


def github_lines(report: GateReport) -> list[str]:
    """Return workflow commands that mark a report's failures and notes on the scenario file."""
    title = f"jounce check: {_title(report)}"
    if report.unstable:
        return [_annotation("error", report, title, report.unstable)]
    lines = [_annotation("error", report, title, report.missing)] * bool(report.missing)
    lines += [_annotation("error", report, title, row.message) for row in report.failures]
    if report.notes and not report.update:
        messages = [row.message for row in report.notes]
        remedy = "" if broken(report) or report.overrides else "; store it with --update"
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
    return f"{outcome.title}{overridden(outcome)}"


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


def _annotation(level: str, report: GateReport, title: str, message: str) -> str:
    file = _property(report.path.as_posix())
    return f"::{level} file={file},title={_property(title)}::{_data(message)}"


def _data(text: str) -> str:
    """Escape the text of a workflow command, as GitHub's own toolkit does."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
