"""Connections with gains, converted units and sources over time, against sums done by hand."""

from dataclasses import replace
from math import pi

import control
import numpy as np
import pytest
from handmade_fmus import Model, fmu
from handmade_ssps import ADDER, with_units

from jounce.fmu.cosimulation.cosimulate import cosimulate
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.plant import Inertia

DT = 0.125
DEGREES = {"deg": {"rad": 1, "factor": repr(pi / 180.0)}}


@pytest.fixture
def adder(tmp_path):
    """Return a function that loads y = u with units for its two ends."""
    loaded = []

    def call(name, units, definitions=None, version="2.0", **options):
        model = replace(with_units(replace(ADDER, **options), units, definitions), name=name)
        loaded.append(load_fmu(fmu(tmp_path, model, version)))
        return loaded[-1]

    yield call
    for each in loaded:
        each.close()


def ramp(time):
    return 3.0 * time


def test_degrees_become_radians_and_that_is_told(adder):
    blocks = {
        "a": adder("a", {"y": "deg"}, DEGREES),
        "b": adder("b", {"u": "rad"}, {"rad": {"rad": 1}}),
    }
    links = [(ramp, "a.u"), ("a.y", "b.u"), ("-a.y", "b.u"), ("a.y", "b.u")]
    run = cosimulate(blocks, links, dt=DT, duration=1.0)
    np.testing.assert_allclose(run["b.u"][:-1], np.deg2rad(3.0 * run.time[:-1]), rtol=1e-15)
    assert "a.y -> b.u: deg converted to rad, ×0.0174532925" in run.notes
    assert run.notes[0] in str(run)


def test_a_name_that_is_not_defined_is_taken_for_what_it_says(adder):
    blocks = {"a": adder("a", {"y": "mm"}), "b": adder("b", {"u": "m"})}
    run = cosimulate(blocks, [(ramp, "a.u"), ("a.y", "b.u")], dt=DT, duration=1.0)
    np.testing.assert_allclose(run["b.u"][:-1], 3e-3 * run.time[:-1], rtol=1e-15)


def test_an_offset_of_a_unit_is_added(adder):
    blocks = {
        "a": adder("a", {"y": "degC"}, {"degC": {"K": 1, "offset": 273.15}}),
        "b": adder("b", {"u": "K"}, {"K": {"K": 1}}),
    }
    run = cosimulate(blocks, [(ramp, "a.u"), ("a.y", "b.u")], dt=DT, duration=1.0)
    np.testing.assert_allclose(run["b.u"][:-1], 3.0 * run.time[:-1] + 273.15, rtol=1e-15)
    assert run.notes == ("a.y -> b.u: degC converted to K, ×1 + 273.15",)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_differences_have_no_offset(tmp_path, version):
    """A difference of 5 °C is one of 5 K, a temperature of 5 °C one of 278.15 K."""
    kind = {"2.0": "Real", "3.0": "Float64"}[version]
    base = '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    types = f'<{kind}Type name="d" relativeQuantity="true" unit="degC"/>'
    if version == "2.0":
        types = '<SimpleType name="d"><Real relativeQuantity="true" unit="degC"/></SimpleType>'
    head = f"<UnitDefinitions>{base}</UnitDefinitions><TypeDefinitions>{types}</TypeDefinitions>"
    for relative, expected in ((True, 5.0), (False, 278.15)):
        said = ' declaredType="d"' if relative else ' unit="degC"'
        old = 'valueReference="100" causality="output" variability="continuous"'
        new = f"{old}><Real{said}" if version == "2.0" else f"{old}{said}"
        old = f"{old}><Real" if version == "2.0" else old
        marked = replace(ADDER, name="a", xml=(
            ("<ModelVariables>", f"{head}<ModelVariables>"),
            (old, new),
        ))  # fmt: skip
        kelvin = with_units(replace(ADDER, name="b"), {"u": "K"}, {"K": {"K": 1}})
        with load_fmu(fmu(tmp_path, marked, version)) as a, load_fmu(fmu(tmp_path, kelvin)) as b:
            run = cosimulate({"a": a, "b": b}, [(5.0, "a.u"), ("a.y", "b.u")], dt=DT, duration=DT)
            assert run["b.u"][0] == pytest.approx(expected, rel=1e-15)


