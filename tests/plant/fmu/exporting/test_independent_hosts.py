"""Our FMUs in hosts that are nobody's of us: libcosimpy (FMI 2.0) and ecospy (2.0 and 3.0)."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from fmus import Host, fmu_of, needs_compiler

from jounce.plant import Inertia, InertiaFeedforward, design_pid
from jounce.plant.fmu import SampledController
from jounce.shaping import Limits, min_time_move

pytestmark = needs_compiler

DT, STEPS = 0.01, 150
CONNECTIONS = {
    ("shaper", "position"): ("controller", "r"),
    ("shaper", "velocity"): ("controller", "r_rate"),
    ("shaper", "acceleration"): ("controller", "r_acceleration"),
    ("plant", "y"): ("controller", "y"),
    ("plant", "y_rate"): ("controller", "y_rate"),
    ("controller", "u"): ("plant", "u"),
}


def shaper():
    return min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0, jerk=10.0))


def controller():
    gains = design_pid(1.0, crossover_hz=2.0, phase_margin_deg=50.0, lower_gain_margin_db=12.0)
    return SampledController(gains, DT, InertiaFeedforward(0.8))


def plant():
    return Inertia(1.0)


MAKERS = {"shaper": shaper, "controller": controller, "plant": plant}


def loop_on_last_values(version):
    """Return the plant's positions, all blocks stepped on the last communication point's values."""
    hosts = {name: Host(fmu_of(make, version)).run() for name, make in MAKERS.items()}
    positions = []
    for _ in range(STEPS):
        values = {source: hosts[source[0]].get(source[1])[0] for source in CONNECTIONS}
        for source, (name, signal) in CONNECTIONS.items():
            hosts[name].set(**{signal: values[source]})
        for host in hosts.values():
            host.step(DT)
        positions.append(hosts["plant"].get("y")[0])
    for host in hosts.values():
        host.close()
    return np.array(positions)


def positions_in(script, version):
    """Return the plant's positions in another host, run in a process of its own."""
    paths = [str(fmu_of(make, version)) for make in MAKERS.values()]
    wires = [word for a, b in CONNECTIONS.items() for word in (*a, *b)]
    command = [sys.executable, "-c", script, str(DT), str(STEPS), *paths, *wires]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=Path(paths[0]).parent
    )
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    [line] = [line for line in done.stdout.splitlines() if line.startswith("positions ")]
    return np.array([float(word) for word in line.split()[1:]])


READ_ARGUMENTS = """
import sys
dt, steps = float(sys.argv[1]), int(sys.argv[2])
paths = dict(zip(("shaper", "controller", "plant"), sys.argv[3:6]))
wires = [sys.argv[k : k + 4] for k in range(6, len(sys.argv), 4)]
"""

ECOSPY = (
    READ_ARGUMENTS
    + """
from ecospy import EcosSimulation, EcosSimulationStructure
with EcosSimulationStructure() as structure:
    for name, path in paths.items():
        structure.add_model(name, path)
    for source, output, sink, input in wires:
        structure.make_real_connection(f"{source}::{output}", f"{sink}::{input}")
    with EcosSimulation(structure=structure, step_size=dt) as simulation:
        simulation.init()
        positions = []
        for _ in range(steps):
            simulation.step()
            positions.append(simulation.get_real("plant::y"))
print("positions", *map(repr, positions))
"""
)

LIBCOSIMPY = (
    READ_ARGUMENTS
    + """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
import fmpy
execution = CosimExecution.from_step_size(step_size=round(dt * 1e9))
index, reference = {}, {}
for name, path in paths.items():
    index[name] = execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name=name))
    for variable in fmpy.read_model_description(path).modelVariables:
        reference[name, variable.name] = variable.valueReference
for source, output, sink, input in wires:
    execution.connect_real_variables(
        index[source], reference[source, output], index[sink], reference[sink, input]
    )
observer = CosimObserver.create_last_value()
execution.add_observer(observer=observer)
positions = []
for _ in range(steps):
    assert execution.step()
    positions += observer.last_real_values(index["plant"], [reference["plant", "y"]])
print("positions", *map(repr, positions))
"""
)


def skip_unless_it_loads(package, needs=""):
    """Skip with the reason where a host is not installed, or does not load."""
    if find_spec(package) is None:
        pytest.skip(f"the package {package} is not installed")
    command = [sys.executable, "-c", f"import {package}"]
    probe = subprocess.run(command, capture_output=True, text=True, check=False)
    if probe.returncode != 0:
        pytest.skip(f"{package} does not load{needs}: {probe.stderr.strip()[-200:]}")


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_loop_in_ecospy(version):
    skip_unless_it_loads("ecospy", " (it needs Debian's libtbb12)")
    positions = positions_in(ECOSPY, version)
    np.testing.assert_allclose(positions, loop_on_last_values(version), rtol=0.0, atol=1e-12)


def test_a_loop_in_libcosimpy():
    skip_unless_it_loads("libcosimpy")
    positions = positions_in(LIBCOSIMPY, "2.0")
    np.testing.assert_allclose(positions, loop_on_last_values("2.0"), rtol=0.0, atol=1e-12)
