"""Linear systems in C against matrix exponentials and python-control."""

import control
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from scipy.linalg import expm
from tiers import some

from jounce.fmu import export_fmu
from jounce.plant import Inertia

pytestmark = needs_compiler


def stable():
    """Two inputs, three outputs with feedthrough, states whose units differ by 1e6."""
    rng = np.random.default_rng(5)
    a = rng.normal(size=(4, 4)) - 3.0 * np.eye(4)
    units = np.array([1.0, 1e6, 1.0, 1e-6])
    return control.ss(
        a * units[:, None] / units,
        rng.normal(size=(4, 2)) * units[:, None],
        rng.normal(size=(3, 4)) / units,
        rng.normal(size=(3, 2)),
        inputs=["force", "gust"],
        outputs=["p", "q", "r"],
        states=["x 1", "x[2]", "ξ", "100 %"],
    )


def servo_plant():
    """Two integrators and a fast lag, as a transfer function."""
    return control.tf([1.0, 50.0], [1e-3, 1.0, 0.0, 0.0], inputs=["u"], outputs=["y"])


def gain():
    return control.ss([], [], [], [[2.0, -1.0]], inputs=["a", "b"], outputs=["sum"])


def discrete():
    return control.ss(
        [[0.5, 1.0], [-0.3, 0.2]],
        [[0.0], [1.0]],
        [[1.0, 0.0]],
        [[2.0]],
        0.1,
        inputs=["u"],
        outputs=["y"],
        states=["first", "second"],
    )


def inertia():
    return Inertia(2.5)


def exact(system, steps, inputs, state=None):
    """Return outputs (p, N) at the ends of steps with inputs (m, N) held during each."""
    n, m = system.nstates, system.ninputs
    x = np.zeros(n) if state is None else np.asarray(state, dtype=float)
    rows = []
    for h, u in zip(steps, inputs.T, strict=True):
        both = expm(np.block([[system.A, system.B], [np.zeros((m, n + m))]]) * h)
        x = both[:n, :n] @ x + both[:n, n:] @ u
        rows.append(system.C @ x + system.D @ u)
    return np.array(rows).T


def assert_near(rows, expected, tolerance=1e-12):
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(rows - expected) <= tolerance * scale).all(), np.abs(rows - expected).max(axis=1)


@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize("make", [stable, servo_plant, gain])
def test_uneven_steps_are_exact(make, version):
    system = control.ss(make())
    rng = np.random.default_rng(2)
    steps, inputs = rng.uniform(1e-3, 0.2, 80), rng.normal(size=(system.ninputs, 80))
    host = Host(fmu_of(make, version)).run()
    named = dict(zip(make().input_labels, inputs, strict=True))
    rows = host.record(steps, *make().output_labels, **named)
    host.close()
    assert_near(rows, exact(system, steps, inputs))


def test_the_length_of_steps_does_not_matter():
    results = []
    for parts in (1, 4, 25):
        host = Host(fmu_of(stable, "2.0")).run(force=1.0, gust=-2.0)
        results.append(
            host.record([0.1 / parts] * (30 * parts), "p", "q", "r")[:, parts - 1 :: parts]
        )
        host.close()
    assert_near(results[1], results[0], 1e-13)
    assert_near(results[2], results[0], 1e-13)