def test_a_gain_takes_the_place_of_the_conversion(adder):
    blocks = {"a": adder("a", {"y": "m"}), "b": adder("b", {"u": "N"})}
    with pytest.raises(FmuError, match=r"'a\.y' is in m, 'b\.u' in N.*\('1\.0\*a\.y', 'b\.u'\)"):
        cosimulate(blocks, [("a.y", "b.u")], dt=DT, duration=1.0)
    links = [(ramp, "a.u"), ("-2.5e1 * a.y", "b.u")]
    run = cosimulate(blocks, links, dt=DT, duration=1.0)
    np.testing.assert_allclose(run["b.u"][:-1], -75.0 * run.time[:-1], rtol=1e-15)
    assert run.notes == ("-2.5e1 * a.y -> b.u: m becomes N by the gain that is given",)


@pytest.mark.parametrize(
    ("text", "gain"), [("2*p.y", 2.0), ("-.5*p.y", -0.5), ("+1e-1*p.y", 0.1), ("-p.y", -1.0)]
)
def test_gains_as_they_may_be_written(text, gain):
    blocks = {"p": Inertia(2.0), "q": Inertia(1.0)}
    run = cosimulate(blocks, [(1.0, "p.u"), (text, "q.u")], dt=DT, duration=1.0)
    np.testing.assert_allclose(run["q.u"][:-1], gain * run["p.y"][1:], rtol=1e-15)
    assert run.delays == {f"{text} -> q.u": 0}
    assert run.notes == ()


@pytest.mark.parametrize("text", ["2*p.z", "2**p.y", "x*p.y", "2*3*p.y", "2*", "*p.y"])
def test_what_is_no_gain_is_refused(text):
    with pytest.raises(FmuError, match=r"no output '.*p?\.?"):
        cosimulate({"p": Inertia(2.0)}, [(text, "p.u")], dt=DT, duration=1.0)


def test_an_inertia_driven_by_a_table_is_the_sum_of_its_steps():
    """The torque is held over each step: v is its sum, and the position that of the parabolas."""
    times, torque = [0.0, 0.5, 0.5, 1.0], [0.0, 2.0, -2.0, 0.0]
    run = cosimulate({"p": Inertia(2.0)}, [((times, torque), "p.u")], dt=DT, duration=1.0)
    held = np.array([0.0, 0.5, 1.0, 1.5, -2.0, -1.5, -1.0, -0.5])
    np.testing.assert_array_equal(run["p.u"][:-1], held)
    velocity = np.concatenate([[0.0], np.cumsum(held) * DT / 2.0])
    position = np.cumsum([0.0, *(DT * velocity[:-1] + DT**2 * held / 4.0)])
    np.testing.assert_allclose(run["p.y"], position, rtol=0, atol=1e-15)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_discrete_inputs_are_held_between_the_rows_of_a_table(tmp_path, version):
    count = Model(
        "count", inputs=("n", "x"), outputs=("y", "z"), types={"n": "Int32"},
        step="y[0] = u[0]; y[1] = u[1];",
    )  # fmt: skip
    table = ([0.0, 0.5, 1.0], [0.0, 4.0, 8.0])
    with load_fmu(fmu(tmp_path, count, version)) as loaded:
        run = cosimulate({"c": loaded}, [(table, "c.n"), (table, "c.x")], dt=DT, duration=1.0)
    assert run["c.y"].tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0]
    assert run["c.z"].tolist() == [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]


def test_whatever_the_order_a_source_over_time_is_that_of_the_step():
    lag = control.ss([[0.5]], [[1.0]], [[1.0]], 0, DT, inputs="u", outputs="y")
    runs = [
        cosimulate({"lag": lag}, [(ramp, "lag.u"), (1.0, "lag.u")], dt=DT, duration=1.0, order=o)
        for o in ("gauss-seidel", "jacobi")
    ]
    for run in runs:
        np.testing.assert_allclose(run["lag.u"][:-1], 1.0 + 3.0 * run.time[:-1], rtol=1e-15)
        assert run["lag.u"][-1] == run["lag.u"][-2]
        assert run.delays == {}


def test_a_table_that_ends_early_is_told_in_the_result():
    run = cosimulate({"p": Inertia(1.0)}, [(([0.0, 0.5], [1.0, 2.0]), "p.u")], dt=DT, duration=1.0)
    assert run["p.u"].tolist() == [1.0, 1.25, 1.5, 1.75] + [2.0] * 5
    assert "p.u holds its last value from 0.5 on" in str(run)
