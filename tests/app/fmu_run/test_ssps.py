"""`jounce fmu run` and `inspect` of SSP files."""

import re
from functools import partial
from math import pi
from pathlib import Path

import numpy as np
import pytest
from fmu_runs import columns, rows


def test_isolated_systems_give_the_same_numbers(run, whole):
    own = partial(run.func, "fmu", "run")
    options = (whole, "--set", "angle=180", "--record", "a.k")
    assert own(*options) == run(*options)


def test_an_ssp_runs(run, whole):
    status, out, errors = run(whole, "--set", "angle=180", "--set", "gain=3", "--csv", "out.csv")
    assert (status, errors) == (0, [])
    assert "From 0 s to 1 s in 8 steps" in out
    shown = rows(out)
    assert list(shown)[2:] != []
    assert float(shown["shown"][1]) == pytest.approx(3.0 * 2.0 * (pi + 1.0), rel=1e-9)
    assert float(shown["a.y"][1]) == pytest.approx(pi + 1.0, rel=1e-9)
    assert re.search(r"'b\.x'|no 'x'", out)
    found = columns("out.csv")
    np.testing.assert_array_equal(found["shown"], found["b.y"])
    np.testing.assert_allclose(found["b.u"], 2.0 * (pi + 1.0), rtol=1e-14)


def test_an_ssp_takes_inputs_of_its_own_and_records(run, whole):
    Path("in.csv").write_text("time,angle [rad]\n0,0\n1,8\n", encoding="utf-8")
    status, out, errors = run(
        whole, "--input", "in.csv", "--record", "a.k", "--csv", "out.csv", "--plot", "out.png",
        "--duration", 1, "--set", "a.k=2",
    )  # fmt: skip
    assert (status, errors) == (0, [])
    found = columns("out.csv")
    np.testing.assert_allclose(found["a.u"][:-1], found["time"][:-1] * 8.0, rtol=1e-14)
    assert found["a.k"].tolist() == [2.0] * 9
    assert rows(out)["a.k"] == ["2"] * 4


def test_what_an_ssp_does_not_have_is_refused(refused, whole):
    for options, words in (
        (["--set", "c.k=1"], "parameter 'c.k'"),
        (["--set", "a.kk=1"], "no variable 'kk'"),
        (["--set", "gain=x"], "expected a number"),
        (["--record", "shown"], "record 'shown'"),
        (["--sha256", "00"], "not the file that was pinned"),
    ):
        assert words in refused(whole, *options), options
    Path("in.csv").write_text("time,b.u\n0,0\n", encoding="utf-8")
    assert "no input 'b.u'" in refused(whole, "--input", "in.csv")


def test_inspect_tells_what_an_ssp_connects_and_sets(run, whole):
    run = partial(run.func, "fmu", "inspect")
    status, out, errors = run(whole)
    assert (status, errors) == (0, [])
    found = [row.split() for row in out.splitlines()]
    assert ["a.y", "b.u", "2", "0"] in found
    assert ["angle", "a.u", "0.0174532925", "0"] in found
    assert ["b.y", "shown", "1", "0"] in found
    assert ["a", "a", "2.0", "linux64", "c", "=", "1"] in found
    assert "b has no 'x'" in out
