"""One step of an imported FMU, inputs set and outputs read, beside FMPy's simulate_fmu.

Isolated means in a process of its own.

Run: python benchmarks/fmu.py   (needs a C compiler)
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import fmpy
import numpy as np
from timing import ratio, repeated, side_by_side, table

from jounce.fmu import export_fmu, load_fmu
from jounce.plant import Inertia

STEPS = 10_000
DT = 1e-3


def fmpy_run(path: Path, folder: Path, *, with_input: bool) -> Callable[[], object]:
    """Return a call of simulate_fmu over all steps, on the unpacked FMU."""
    description = fmpy.read_model_description(str(path))
    unpacked = fmpy.extract(str(path), unzipdir=str(folder))
    signal = np.zeros(STEPS + 1, dtype=[("time", float), ("u", float)])
    signal["time"], signal["u"] = DT * np.arange(STEPS + 1), 1.0

    def run() -> object:
        return fmpy.simulate_fmu(
            unpacked,
            validate=False,
            model_description=description,
            fmi_type="CoSimulation",
            stop_time=STEPS * DT,
            step_size=DT,
            output_interval=DT,
            input=signal if with_input else None,
            output=["y", "y_rate"],
        )

    return run


def rows() -> list[tuple[str, ...]]:
    """Return the rows: FMI version, our time, isolated, FMPy's with and without input, ratio."""
    found = []
    with TemporaryDirectory() as folder:
        for version in ("2.0", "3.0"):
            path = Path(folder) / f"inertia_{version}.fmu"
            export_fmu(Inertia(2.0), path, fmi_version=version)
            runs = [
                fmpy_run(path, Path(folder) / f"{version}_{given}", with_input=given)
                for given in (True, False)
            ]
            with load_fmu(path, dt=DT) as fmu, load_fmu(path, dt=DT, isolated=True) as apart:
                steps = [
                    partial(repeated, STEPS, partial(one.step, np.array([1.0])))
                    for one in (fmu, apart)
                ]
                ours, alone, driven, free = side_by_side(*steps, *runs, repeats=7)
            each = [
                f"{1e6 * median(taken) / STEPS:.1f} µs" for taken in (ours, alone, driven, free)
            ]
            found.append((f"inertia, FMI {version}", *each, f"{ratio(driven, ours):.1f}"))
    return found


HEADER = (
    "FMU",
    "jounce, a step",
    "isolated",
    "simulate_fmu with input",
    "simulate_fmu without",
    "with input / jounce",
)

if __name__ == "__main__":
    print(table(HEADER, rows()))
