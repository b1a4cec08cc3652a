"""Linear models of FMUs against the exact ones, and margins of loops around them."""

from dataclasses import replace

import control
import numpy as np
import pytest
from handmade_fmus import INERTIA, PD, Model, fmu

from jounce.analysis import loop_margins
from jounce.fmu.exporting.export import export_fmu
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.linearize import linearize_fmu
from jounce.fmu.importing.load import load_fmu
from jounce.plant import PID, FlexibleInertia, Inertia, zero_order_hold

VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
METHODS = pytest.mark.parametrize("method", ["auto", "directional", "impulse"])
DT = 0.001
OMEGA = np.geomspace(2.0 * np.pi * 0.01, 0.999 * np.pi / DT, 200)
EULER = replace(
    INERTIA, name="euler", step="x[0] += h * x[1]; x[1] += h * u[0] / p[0];"
)  # its derivatives know nothing of its solver
LEAD = Model(
    "lead",
    states=1,
    step="x[0] = exp(-h) * x[0] + (1 - exp(-h)) * u[0]; y[0] = x[0] + 2 * u[0];",
    derivatives_code="dy[0] = dx[0] + 2 * du[0]; dxdot[0] = du[0] - dx[0];",
)
PENDULUM = Model(
    "pendulum",
    outputs=("phi",),
    parameters={"g": 9.81},
    states=2,
    step="for (int i = 0; i < 10; i++) { double a = u[0] - p[0] * sin(x[0]);"
    "x[1] += 0.1 * h * a; x[0] += 0.1 * h * x[1]; }",
    outputs_code="y[0] = x[0];",
)


def error(found, exact, omega=OMEGA):
    """Return the largest relative error of the frequency response, entry by entry."""
    z = np.exp(1j * omega * DT)
    return np.abs(found(z) / exact(z) - 1.0).max()


@VERSIONS
@METHODS
def test_the_inertia_plant(tmp_path, version, method):
    exact = zero_order_hold(Inertia(2.0).system(), DT)
    with load_fmu(fmu(tmp_path, version=version)) as plant:
        found = linearize_fmu(plant, DT, method=method)
    assert (found.nstates, found.dt, found.name) == (2, DT, "plant")
    assert (found.input_labels, found.output_labels) == (["u"], ["y", "y_rate"])
    assert error(found, exact) < 1e-8
    assert not found.D.any()


@METHODS
def test_plants_exported_by_ourselves(tmp_path, method):
    system = FlexibleInertia(2.0, 3.0, 0.02, load_fraction=0.4).system()
    path = tmp_path / "x.fmu"
    export_fmu(system, path, fmi_version="3.0", platforms=["x86_64-linux"])
    with load_fmu(path) as plant:
        found = linearize_fmu(plant, DT, method=method, outputs=system.output_labels[:2])
    exact = zero_order_hold(system, DT)[:2, :]
    assert found.nstates == 4
    assert error(found, exact) < 1e-7


@VERSIONS
def test_margins_of_a_loop_around_it(tmp_path, version):
    controller = PID(40.0, 100.0, 12.0).sampled(DT, rate="differenced")
    expected = loop_margins(controller * zero_order_hold(Inertia(2.0).transfer(), DT))
    with load_fmu(fmu(tmp_path, version=version)) as plant:
        found = loop_margins(controller * linearize_fmu(plant, outputs=["y"], method="impulse"))
    assert found.stable
    for name in ("phase_margin_deg", "lower_gain_margin_db", "upper_gain_margin_db",
                 "crossover_hz", "modulus_margin"):  # fmt: skip
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-6), name


