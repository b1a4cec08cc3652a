"""Was, is and allowed: each verdict, and that allowed says what would pass."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from jounce.app.gate.baseline import Baseline, Stored
from jounce.app.gate.check_file import Checks, Requirement
from jounce.app.gate.comparison import FAILURES, NOTES, Row, compare, measured_baseline
from jounce.app.gate.numbers import Number

KEY = ("margins", "x")
INF, NAN = math.inf, math.nan


def row(was, now, better, *, rtol=1e-3, atol=0.0, asked=None, two_sided=False) -> Row:
    """Compare one number; was is None in the baseline where it is not finite."""
    stored = Stored(was if math.isfinite(was) else None, rtol, atol)
    checks = Checks(requirements={} if asked is None else {KEY: asked})
    number = Number(KEY, now, better)
    (found,) = compare([number], Baseline("s", "mm", {KEY: stored}), checks, two_sided=two_sided)
    return found


@pytest.mark.parametrize(
    ("was", "now", "better", "verdict", "allowed"),
    [
        (45.0, 45.0, "higher", "same", ">= 44.955"),
        (45.0, 44.96, "higher", "same", ">= 44.955"),
        (45.0, 44.0, "higher", "worse", ">= 44.955"),
        (45.0, 46.0, "higher", "better", ">= 44.955"),
        (45.0, INF, "higher", "better", ">= 44.955"),
        (INF, INF, "higher", "same", "none"),
        (INF, 60.0, "higher", "worse", "none"),
        (2.0, 2.1, "lower", "worse", "<= 2.002"),
        (2.0, 1.9, "lower", "better", "<= 2.002"),
        (2.0, INF, "lower", "worse", "<= 2.002"),
        (INF, 2.0, "lower", "better", ""),
        (1.0, 1.1, None, "changed", "0.999 to 1.001"),
        (1.0, 0.9, None, "changed", "0.999 to 1.001"),
        (1.0, NAN, None, "changed", "0.999 to 1.001"),
        (NAN, NAN, None, "same", "none"),
        (NAN, 1.0, None, "changed", "none"),
        (-1.0, -1.0005, None, "same", "-1.001 to -0.999"),
    ],
    ids=range(17),
)
def test_verdicts(was, now, better, verdict, allowed):
    found = row(was, now, better)
    assert (found.verdict, found.allowed) == (verdict, allowed)
    assert found.was == was or math.isnan(was)


@pytest.mark.parametrize(
    ("now", "asked", "verdict", "allowed"),
    [
        (43.0, Requirement(least=44.0), "outside", ">= 44"),
        (44.5, Requirement(least=44.0), "worse", ">= 44.955"),
        (45.0, Requirement(44.0, 50.0), "same", "44.955 to 50"),
        (51.0, Requirement(44.0, 50.0), "outside", "44 to 50"),
        (55.0, Requirement(least=50.0), "better", ">= 50"),
        (39.0, Requirement(most=40.0), "worse", ">= 44.955"),
        (44.5, Requirement(rtol=0.1), "same", ">= 40.5"),
        (44.5, Requirement(atol=0.5), "same", ">= 44.5"),
        (44.5, Requirement(atol=0.4), "worse", ">= 44.6"),
    ],
    ids=range(9),
)
def test_bounds_and_tolerances_of_the_check_file(now, asked, verdict, allowed):
    found = row(45.0, now, "higher", asked=asked)
    assert (found.verdict, found.allowed) == (verdict, allowed)


FINITE = st.floats(-1e6, 1e6)
VALUES = FINITE | st.just(INF)
SIZES = st.floats(0.0, 10.0)


@given(
    was=VALUES,
    now=VALUES,
    better=st.sampled_from(["higher", "lower", None]),
    tolerance=st.tuples(SIZES, SIZES),
    bounds=st.tuples(FINITE | st.just(-INF), FINITE | st.just(INF)).map(sorted),
    two_sided=st.booleans(),
)
@example(45.0, 39.0, "higher", (0.0, 0.0), [-INF, 40.0], False)
def test_allowed_says_what_would_pass(was, now, better, tolerance, bounds, two_sided):
    rtol, atol = tolerance
    asked = Requirement(*bounds)
    found = row(was, now, better, rtol=rtol, atol=atol, asked=asked, two_sided=two_sided)
    if better is None:
        was, now = (value if math.isfinite(value) else NAN for value in (was, now))
    fails = found.verdict in (*FAILURES, "better") if two_sided else found.verdict in FAILURES
    width = max(rtol * abs(was), atol) if math.isfinite(was) else 0.0
    edges = [found.least, found.most, was - width, was + width]
    if any(math.isclose(now, edge, rel_tol=1e-12, abs_tol=1e-12) for edge in edges):
        return  # the sum and the difference round apart
    neither = math.isnan(was) and math.isnan(now)
    allowed = found.least <= now <= found.most
    assert fails == (not allowed and not (neither and found.verdict == "same"))
    if asked.admits(now) and math.isfinite(was):
        assert (found.verdict == "same") == (abs(now - was) <= width)


def test_new_and_gone_are_told():
    baseline = Baseline("s", "mm", {("gone",): Stored(3.0, 0.0, 0.0)})
    new, gone = compare([Number(("new",), 2.0, None)], baseline, Checks())
    assert (new.verdict, new.was, new.now, new.allowed) == ("new", None, 2.0, "")
    assert (gone.verdict, gone.was, gone.now, gone.allowed) == ("gone", 3.0, None, "")
    assert gone.message == "gone was 3 and is measured no more"
    assert new.message == "new is 2: new"
    assert "gone" in FAILURES
    assert "new" in NOTES


def test_without_a_baseline_the_bounds_decide():
    numbers = [Number((name,), 2.0, "higher") for name in "abc"]
    checks = Checks(requirements={("a",): Requirement(least=1.0), ("b",): Requirement(least=3.0)})
    rows = compare(numbers, None, checks)
    assert [found.verdict for found in rows] == ["within", "outside", "unchecked"]
    assert [found.allowed for found in rows] == [">= 1", ">= 3", ""]


def test_a_message_tells_was_is_and_allowed():
    assert row(45.0, 44.0, "higher").message == (
        "margins.x is 44, was 45: worse; allowed >= 44.955"
    )


def test_a_change_in_the_last_digits_shows():
    found = row(1.0, 1.0 + 2**-50, None, rtol=0.0)
    assert found.verdict == "changed"
    assert found.was_shown != found.now_shown
    assert found.allowed == "1 to 1"


def test_tolerances_come_from_the_check_file_the_baseline_or_the_number():
    numbers = [Number((name,), 2.0, None, atol=1e-9) for name in "abc"]
    previous = Baseline("s", "mm", {("a",): Stored(2.0, 0.5, 0.25), ("b",): Stored(2.0, 0.5, 0.25)})
    asked = {("a",): Requirement(rtol=0.1, atol=0.0)}
    stored = measured_baseline(numbers, previous, Checks(None, asked), scenario="s").numbers
    assert stored["a",] == Stored(2.0, 0.1, 0.0)
    assert stored["b",] == Stored(2.0, 0.5, 0.25)
    assert stored["c",] == Stored(2.0, 1e-6, 1e-9)
    stored = measured_baseline(numbers, previous, Checks(1e-3, asked)).numbers
    assert [stored[name,].rtol for name in "abc"] == [0.1, 0.5, 1e-3]
    assert [stored[name,].atol for name in "abc"] == [0.0, 0.25, 1e-9]


@pytest.mark.parametrize(
    ("own", "stored", "general", "compared", "kept"),
    [
        (0.1, 0.5, 1e-3, 0.1, 0.1),
        (None, 0.5, 1e-3, 0.5, 0.5),
        (None, 1e-6, 1e-3, 1e-6, 1e-3),
        (None, 1e-6, None, 1e-6, 1e-6),
        (0.0, 0.5, 1e-3, 0.0, 0.0),
    ],
    ids=["own", "stored", "usual", "none", "own-zero"],
)
def test_the_tolerance_nearest_to_the_number_counts(own, stored, general, compared, kept):
    checks = Checks(general, {KEY: Requirement(rtol=own)})
    before = Baseline("s", "mm", {KEY: Stored(2.0, stored, 0.0)})
    number = Number(KEY, 2.0, None)
    (found,) = compare([number], before, checks)
    assert found.most - 2.0 == pytest.approx(2.0 * compared)
    assert measured_baseline([number], before, checks).numbers[KEY].rtol == kept


def test_what_does_not_exist_is_stored_as_none():
    stored = measured_baseline([Number(KEY, INF, "higher")], None, Checks())
    assert stored.numbers[KEY].value is None
