"""Loops among connections, and connections of whole arrays."""

import itertools

import pytest
from handmade_fmus import Model, fmu

from jounce.fmu import FmuError, cosimulate, load_fmu
from jounce.fmu.cosimulation.wiring import loops


def test_each_loop_once_from_its_first_block():
    links = [("a", "b"), ("b", "a"), ("b", "c"), ("c", "a"), ("c", "c"), ("c", "d")]
    assert sorted(loops(links, "abcd")) == [("a", "b"), ("a", "b", "c"), ("c",)]
    assert sorted(loops(links, "cbad")) == [("b", "a"), ("c",), ("c", "a", "b")]
    assert loops([("a", "b"), ("b", "c")], "abc") == []


def test_many_loops_are_cut_off():
    names = "abcdefghij"
    assert len(loops(itertools.permutations(names, 2), names)) == 50


TWO = Model("two", inputs=("u[1]", "u[2]"), outputs=("y[1]", "y[2]"), step_size=0.5,
            step="y[0] = 2 * u[0]; y[1] = 3 * u[1];")  # fmt: skip
ONE = Model("one", outputs=("y", "z[1]"), step_size=0.5)


def test_arrays_are_connected_whole(tmp_path):
    path = fmu(tmp_path, TWO)
    with load_fmu(path) as a, load_fmu(path) as b, load_fmu(path) as c:
        run = cosimulate(
            {"a": a, "b": b, "c": c},
            [(5.0, "a.u[1]"), (7.0, "a.u[2]"), ("a.y", "b.u"), ("-0.5 * b.y", "c.u")],
            dt=0.5,
            duration=0.5,
        )
    assert [run[f"b.y[{i}]"][-1] for i in (1, 2)] == [20.0, 63.0]
    assert [run[f"c.y[{i}]"][-1] for i in (1, 2)] == [-20.0, -94.5]


@pytest.mark.parametrize("source", ["b.y", "b.z", "b.nothing", "-b.z"])
def test_arrays_of_another_shape_are_not(tmp_path, source):
    told = pytest.raises(FmuError, match=r"'a\.u' is an array of 2 values.*'a\.u\[1\]'")
    with load_fmu(fmu(tmp_path, TWO)) as a, load_fmu(fmu(tmp_path, ONE)) as b, told:
        cosimulate({"b": b, "a": a}, [(source, "a.u")], dt=0.5, duration=0.5)
