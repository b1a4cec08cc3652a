"""Integers of 64 bits: what goes in comes out, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
from handmade_fmus import Model, fmu

from jounce.fmu import FmuError, cosimulate, load_fmu

pytestmark = pytest.mark.usefixtures("nothing_left")

# y = u in integers alone, from the start on: n, m are inputs, back, too outputs; k a parameter
CODE = """
#include <stdint.h>
static int64_t n, back, k = 9007199254740993; static uint64_t m, too;
#define NOW (back = n, too = m)
fmi3Status fmi3SetInt64(fmi3Instance c, const fmi3ValueReference v[], size_t _, const fmi3Int64 x[],
    size_t s) { for (size_t i = 0; i < s; i++) { if (v[i] == 200) k = x[i]; else n = x[i]; }
    return fmi3OK; }
fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference v[], size_t c0,
    const fmi3UInt64 x[], size_t s) { m = x[0]; return fmi3OK; }
fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference v[], size_t c0, fmi3Int64 x[],
    size_t s) { NOW; for (size_t i = 0; i < s; i++) x[i] = v[i] == 200 ? k : v[i] ? back : n;
    return fmi3OK; }
fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference v[], size_t c0, fmi3UInt64 x[],
    size_t s) { NOW; x[0] = too; return fmi3OK; }
"""
WIDE = Model(
    "wide",
    inputs=("n", "m", "a"),
    outputs=("back", "too", "b"),
    parameters={"k": 9007199254740993},
    types={"n": "Int64", "m": "UInt64", "back": "Int64", "too": "UInt64", "k": "Int64"},
    step="y[2] = u[2];",
    epilogue=CODE,
)
LARGEST, SMALLEST, UNSIGNED = 2**63 - 1, -(2**63), 2**64 - 1
ODD = 2**53 + 1


@pytest.fixture
def block(tmp_path):
    with load_fmu(fmu(tmp_path, WIDE, "3.0")) as loaded:
        yield loaded


@pytest.mark.parametrize(("n", "m"), [(LARGEST, UNSIGNED), (SMALLEST, ODD), (-ODD, 2**63)])
def test_inputs_and_outputs(block, n, m):
    found = block.step({"n": n, "m": m, "a": 0.5})
    assert found.tolist() == [n, m, 0.5]
    assert (block.get("back"), block.get("too")) == (n, m)
    assert block.inputs.tolist() == [n, m, 0.5]
    assert block.step([n - 1 if n > 0 else n + 1, m, 0.25]).tolist()[0] == n - np.sign(n)
    assert block.step(np.array([n, m, 0.5], dtype=object)).tolist() == [n, m, 0.5]
    assert block.step({"n": np.int64(n), "m": np.uint64(m)}).tolist() == [n, m, 0.5]


def test_doubles_where_these_hold_them(block):
    found = block.step({"n": 2**60, "m": 7, "a": 0.5})
    assert found.dtype == float
    assert found.tolist() == [2.0**60, 7.0, 0.5]
    assert block.step(np.array([3.0, 4.0, 5.0])).tolist() == [3.0, 4.0, 5.0]


def test_parameters_and_start_values(block):
    assert block.parameters == {"k": ODD}
    block.set("k", LARGEST)
    assert block.get("k") == LARGEST
    block.reset({"k": SMALLEST, "n": ODD})
    assert (block.get("k"), block.inputs.tolist()[0]) == (SMALLEST, ODD)


def test_start_values_of_inputs(tmp_path):
    start = 'causality="input" variability="discrete" start='
    started = replace(WIDE, xml=((f'{start}"0"', f'{start}"{ODD}"'),))
    with load_fmu(fmu(tmp_path, started, "3.0")) as block:
        assert block.inputs.tolist() == [ODD, ODD, 0.0]
        assert block.step({"a": 1.0}).tolist() == [ODD, ODD, 1.0]


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"n": LARGEST + 1}, "n"),
        ({"n": SMALLEST - 1}, "n"),
        ({"m": UNSIGNED + 1}, "m"),
        ({"m": -1}, "m"),
        ({"n": 2.0**63}, "n"),
        ({"m": 0.5}, "m"),
        ({"m": np.nan}, "m"),
        ({"n": np.inf}, "n"),
        ([0, 2**70, 0.0], "m"),
    ],
)
def test_what_is_out_of_range_is_refused_by_name(block, given, name):
    block.step([1, 2, 3.0])
    with pytest.raises(FmuError, match=rf"^{name} = .*: expected whole numbers within .* u?int64"):
        block.step(given)
    assert block.step().tolist() == [1, 2, 3.0]


def test_a_parameter_out_of_range(block):
    with pytest.raises(FmuError, match=r"k = 9223372036854775808: .* int64, -9223372036854775808"):
        block.set("k", LARGEST + 1)
    assert block.get("k") == ODD


def test_numbers_that_no_double_holds(block):
    with pytest.raises(FmuError, match="that a double can hold"):
        block.step({"a": 10**400})


def test_a_cosimulation_carries_and_records_them_exactly(tmp_path):
    path = fmu(tmp_path, WIDE, "3.0")
    other = fmu(tmp_path, replace(WIDE, name="other"), "3.0")
    with load_fmu(path, parameters={"n": LARGEST, "m": UNSIGNED}) as one, load_fmu(other) as two:
        run = cosimulate(
            {"one": one, "two": two},
            [("one.back", "two.n"), ("one.too", "two.m"), ("one.b", "two.a"), (2.5, "one.a")],
            dt=0.001,
            duration=0.004,
        )
    assert run["one.back"].dtype == np.int64
    assert run["two.m"].dtype == np.uint64
    assert run["one.b"].dtype == float
    for name in ("one.n", "one.back", "two.n"):
        assert run[name].tolist() == [LARGEST] * 5, name
    for name in ("one.m", "one.too", "two.m"):
        assert run[name].tolist() == [UNSIGNED] * 5, name
    assert run["two.back"].tolist()[1:] == [LARGEST] * 4
    assert run["two.too"].tolist()[1:] == [UNSIGNED] * 4
    assert run["two.a"].tolist() == [2.5] * 5
    run.to_csv(tmp_path / "run.csv")
    last = (tmp_path / "run.csv").read_text().splitlines()[-1]
    assert f",{LARGEST}," in last
    assert f",{UNSIGNED}," in last


def test_whole_sums_and_signs_are_exact_in_a_cosimulation(tmp_path):
    path = fmu(tmp_path, WIDE, "3.0")
    other = fmu(tmp_path, replace(WIDE, name="other"), "3.0")
    with load_fmu(path, parameters={"n": 2**62 + 1}) as one, load_fmu(other) as two:
        run = cosimulate(
            {"one": one, "two": two},
            [("-one.back", "two.n"), (3, "two.n"), ("one.too", "two.m"), ("one.b", "two.a")],
            dt=0.001,
            duration=0.001,
        )
    assert run["two.n"].tolist()[0] == 3 - (2**62 + 1)


def test_functions_and_mixed_lists_are_exact_sources(tmp_path):
    sources = (lambda t: ODD + round(t), ([0, 1], [ODD, 1.0]))
    for source in sources:
        with load_fmu(fmu(tmp_path, WIDE, "3.0")) as loaded:
            run = cosimulate({"w": loaded}, [(source, "w.n")], dt=0.5, duration=0.5)
        assert run["w.back"].tolist()[-1] == ODD
