"""Any content of a scenario file is taken or explained."""

import math
from pathlib import Path

from good_scenario import GOOD, inline
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from jounce.app.scenario import (
    Scenario,
    ScenarioError,
    load_scenario,
)
from jounce.app.scenario_messages import EXAMPLE

SCALARS = (
    st.text(max_size=20)
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.dates()
    | st.datetimes()
    | st.sampled_from(["1 deg", "1e308 kg m^2", "-1 Hz", "1e-320 mas", "12 dB", "axis", "design"])
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["kp", "inertia", "jerk", "axis"]), inner, max_size=2)
    ),
    max_leaves=4,
)
PLACES = [line for line in GOOD.splitlines() if " = " in line]


@seed(2)
@settings(max_examples=250, deadline=None, database=None)
@given(place=st.sampled_from(PLACES), value=VALUES)
def test_any_value_anywhere_is_taken_or_explained(tmp_path_factory, place, value):
    path = tmp_path_factory.getbasetemp() / "fuzz.toml"
    key = place.split(" = ")[0]
    path.write_text(GOOD.replace(place, f"{key} = {inline(value)}"), encoding="utf-8")
    assert_taken_or_explained(path)


@seed(3)
@settings(max_examples=150, deadline=None, database=None)
@given(key=st.sampled_from(sorted(EXAMPLE)), value=VALUES)
def test_any_section_is_taken_or_explained(tmp_path_factory, key, value):
    path = tmp_path_factory.getbasetemp() / "fuzz.toml"
    sections = dict(EXAMPLE) | {key: value}
    text = "\n".join(f"{name} = {inline(section)}" for name, section in sections.items())
    path.write_text(text, encoding="utf-8")
    assert_taken_or_explained(path)


def assert_taken_or_explained(path: Path) -> None:
    try:
        scenario = load_scenario(path)
    except ScenarioError as error:
        lines = str(error).split("\n")
        if not all(line.startswith(f"{path}: ") for line in lines):
            raise AssertionError(lines) from None
    else:
        assert_finite(scenario)


def assert_finite(scenario: Scenario) -> None:
    numbers = [scenario.inertia, scenario.feedforward_inertia, scenario.inertia_error]
    numbers += [number for move in scenario.moves for number in (move.distance, move.settle_to)]
    assert all(math.isfinite(number) and number != 0.0 for number in numbers)
