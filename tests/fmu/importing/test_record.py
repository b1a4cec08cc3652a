"""Any variable among the outputs: locals, parameters, elements, aliases."""

from dataclasses import replace

import control
import numpy as np
import pytest
from handmade_fmus import INERTIA, Model, fmu

from jounce.fmu import cosimulate, linearize_fmu
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.plant import Inertia, zero_order_hold

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
SILENT = replace(
    INERTIA,
    name="silent",
    outputs=(),
    outputs_code="",
    derivatives_code="dxdot[0] = dx[1]; dxdot[1] = du[0] / p[0];",
)
COUNTER = Model(
    "counter",
    outputs=("y", "n"),
    types={"n": "Int32"},
    parameters={"a": 0.5, "b": 1.5, "c": 2.5, "d": 3.5},
    states=1,
    step="x[0] += 1; y[0] = u[0]; y[1] = x[0];",
    outputs_code="",
    derivatives_code="dy[0] = du[0];",
    code=(
        ("T out[], size_t m) { for", "T out[], size_t m) { size_t place = 0; for"),
        ("for (size_t k = 0; k < m / n; k++) out[i * (m / n) + k] =",
         "for (int k = 0; k < (v[i] == 200 ? 4 : 1); k++) out[place++] ="),
    ),
    xml=(
        (
            '<Float64 name="a" valueReference="200" causality="parameter" variability="tunable" '
            'start="0.5"/>',
            '<Float64 name="A" valueReference="200" causality="parameter" variability="tunable" '
            'start="0.5 1.5 2.5 3.5"><Dimension start="2"/><Dimension start="2"/>'
            '<Alias name="matrix"/></Float64>',
        ),
        ('causality="output" variability="continuous"/>',
         'causality="output" variability="continuous" unit="rad"><Alias name="angle"/></Float64>'),
    ),
)  # fmt: skip


@VERSIONS
def test_locals_and_parameters_behind_the_outputs(tmp_path, version):
    with load_fmu(fmu(tmp_path, version=version), record=["x1", "J", "y", "u", "x1"]) as plant:
        assert plant.output_names == ("y", "y_rate", "x1", "J")
        assert plant.recorded_names == ("x1", "J")
        assert plant.outputs.tolist() == [0.0, 0.0, 0.0, 2.0]
        assert plant.step([1.0], 1.0).tolist() == [0.25, 0.5, 0.5, 2.0]
        plant.set("J", 4.0)
        assert plant.step([1.0], 1.0).tolist() == [0.875, 0.75, 0.75, 4.0]
        assert plant.outputs.tolist() == [0.875, 0.75, 0.75, 4.0]


def test_elements_aliases_and_types(tmp_path):
    path = fmu(tmp_path, COUNTER, "3.0")
    record = ["matrix[2,1]", "x0", "A[1,2]", "angle", "n"]
    with load_fmu(path, record=record) as block:
        assert block.output_names == ("y", "n", "matrix[2,1]", "x0", "A[1,2]", "angle")
        assert block.step([7.0]).tolist() == [7.0, 1.0, 2.5, 1.0, 1.5, 7.0]
        assert block.units == {
            "u": "", "y": "rad", "n": "", "matrix[2,1]": "", "x0": "", "A[1,2]": "", "angle": "rad",
        }  # fmt: skip
    with load_fmu(path, record=["A"]) as block:
        assert block.output_names == ("y", "n", "A[1,1]", "A[1,2]", "A[2,1]", "A[2,2]")
        assert block.step([7.0]).tolist() == [7.0, 1.0, 0.5, 1.5, 2.5, 3.5]


@VERSIONS
def test_an_fmu_without_outputs(tmp_path, version):
    path = fmu(tmp_path, SILENT, version)
    with load_fmu(path) as plant:
        assert plant.output_names == ()
        assert plant.step([1.0]).shape == (0,)
        with pytest.raises(FmuError, match=r"no outputs that are numbers: .*record="):
            cosimulate({"plant": plant}, (), dt=0.5, duration=1.0)
    with load_fmu(path, record=["x0", "x1"]) as plant:
        gain = control.ss([], [], [], [[-2.0]], 0.5, inputs="x", outputs="u")
        run = cosimulate(
            {"gain": gain, "plant": plant},
            [("plant.x0", "gain.x"), ("gain.u", "plant.u"), (1.0, "plant.u")],
            dt=0.5,
            duration=1.0,
        )
        assert run.outputs == ("gain.u", "plant.x0", "plant.x1")
        assert run["plant.x0"].tolist() == [0.0, 0.0625, 0.0625 + 0.5 * 0.25 + 0.875 * 0.0625]
        run.to_csv(tmp_path / "run.csv")
        assert "plant.x1" in (tmp_path / "run.csv").read_text().splitlines()[0]


def test_linearised_about_what_is_recorded(tmp_path):
    with load_fmu(fmu(tmp_path, SILENT), record=["x0", "J"]) as plant:
        assert plant.system(0.5).output_labels == ["x0", "J"]
        found = linearize_fmu(plant, 0.5, outputs=["x0"])
    exact = zero_order_hold(Inertia(2.0).system(), 0.5)[0, :]
    omega = np.array([0.1, 1.0, 6.0])
    np.testing.assert_allclose(found(np.exp(0.5j * omega)), exact(np.exp(0.5j * omega)), rtol=1e-8)


def test_names_that_cannot_be_recorded(tmp_path):
    path = fmu(tmp_path)
    with pytest.raises(FmuError, match="has no variable 'x9'"):
        load_fmu(path, record=["x9"])
    with pytest.raises(TypeError, match=r"record = 'x1': expected a list of names, as in \['x1'\]"):
        load_fmu(path, record="x1")
    text = replace(INERTIA, xml=(("<ModelVariables>", '<ModelVariables><String name="s" '
                   'valueReference="9" variability="discrete"/>'),))  # fmt: skip
    with pytest.raises(FmuError, match="record: 's' is of type String, and a run records numbers"):
        load_fmu(fmu(tmp_path, text, "3.0"), record=["s"])


@VERSIONS
def test_states_and_reset_keep_what_is_recorded(tmp_path, version):
    with load_fmu(fmu(tmp_path, version=version), record=["x1"]) as plant:
        plant.step([1.0], 1.0)
        state = plant.get_state()
        first = plant.step([1.0], 1.0).tolist()
        plant.set_state(state)
        assert plant.outputs.tolist() == [0.25, 0.5, 0.5]
        assert plant.step([1.0], 1.0).tolist() == first
        plant.reset()
        np.testing.assert_array_equal(plant.outputs, [0.0, 0.0, 0.0])