@METHODS
def test_an_output_that_jumps_with_the_input(tmp_path, method):
    """It shows the jump at the step's end: z·G has the feedthrough of the held plant."""
    with load_fmu(fmu(tmp_path, LEAD)) as lead:
        found = linearize_fmu(lead, DT, method=method)
        steps = control.forced_response(found, U=np.r_[1.0, np.zeros(5)]).outputs
        seen = [lead.step([u], DT)[0] for u in np.r_[1.0, np.zeros(4)]]
    np.testing.assert_allclose(steps[1:], seen, rtol=1e-9)
    decay = np.exp(-DT)
    z = np.exp(1j * OMEGA * DT)
    exact = (1.0 - decay) / (z - decay) + 2.0 / z
    assert np.abs(found(z) / exact - 1.0).max() < 1e-8


def test_derivatives_that_are_not_how_it_steps(tmp_path):
    """The automatic choice takes what the FMU does, not what it says."""
    j = 2.0
    with load_fmu(fmu(tmp_path, EULER)) as plant:
        automatic = linearize_fmu(plant, outputs=["y"])
        told = linearize_fmu(plant, outputs=["y"], method="directional")
    z = np.exp(1j * OMEGA * DT)
    assert np.abs(automatic(z) / (DT**2 / j / (z - 1.0) ** 2) - 1.0).max() < 1e-8
    assert error(told, zero_order_hold(Inertia(j).transfer(), DT)) < 1e-12


def test_without_rollback_the_derivatives_do(tmp_path):
    with load_fmu(fmu(tmp_path, replace(INERTIA, rollback=False))) as plant:
        assert error(linearize_fmu(plant), zero_order_hold(Inertia(2.0).system(), DT)) < 1e-8
        with pytest.raises(FmuError, match="cannot be linearised by impulse responses"):
            linearize_fmu(plant, method="impulse")


def test_the_fmu_comes_back_as_it_was(tmp_path):
    with load_fmu(fmu(tmp_path)) as plant:
        for _ in range(50):
            plant.step([3.0])
        before = plant.time, plant.inputs.tolist(), plant.outputs.tolist()
        for method in ("auto", "impulse", "directional"):
            linearize_fmu(plant, method=method)
            assert (plant.time, plant.inputs.tolist(), plant.outputs.tolist()) == before
        assert not plant._session.states


def test_about_a_moving_state(tmp_path):
    """A linear plant has one model, wherever it is and whatever is held."""
    with load_fmu(fmu(tmp_path)) as plant:
        for _ in range(2000):
            plant.step([3.0])
        found = linearize_fmu(plant, method="impulse")
    assert error(found, zero_order_hold(Inertia(2.0).system(), DT)) < 1e-5


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_nonlinear_plant_about_its_equilibrium(tmp_path, angle):
    """φ̈ = u − g·sin φ, held at φ by u = g·sin φ: poles at ±j·√(g·cos φ)."""
    torque = 9.81 * float(np.sin(angle))
    model = replace(
        PENDULUM,
        step=PENDULUM.step.replace("u[0] -", f"u[0] + {torque!r} -"),
        outputs_code=f"if (s->t == 0) x[0] = {angle!r}; y[0] = x[0];",
    )
    with load_fmu(fmu(tmp_path, model)) as plant:
        found = linearize_fmu(plant)
    poles = np.log(found.poles()) / DT
    assert found.nstates == 2
    np.testing.assert_allclose(np.abs(poles.imag), np.sqrt(9.81 * np.cos(angle)), rtol=1e-3)


def test_what_is_not_linear_is_refused(tmp_path):
    rectifier = Model("rectifier", step="y[0] = fabs(u[0]) + (u[0] > 0 ? u[0] : 0);")
    quantiser = Model("quantiser", step="y[0] = rint(3 * u[0]) / 3;")
    block = load_fmu(fmu(tmp_path, quantiser))
    with block, pytest.raises(FmuError, match="response of quantiser to 'u' is not linear"):
        linearize_fmu(block)
    with load_fmu(fmu(tmp_path, rectifier)) as block:
        assert linearize_fmu(block).nstates == 1  # one slope up, none down: half of it


