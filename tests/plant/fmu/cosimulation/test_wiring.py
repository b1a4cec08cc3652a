"""Loops among connections."""

import itertools

from jounce.plant.fmu.cosimulation.wiring import loops


def test_each_loop_once_from_its_first_block():
    links = [("a", "b"), ("b", "a"), ("b", "c"), ("c", "a"), ("c", "c"), ("c", "d")]
    assert sorted(loops(links, "abcd")) == [("a", "b"), ("a", "b", "c"), ("c",)]
    assert sorted(loops(links, "cbad")) == [("b", "a"), ("c",), ("c", "a", "b")]
    assert loops([("a", "b"), ("b", "c")], "abc") == []


def test_many_loops_are_cut_off():
    names = "abcdefghij"
    assert len(loops(itertools.permutations(names, 2), names)) == 50