def test_initial_states_are_settable_and_feedthrough_is_seen_at_once():
    system = stable()
    state = np.array([1.0, 2e6, -1.0, 3e-6])
    host = Host(fmu_of(stable, "3.0"))
    names = [f"state.{label}" for label in system.state_labels]
    host.set(**dict(zip(names, state, strict=True)))
    host.set(force=0.5)
    np.testing.assert_allclose(host.get("p", "q", "r"), system.C @ state + system.D @ [0.5, 0.0])
    host.run()
    inputs = np.ones((2, 20))
    rows = host.record([0.05] * 20, "p", "q", "r", force=inputs[0], gust=inputs[1])
    assert_near(rows, exact(system, [0.05] * 20, inputs, state))
    before = np.array(host.get("p", "q", "r"))
    host.set(gust=3.0)
    np.testing.assert_allclose(np.array(host.get("p", "q", "r")) - before, 2.0 * system.D[:, 1])
    assert "only before the simulation starts" in host.refused(host.set, **{names[0]: 1.0})
    host.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_partial_derivatives_are_the_systems_matrices(version):
    system = stable()
    host = Host(fmu_of(stable, version)).run()
    states = [host.reference[f"state.{label}"] for label in system.state_labels]
    rates = [host.reference[f"der(state.{label})"] for label in system.state_labels]
    inputs = [host.reference[label] for label in system.input_labels]
    outputs = [host.reference[label] for label in system.output_labels]
    for unknowns, knowns, matrix in (
        (rates, states, system.A),
        (rates, inputs, system.B),
        (outputs, states, system.C),
        (outputs, inputs, system.D),
    ):
        columns = [host.fmu.getDirectionalDerivative(unknowns, [k], [1.0]) for k in knowns]
        np.testing.assert_array_equal(np.array(columns).T, matrix)
        if version == "3.0":
            adjoint = [
                host.fmu.getAdjointDerivative([u], knowns, [1.0], len(knowns)) for u in unknowns
            ]
            np.testing.assert_array_equal(adjoint, matrix)
    both = host.fmu.getDirectionalDerivative(outputs, inputs, [2.0, -3.0])
    np.testing.assert_allclose(both, system.D @ [2.0, -3.0])
    message = host.refused(host.fmu.getDirectionalDerivative, inputs, outputs[:1], [1.0])
    assert "outputs and state derivatives by inputs and states" in message
    host.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_the_inertia_is_exact(version):
    rng = np.random.default_rng(8)
    steps, torque = rng.uniform(0.01, 0.3, 60), rng.normal(size=60)
    host = Host(fmu_of(inertia, version)).run(y=1.0, y_rate=-0.5)
    rows = host.record(steps, "y", "y_rate", u=torque)
    assert_near(rows, exact(inertia().system(), steps, torque[None], [1.0, -0.5]))
    names = ("y", "y_rate", "der(y)", "der(y_rate)")
    host.set(u=5.0, J=4.0)
    _, y_rate, *rates = host.get(*names)
    assert rates == [y_rate, 1.25]
    of = [host.reference[name] for name in names]
    by = [host.reference[name] for name in ("y", "y_rate", "u")]
    columns = [host.fmu.getDirectionalDerivative(of, [k], [1.0]) for k in by]
    expected = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.25]]
    np.testing.assert_array_equal(columns, expected)
    host.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_discrete_system_runs_at_its_ticks(version):
    system = discrete()
    inputs = np.random.default_rng(3).normal(size=100)
    expected = control.forced_response(system, 0.1 * np.arange(100), inputs).outputs
    host = Host(fmu_of(discrete, version)).run()
    rows = host.record([0.1] * 100, "y", u=inputs)
    host.close()
    np.testing.assert_allclose(rows[0], expected, rtol=0.0, atol=1e-14 * np.abs(expected).max())


def test_fmpy_simulates_a_discrete_system():
    times = 0.1 * np.arange(41)
    inputs = np.sin(times)
    signals = np.array(list(zip(times, inputs, strict=True)), dtype=[("time", float), ("u", float)])
    result = simulate_fmu(
        fmu_of(discrete, "3.0"), input=signals, output=["y"], stop_time=4.0, output_interval=0.1
    )
    expected = control.forced_response(discrete(), times, inputs).outputs
    np.testing.assert_allclose(result["y"][1:], expected[:-1], rtol=0.0, atol=1e-12)


def test_an_unstable_step_that_overflows_is_refused_and_changes_nothing(tmp_path):
    growing = control.ss([[1.0]], [[1.0]], [[1.0]], [[0.0]], inputs=["u"], outputs=["y"])
    made = export_fmu(growing, tmp_path / "growing.fmu", platforms=["host"])
    host = Host(made.path).run(u=1.0)
    host.step(1.0)
    before = host.get("y")
    assert "leaves the range of a double" in host.refused(host.step, 1000.0)
    assert host.get("y") == before
    host.step(1.0)
    assert host.get("y") == pytest.approx([np.e**2 - 1.0])
    host.close()


@pytest.mark.parametrize(
    ("system", "told"),
    [
        (control.tf([1.0, 0.0, 0.0], [1.0, 1.0]), "improper"),
        (control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], True), "dt = True"),
        (control.ss([[np.nan]], [[1.0]], [[1.0]], [[0.0]]), "with nan in it"),
        (control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], inputs=["u"], outputs=["u"]), "called u"),
        (control.ss([], [], [], [[1.0]], inputs=["time"], outputs=["y"]), "called time"),
        (control.ss(-np.eye(201), np.ones((201, 1)), np.ones((1, 201)), 0.0), "201 states"),
    ],
    ids=["improper", "no sampling time", "NaN", "one name twice", "time", "too large"],
)
def test_what_cannot_be_exported_is_refused(system, told, tmp_path):
    with pytest.raises(ValueError, match=told):
        export_fmu(system, tmp_path / "a.fmu", platforms=[])
    assert not list(tmp_path.iterdir())
