"""A report's formats: nothing cut off, nothing that a reader of the format would stumble over."""

import math
from dataclasses import replace
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree

import pytest
from rich.console import Console

from jounce.app.gate.ci_reports import (
    BadInput,
    github_error,
    github_lines,
    junit_error,
    junit_text,
    tally,
)
from jounce.app.gate.comparison import Row
from jounce.app.gate.conditions import Change
from jounce.app.gate.report import (
    GateReport,
    GateTable,
    report_text,
    shown_rows,
    summary,
    table_text,
)

INF = math.inf
SAME = Row(("margins", "disk_margin"), 0.7, 0.7, 0.69, INF, "same")
WORSE = Row(("moves", '[b]<50 %>, "a": é\\😀[/b]', "peak_error"), 1.0, 2.0, -INF, 1.0, "worse")
BETTER = Row(("step", "overshoot_percent"), 40.0, 39.0, -INF, 40.0, "better")
NEW = Row(("step", "rise_time_s"), None, 0.1, -INF, INF, "new")
OUTSIDE = Row(("margins", "phase_margin_deg"), 45.0, 43.0, 44.0, INF, "outside")
UNCHECKED = Row(("margins", "crossover_hz"), None, 1.0, -INF, INF, "unchecked")
WITHIN = Row(("step", "settling_time_s"), None, 1.0, -INF, 2.0, "within")
NAME = WORSE.name


def report(*rows: Row, **changes) -> GateReport:
    made = GateReport("Axis [1]: 100 %, <&>", Path("a folder/axis,1.toml"), "mm", rows)
    return replace(made, **changes)


def test_the_table_has_failures_first_then_notes_and_cuts_nothing():
    text = table_text([SAME, BETTER, WORSE], "Title [x] :cat:")
    assert "Title [x] :cat:" in text
    places = [text.index(row.name) for row in (WORSE, BETTER, SAME)]
    assert places == sorted(places)
    row = next(line for line in text.splitlines() if NAME in line)
    assert row.split()[-5:] == ["1", "2", "<=", "1", "worse"]


def test_a_long_name_is_folded_not_cut():
    name = "long " * 60
    text = table_text([replace(SAME, key=("moves", name, "duration_s"))], "Title")
    assert "…" not in text
    assert text.count("g") == 60  # nothing else on the page has this letter


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (report(SAME), "Passed: 1 numbers (1 same)"),
        (report(SAME, WORSE), "FAILED: 1 of 2 numbers (1 worse, 1 same)\nTo "
         "accept what is measured, store it with --update"),
        (report(SAME, WORSE, OUTSIDE), "FAILED: 2 of 3 numbers (1 outside, 1 worse, 1 same)"),
        (report(OUTSIDE, NEW), "FAILED: 1 of 2 numbers (1 outside, 1 new)"),
        (report(OUTSIDE), "FAILED: 1 of 1 numbers (1 outside)"),
        (report(SAME, BETTER, NEW), "Passed: 3 numbers (1 better, 1 new, 1 same)\nTo accept what "
         "is measured, store it with --update"),
        (report(WORSE, update=True), "Passed: 1 numbers (1 worse)"),
        (report(WORSE, OUTSIDE, update=True), "FAILED: 1 of 2 numbers (1 outside, 1 worse)\n"
         "Nothing is stored while a bound is broken"),
        (report(unstable="axis.toml: UNSTABLE"), "FAILED: axis.toml: UNSTABLE"),
    ],
    ids=["same", "worse", "worse-outside", "new-outside", "outside", "better", "update",
         "update-outside", "unstable"],
)  # fmt: skip
def test_the_summary(found, text):
    assert summary(found) == text
    assert report_text(found).endswith(text)


@pytest.mark.parametrize(
    ("rows", "shown", "line"),
    [
        ([SAME, BETTER], [SAME, BETTER], ""),
        ([SAME, WORSE, BETTER], [WORSE, BETTER], "and 1 number the same (--all shows them)"),
        ([SAME] * 27 + [WORSE], [WORSE], "and 27 numbers the same (--all shows them)"),
        ([UNCHECKED, OUTSIDE, WITHIN, UNCHECKED], [OUTSIDE],
         "and 1 number within bounds, 2 unchecked (--all shows them)"),
        ([WORSE], [WORSE], ""),
    ],
    ids=["passing", "failing", "many", "bounds-alone", "nothing-left-out"],
)  # fmt: skip
def test_a_failing_check_shows_what_is_to_be_seen(rows, shown, line):
    assert shown_rows(report(*rows), everything=False) == (tuple(shown), line)
    assert shown_rows(report(*rows), everything=True) == (tuple(rows), "")


