"""Runs FMUs in a host that is not ours: libcosimpy or ecospy. A program: hosts may crash.

Arguments: a file that says what to run, and one for the rows of recorded values (JSON both).
"""

import json
import sys
from pathlib import Path


def run_in_ecos(task):
    """Return the values after each step."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    if "ssp" in task:
        simulation = EcosSimulation(task["dt"], ssp_path=task["ssp"])
    else:
        for name, path in task["models"].items():
            structure.add_model(name, path)
        for source, sink in task["connections"]:
            structure.make_real_connection(source.replace(".", "::"), sink.replace(".", "::"))
        simulation = EcosSimulation(task["dt"], structure=structure)
    if not simulation.init():
        raise RuntimeError("ecos could not initialise")
    for name, value in task["inputs"].items():
        simulation.set_real(name.replace(".", "::"), value)
    rows = []
    for _ in range(task["steps"]):
        simulation.step()
        rows.append([simulation.get_real(name.replace(".", "::")) for name in task["record"]])
    simulation.terminate()
    return rows


def run_in_cosim(task):
    """Return the values after each step; libcosim counts time in whole nanoseconds."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    step = round(task["dt"] * 1e9)
    slaves = []  # kept alive
    if "ssp" in task:
        execution = CosimExecution.from_ssp_file(task["ssp"], step)
    else:
        execution = CosimExecution.from_step_size(step)
        for name, path in task["models"].items():
            slaves.append(CosimLocalSlave(fmu_path=path, instance_name=name))
            execution.add_local_slave(slaves[-1])

    def place(name):
        slave, variable = name.split(".", 1)
        index = execution.slave_index_from_instance_name(slave)
        known = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
        return index, known[variable]

    for source, sink in task.get("connections", []):
        execution.connect_real_variables(*place(source), *place(sink))
    for name, value in task["inputs"].items():
        execution.real_initial_value(*place(name), value)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = [place(name) for name in task["record"]]
    rows = []
    for _ in range(task["steps"]):
        if not execution.step(1):
            raise RuntimeError("libcosim could not step")
        rows.append([observer.last_real_values(i, [k])[0] for i, k in places])
    return rows


HOSTS = {"ecospy": run_in_ecos, "libcosimpy": run_in_cosim}


def main():
    """Run a task."""
    task = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    rows = HOSTS[task["host"]](task)
    Path(sys.argv[2]).write_text(json.dumps(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
