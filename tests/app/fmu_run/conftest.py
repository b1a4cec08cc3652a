"""FMUs and SSPs to run, and the command that runs them."""

from dataclasses import replace
from functools import partial

import pytest
from fmu_runs import DT, ENDS
from handmade_fmus import INERTIA, fmu
from handmade_ssps import (
    ADDER,
    binding,
    bindings,
    component,
    connection,
    linear,
    ssp,
    system,
    with_units,
)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(run):
    """Run `jounce fmu run` without isolation, which has tests of its own."""
    return partial(run, "fmu", "run", "--no-isolated")


@pytest.fixture
def refused(run, folder):
    """Run what is refused; give its one line."""

    def call(*arguments):
        before = sorted(folder.rglob("*"))
        status, out, (line,) = run(*arguments)
        assert (status, out) == (2, "")
        assert sorted(folder.rglob("*")) == before
        return line

    return call


@pytest.fixture
def plant(folder):
    return fmu(folder, with_units(replace(INERTIA, step_size=DT), {"u": "N", "y": "m"}))


@pytest.fixture
def whole(folder):
    """Write an SSP of k·u + c twice, with an input in deg, an output and a parameter set."""
    models = {
        "a": with_units(replace(ADDER, name="a", step_size=DT), {"u": "rad"}, {"rad": {"rad": 1}}),
        "b": replace(ADDER, name="b", step_size=DT),
    }
    top = system(
        [component("a", ENDS), component("b", ENDS)],
        [
            connection("angle", "a.u"), connection("a.y", "b.u", linear(2.0)),
            connection("b.y", "shown"), connection("gain", "b.k"),
        ],
        [("angle", "input", "deg"), ("shown", "output"), ("gain", "parameter")],
        bindings(binding({"a.c": ("Real", 1.0), "b.x": ("Real", 1.0)})),
    )  # fmt: skip
    return ssp(folder, top, models, after='<ssd:DefaultExperiment stopTime="1"/>')
