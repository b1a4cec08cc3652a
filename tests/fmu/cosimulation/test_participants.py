"""What may take part in a co-simulation, units of its connections, and files of its results."""

import numpy as np
import pytest
from handmade_fmus import Model, fmu

from jounce.fmu.cosimulation.cosimulate import cosimulate
from jounce.fmu.exporting.export import export_fmu
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.plant import FlexibleInertia, Inertia

DT = 0.01


@pytest.mark.parametrize(
    "plant", [Inertia(2.0), FlexibleInertia(2.0, 3.0, 0.02)], ids=["rigid", "flexible"]
)
def test_a_plant_as_it_is(plant):
    system = plant.system()
    runs = [
        cosimulate({"p": block}, [(1.0, f"p.{system.input_labels[0]}")], dt=DT, duration=0.5)
        for block in (plant, system)
    ]
    assert runs[0].outputs == runs[1].outputs
    for name in runs[0].outputs:
        np.testing.assert_array_equal(runs[0][name], runs[1][name])
    assert runs[0][runs[0].outputs[0]][-1] > 0.0


@pytest.mark.parametrize("block", ["a.fmu", 3.0, Inertia], ids=["path", "number", "class"])
def test_other_kinds_are_told_what_to_be(block):
    with pytest.raises(TypeError, match=r"block 'b'.*\.system\(\) returns one.*export_fmu"):
        cosimulate({"b": block}, [], dt=DT, duration=0.5)


def test_units_that_differ_are_refused(tmp_path):
    for name, unit in (("a", "m"), ("b", "rad")):
        export_fmu(Inertia(2.0), tmp_path / f"{name}.fmu", platforms=["x86_64-linux"], unit=unit)
    a, b = load_fmu(tmp_path / "a.fmu"), load_fmu(tmp_path / "b.fmu")
    with a, b, pytest.raises(FmuError, match=r"'a\.y' is in m, 'b\.u' in N"):
        cosimulate({"a": a, "b": b}, [("-a.y", "b.u")], dt=DT, duration=0.1)


def test_a_missing_folder_is_told_by_the_path_given(tmp_path):
    run = cosimulate({"p": Inertia(2.0)}, [(1.0, "p.u")], dt=DT, duration=0.1)
    path = tmp_path / "missing" / "run.csv"
    with pytest.raises(FileNotFoundError) as caught:
        run.to_csv(path)
    assert caught.value.filename == str(path)


def test_an_fmu_without_outputs_takes_part(tmp_path):
    """What only takes values, such as a display, is stepped all the same."""
    sink = Model("sink", outputs=(), states=1, step="x[0] += u[0];",
                 outputs_code="", derivatives_code="dxdot[0] = 0;")  # fmt: skip
    with load_fmu(fmu(tmp_path, sink)) as loaded:
        links = [(2.0, "p.u"), ("p.y_rate", "sink.u")]
        run = cosimulate({"p": Inertia(1.0), "sink": loaded}, links, dt=DT, duration=4 * DT)
        assert run.outputs == ("p.y", "p.y_rate")
        assert loaded.get("x0") == pytest.approx(run["p.y_rate"][1:].sum(), rel=1e-15)
        with pytest.raises(FmuError, match=r"sink: no outputs that are numbers: .*record="):
            cosimulate({"sink": loaded}, [], dt=DT, duration=DT)