def test_annotations_are_escaped():
    (line,) = github_lines(report(SAME, WORSE))
    assert line == (
        "::error file=a folder/axis%2C1.toml,title=jounce check%3A Axis [1]%3A 100 %25%2C <&>::"
        r'moves."[b]<50 %25>, \"a\": é\\😀[/b]".peak_error is 2, was 1: worse; allowed <= 1'
    )


def test_notes_are_one_warning():
    (line,) = github_lines(report(BETTER, NEW))
    assert line.startswith("::warning file=")
    assert line.count("%0A") == 2
    assert "\n" not in line
    assert github_lines(report(BETTER, NEW, update=True)) == []


def test_nothing_says_to_store_what_update_would_refuse():
    for lines in (github_lines(report(OUTSIDE, NEW)), [summary(report(OUTSIDE, NEW, WORSE))]):
        assert "--update" not in "\n".join(lines)
    assert "--update" in "\n".join(github_lines(report(WORSE, NEW)))


def test_bad_input_is_one_error():
    assert github_error("a: 5 %\nb") == "::error ::a: 5 %25%0Ab"
    root = ElementTree.fromstring(junit_error(Path("a folder/axis.toml"), "a <b>\nc"))
    (suite,) = root
    assert [suite.get(key) for key in ("tests", "failures", "errors", "skipped")] == list("1010")
    (case,) = suite
    assert case.get("classname") == "jounce.check.axis"
    assert case.find("error").get("type") == "bad input"
    assert case.find("error").text == case.find("error").get("message") == "a <b>\nc"


def test_an_unstable_loop_is_annotated():
    (line,) = github_lines(report(unstable="a\r\nb"))
    assert line.startswith("::error file=")
    assert line.endswith("::a%0D%0Ab")


def test_junit_has_a_case_for_every_number():
    text = junit_text(report(SAME, WORSE, BETTER, NEW, UNCHECKED))
    assert text.startswith('<?xml version="1.0" encoding="utf-8"?>\n')
    root = ElementTree.fromstring(text)
    (suite,) = root
    assert (root.tag, suite.tag) == ("testsuites", "testsuite")
    assert suite.get("name") == "Axis [1]: 100 %, <&>"
    assert [suite.get(key) for key in ("tests", "failures", "errors", "skipped")] == list("5100")
    assert [case.get("name") for case in suite] == [
        "stable",
        *(r.name for r in (SAME, WORSE, BETTER, NEW)),
    ]
    assert {case.get("classname") for case in suite} == {"jounce.check.axis,1"}
    (failure,) = suite.iter("failure")
    assert failure.get("type") == "worse"
    assert failure.get("message") == failure.text == WORSE.message


def test_junit_tells_of_an_unstable_loop():
    (suite,) = ElementTree.fromstring(junit_text(report(unstable="UNSTABLE, pole at 1")))
    (case,) = suite
    assert (suite.get("failures"), case.get("name")) == ("1", "stable")
    assert case.find("failure").text == "UNSTABLE, pole at 1"


def test_junit_of_an_update_fails_on_bounds_alone():
    (suite,) = ElementTree.fromstring(junit_text(report(WORSE, OUTSIDE, update=True)))
    assert [failure.get("type") for failure in suite.iter("failure")] == ["outside"]


@pytest.mark.parametrize("text", ["\x00\x1b[31m\ud800\ufffe", "a\nb"], ids=["control", "line"])
def test_junit_is_xml_whatever_the_title_and_path(text):
    found = report(SAME, title=text, path=Path(f"{text}.toml"), unstable=text)
    (suite,) = ElementTree.fromstring(junit_text(found).encode("utf-8"))
    assert suite.tag == "testsuite"
    assert suite.find(".//failure") is not None


