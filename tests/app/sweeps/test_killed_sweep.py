"""The processes of a sweep end with the one that asked for it."""

import os
import subprocess
import sys

import pytest
from swept_axis import AXIS

SWEEP = """
from jounce.app import Uniform, sweep
if __name__ == "__main__":
    print("begun", flush=True)
    sweep("axis.toml", {"plant.inertia": Uniform("1.5 kg m^2", "2.5 kg m^2")}, samples=100_000,
          figures=["phase_margin"], output="sweep.zarr", workers=2)
"""


@pytest.mark.skipif(os.environ.get("JOUNCE_TIER") != "slow", reason="in make test-slow")
def test_the_processes_of_a_sweep_end_with_it(tmp_path):
    (tmp_path / "axis.toml").write_text(AXIS, encoding="utf-8")
    (tmp_path / "script.py").write_text(SWEEP, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "script.py"], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    done = tmp_path / "sweep.zarr" / "done"
    while not (done / "0").exists():
        assert process.poll() is None
    process.kill()
    process.communicate(timeout=30.0)  # which waits for all that hold its output open
    assert process.returncode != 0