def test_no_small_model_is_told(tmp_path):
    late = Model("late", states=41, step="for (int i = 40; i > 0; i--) x[i] = x[i - 1];"
                 "x[0] = u[0];", outputs_code="y[0] = x[40];")  # fmt: skip
    with load_fmu(fmu(tmp_path, late)) as block:
        with pytest.raises(FmuError, match=r"at most 20 states.*Raise max_order for delays"):
            linearize_fmu(block)
        assert linearize_fmu(block, max_order=50).nstates == 41


def test_no_derivatives_to_be_had(tmp_path):
    controller = load_fmu(fmu(tmp_path, PD))
    with controller, pytest.raises(FmuError, match="controller gives no directional derivatives"):
        linearize_fmu(controller, method="directional")


def test_integers_have_no_derivatives(tmp_path):
    mixed = Model(
        "mixed",
        inputs=("u", "n"),
        outputs=("y", "m"),
        types={"n": "Int32", "m": "Int32"},
        step="y[0] = 3 * u[0]; y[1] = u[1];",
    )
    with load_fmu(fmu(tmp_path, mixed)) as block:
        found = linearize_fmu(block)
        assert (found.input_labels, found.output_labels) == (["u"], ["y"])
        with pytest.raises(FmuError, match="'n' is of type Integer, which has no derivatives"):
            linearize_fmu(block, inputs=["n"])


def test_several_inputs(tmp_path):
    with load_fmu(fmu(tmp_path, PD)) as controller:
        found = linearize_fmu(controller)
        part = linearize_fmu(controller, inputs=["y"])
    gains = np.array([[4.0, -4.0, -2.0]])
    z = np.exp(1j * OMEGA[::20] * DT)
    np.testing.assert_allclose(found(z), gains[:, :, None] / z, rtol=1e-12)
    np.testing.assert_allclose(part(z), -4.0 / z, rtol=1e-12)


def test_bounds_of_the_input_are_kept(tmp_path):
    bounded = replace(
        INERTIA,
        name="bounded",
        step="if (fabs(u[0]) > 0.01) return 3;" + INERTIA.step,
        xml=(('<Real start="0.0"/>', '<Real start="0.0" min="-0.01" max="0.01"/>'),),
    )
    with load_fmu(fmu(tmp_path, bounded)) as plant:
        assert error(linearize_fmu(plant), zero_order_hold(Inertia(2.0).system(), DT)) < 1e-8
        plant.step([0.01])
        with pytest.raises(FmuError, match=r"'u' = 0\.01 is at a bound"):
            linearize_fmu(plant)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"inputs": ["uu"]}, "no input 'uu': did you mean 'u'"),
        ({"outputs": ["y_rates"]}, "did you mean 'y_rate'"),
        ({"outputs": []}, "no output to linearise"),
        ({"method": "guess"}, "expected 'auto', 'directional' or 'impulse'"),
        ({"horizon": 3}, "horizon = 3"),
        ({"max_order": 0}, "max_order = 0"),
        ({"tolerance": 0.0}, "tolerance = 0"),
        ({"amplitude": -1.0}, "amplitude = -1"),
        ({"dt": -1.0}, "dt = -1"),
    ],
    ids=str,
)
def test_arguments_that_are_refused(tmp_path, options, match):
    with load_fmu(fmu(tmp_path)) as plant, pytest.raises(ValueError, match=match):
        linearize_fmu(plant, **options)


def test_an_unstable_response_asks_for_a_shorter_horizon(tmp_path):
    wild = Model("wild", states=1, step="x[0] = 10 * x[0] + u[0];", outputs_code="y[0] = x[0];")
    with load_fmu(fmu(tmp_path, wild)) as block:
        with pytest.raises(FmuError, match="shorten the horizon"):
            linearize_fmu(block)
        assert linearize_fmu(block, horizon=12, max_order=3).poles().real == pytest.approx([10.0])