CHANGED = Change(("moves", "go", "settle_to"), "0.05 arcsec", "0.5 arcsec")
REDESIGNED = Change(("feedforward", "inertia"), "2 kg", "3 kg")
ACCEPT = "\nTo accept what is asked and measured, store it with --update"


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (report(BETTER, changes=(CHANGED,)),
         f"FAILED: 1 condition changed, 1 numbers (1 better){ACCEPT}"),
        (report(SAME, WORSE, changes=(CHANGED, CHANGED)),
         f"FAILED: 2 conditions changed, 1 of 2 numbers (1 worse, 1 same){ACCEPT}"),
        (report(SAME, changes=(REDESIGNED,)), "Passed: 1 numbers (1 same)"),
        (report(SAME, changes=(CHANGED,), update=True), "Passed: 1 numbers (1 same)"),
        (report(SAME, changes=(CHANGED,), overrides=("a = 1",)),
         "FAILED: 1 condition changed, 1 numbers (1 same)"),
        (report(WITHIN, missing="b.json is missing"),
         "FAILED: b.json is missing\n1 numbers (1 within)"),
        (report(OUTSIDE, missing="b.json is missing"),
         "FAILED: b.json is missing\nFAILED: 1 of 1 numbers (1 outside)"),
    ],
    ids=["loosened", "both", "redesigned", "update", "override", "missing", "missing-outside"],
)  # fmt: skip
def test_the_summary_counts_conditions(found, text):
    assert summary(found) == text
    assert found.passed == text.startswith("Passed")
    assert report_text(found).endswith(text)


def test_the_table_shows_what_changed_with_units():
    text = table_text([SAME, BETTER, REDESIGNED, CHANGED], "Title")
    lines = [line.split() for line in text.splitlines()]
    row = [CHANGED.name, "0.05", "arcsec", "0.5", "arcsec", "changed"]
    assert row in lines
    assert ["feedforward.inertia", "2", "kg", "3", "kg", "redesigned"] in lines
    assert lines.index(row) < next(i for i, line in enumerate(lines) if BETTER.name in line)


def test_annotations_and_junit_tell_of_conditions():
    found = report(SAME, changes=(CHANGED, REDESIGNED), missing="b.json is missing")
    sentence = (
        "moves.go.settle_to is 0.5 arcsec, was 0.05 arcsec: changed, and numbers depend on it"
    )
    missing, changed = github_lines(found)
    assert missing.endswith("::b.json is missing")
    assert changed.startswith("::error file=")
    assert changed.endswith(f"::{sentence}")
    (suite,) = ElementTree.fromstring(junit_text(found))
    assert [suite.get(key) for key in ("tests", "failures", "errors")] == list("420")
    assert [case.get("name") for case in suite] == [
        "stable",
        "baseline",
        "moves.go.settle_to",
        "margins.disk_margin",
    ]
    assert [failure.text for failure in suite.iter("failure")] == ["b.json is missing", sentence]


def test_an_override_is_named_wherever_the_report_goes():
    found = report(WORSE, overrides=("limits.axis.jerk = '3 deg/s^3'",))
    for text in (report_text(found), *github_lines(found), junit_text(found)):
        assert "with limits.axis.jerk = '3 deg/s^3'" in " ".join(text.split())


def test_a_narrow_console_has_sentences():
    """No name of a number is broken, though it be longer than a column."""
    rows = [SAME, WORSE, replace(BETTER, key=("moves", "60 arcsec step", "varied_peak_error"))]
    for width, table in ((160, True), (120, True), (60, False)):
        out = StringIO()
        Console(file=out, width=width, color_system=None).print(GateTable(rows, "Title"))
        text = out.getvalue()
        assert ("allowed   verdict" in text) == table
        assert max(map(len, text.splitlines())) <= width
        assert 'moves."60 arcsec step".varied_peak_error' in text
    assert text.index("worse") < text.index("better") < text.index("same")


def test_junit_has_a_suite_for_each_scenario():
    found = report(SAME), report(WORSE, path=Path("b/axis,1.toml"))
    text = junit_text(*found, BadInput(Path("c.toml"), "broken"))
    suites = list(ElementTree.fromstring(text))
    assert [suite.get("name") for suite in suites] == [
        "Axis [1]: 100 %, <&> (a folder/axis,1.toml)",
        "Axis [1]: 100 %, <&> (b/axis,1.toml)",
        "c.toml",
    ]
    assert [suite.get("failures") + suite.get("errors") for suite in suites] == ["00", "10", "01"]
    classes = [{case.get("classname") for case in suite} for suite in suites]
    assert classes == [
        {"jounce.check.a folder/axis,1"},
        {"jounce.check.b/axis,1"},
        {"jounce.check.c"},
    ]


def test_the_tally_counts_scenarios():
    bad = BadInput(Path("c.toml"), "broken")
    assert tally([report(SAME), report(BETTER)]) == "2 scenarios: 2 passed"
    assert tally([bad, report(WORSE), report(SAME)]) == (
        "3 scenarios: 1 passed, 1 FAILED, 1 could not be checked"
    )
