"""What a sweep keeps: written as it grows, stopped, killed, gone on with, and shown meanwhile."""

import errno
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
import xarray
from swept_axis import INERTIA, QUICK

from jounce.app import ScenarioSweep, Uniform, sweep, sweep_command

whole = pytest.mark.skipif(
    os.environ.get("JOUNCE_TIER") != "slow", reason="starts processes anew: in make test-slow"
)


@pytest.mark.parametrize("name", ["sweep.zarr", "sweep.nc"])
def test_a_disk_that_fills_is_told_in_a_line_and_the_sweep_goes_on(
    axis, tmp_path, monkeypatch, name
):
    honest, written = xarray.Dataset.to_zarr, []

    def full(*given, **asked):
        written.append(asked)
        if len(written) == 4:  # the folder, figures and mark of a batch, figures of the next
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return honest(*given, **asked)

    monkeypatch.setattr(xarray.Dataset, "to_zarr", full)
    asked = {"figures": QUICK, "samples": 8, "workers": 1, "output": tmp_path / name}
    with pytest.raises(
        OSError, match=r"cannot be written any more \(No space left.* go on with"
    ) as e:
        sweep(axis, INERTIA, **asked)
    assert "\n" not in str(e.value)
    again = sweep(axis, INERTIA, **asked)
    assert again.is_whole
    assert len(written) == 6
    assert [path.name for path in tmp_path.iterdir() if "sweep" in path.name] == [name]


def test_a_file_that_does_not_fit_leaves_no_part_and_is_made_by_the_same_call(
    axis, tmp_path, monkeypatch
):
    def full(_, path, **__):
        Path(path).write_bytes(b"part")
        raise RuntimeError("Unable to flush file\n(no space left)")

    asked = {"figures": QUICK, "samples": 4, "workers": 1, "output": tmp_path / "sweep.nc"}
    with monkeypatch.context() as filled:
        filled.setattr(xarray.Dataset, "to_netcdf", full)
        with pytest.raises(OSError, match=r"Unable to flush file.*make room"):
            sweep(axis, INERTIA, **asked)
    assert {path.name for path in tmp_path.iterdir()} == {"axis.toml", "sweep.nc.growing"}
    assert sweep(axis, INERTIA, **asked).is_whole
    assert {path.name for path in tmp_path.iterdir()} == {"axis.toml", "sweep.nc"}


@whole
def test_a_process_that_dies_is_told_in_a_line_and_the_sweep_goes_on(axis, tmp_path, monkeypatch):
    from jounce.app.sweeps.store import Store

    honest = Store.write

    def killing(*given):
        honest(*given)
        for process in multiprocessing.active_children():
            process.kill()

    asked = {"figures": QUICK, "samples": 64, "output": tmp_path / "sweep.zarr"}
    with monkeypatch.context() as deadly:
        deadly.setattr(Store, "write", killing)
        with pytest.raises(ChildProcessError, match=r"has died.* go on with the same call") as told:
            sweep(axis, INERTIA, **asked, workers=2)
    assert "\n" not in str(told.value)
    assert done_in(tmp_path / "sweep.zarr") >= 4
    assert sweep(axis, INERTIA, **asked, workers=1).is_whole


@pytest.mark.parametrize("name", ["sweep.zarr", "sweep.nc"])
def test_it_is_saved_and_read_as_it_was(axis, tmp_path, name):
    found = sweep(axis, INERTIA, figures=QUICK, samples=5, workers=1, output=tmp_path / name)
    again = ScenarioSweep.load(tmp_path / name)
    assert again.dataset.equals(found.dataset)
    assert again.worst("crossover").overrides == found.worst("crossover").overrides
    assert [path.name for path in tmp_path.iterdir() if "sweep" in path.name] == [name]


STOPPED = """
import sys
from jounce.app import Uniform, sweep
if __name__ == "__main__":
    sweep(sys.argv[1], {"plant.inertia": Uniform("1.5 kg m^2", "2.5 kg m^2")}, samples=160,
          figures=["phase_margin"], output=sys.argv[2], workers=1)
"""


def test_a_killed_sweep_goes_on_and_loses_nothing(axis, tmp_path, monkeypatch):
    script, folder = tmp_path / "stopped.py", tmp_path / "sweep.zarr"
    script.write_text(STOPPED, encoding="utf-8")
    process = subprocess.Popen([sys.executable, script, axis, folder])
    deadline = time.monotonic() + 60.0
    while done_in(folder) < 10:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    before = done_in(folder)
    assert 10 <= before < 160
    seen = []

    from jounce.app.sweeps.figures import Problem

    def counted(_, values):
        seen.append(values)
        return (1.0,), ""

    monkeypatch.setattr(Problem, "evaluate", counted)
    monkeypatch.setattr(Problem, "prepared", lambda problem, _: problem)
    parameters = {"plant.inertia": Uniform("1.5 kg m^2", "2.5 kg m^2")}
    whole = sweep(axis, parameters, samples=160, figures=["phase_margin"], output=folder, workers=1)
    assert len(seen) == 160 - before
    assert whole.dataset["done"].values.all()
    assert (whole.values("phase_margin") > 10.0).sum() == before


def done_in(folder: Path) -> int:
    if not (folder / ".zmetadata").exists():
        return 0
    return int(xarray.open_zarr(folder, chunks=None)["done"].values.sum())


def test_a_stopped_sweep_returns_what_is_done_and_goes_on(axis, tmp_path, monkeypatch, run):
    from jounce.app.sweeps.figures import Problem
    from jounce.app.sweeps.run import Stopped

    honest, seen = Problem.evaluate, []

    def stopping(problem, values):
        seen.append(values)
        if len(seen) == 10:
            raise KeyboardInterrupt
        return honest(problem, values)

    monkeypatch.setattr(Problem, "evaluate", stopping)
    asked = {"figures": QUICK, "samples": 16, "workers": 1, "output": tmp_path / "out/sweep.zarr"}
    with pytest.warns(Stopped, match="stopped at 8 of 16 points; the same call goes on"):
        part = sweep(axis, INERTIA, **asked)
    assert (part.is_whole, int(part.dataset["done"].sum())) == (False, 8)
    assert part.met().points == 8
    del seen[:]
    (tmp_path / "sweep.toml").write_text(
        f'figures = ["{QUICK[0]}", "{QUICK[1]}"]\nsamples = 16\n[parameters]\n'
        'plant.inertia = { uniform = ["1.5 kg m^2", "2500 g m^2"] }\n',
        encoding="utf-8",
    )
    command = ("sweep", axis, tmp_path / "sweep.toml", "--output", tmp_path / "out", "--workers", 1)
    seen += [None] * 5
    status, _, errors = run(*command)
    assert status == 130
    assert "12 of 16 points" in errors[0]
    assert "the same command goes on" in errors[0]
    seen += [None] * 99
    whole = sweep(axis, INERTIA, **asked)
    assert (whole.is_whole, len(seen)) == (True, 113)


INTERRUPTED = """
import signal, sys, warnings
from jounce.app import Uniform, sweep
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    warnings.simplefilter("ignore")
    found = sweep(sys.argv[1], {"plant.inertia": Uniform("1.5 kg m^2", "2.5 kg m^2")}, samples=2048,
                  figures=["phase_margin"], output=sys.argv[2], workers=2)
    print(int(found.dataset["done"].sum()))
"""


@whole
def test_an_interrupt_of_all_its_processes_keeps_what_is_done(axis, tmp_path):
    process, folder = begun(axis, tmp_path)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    out, errors = process.communicate(timeout=60.0)
    assert (process.returncode, errors) == (0, "")
    assert 64 <= int(out) == done_in(folder) < 2048


@whole
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_its_processes_end_with_a_sweep_that_is_killed(axis, tmp_path, number):
    process, _ = begun(axis, tmp_path)
    os.kill(process.pid, number)
    process.communicate(timeout=20.0)  # which waits for all that hold its output open
    assert process.returncode == -number


def begun(axis: Path, tmp_path: Path) -> tuple[subprocess.Popen[str], Path]:
    """Return a sweep in processes of which some points are done, and its folder."""
    script, folder = tmp_path / "interrupted.py", tmp_path / "sweep.zarr"
    script.write_text(INTERRUPTED, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, script, axis, folder],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 120.0
    while done_in(folder) < 64:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return process, folder


def test_another_sweep_is_not_mixed_in(axis, tmp_path):
    sweep(axis, INERTIA, figures=QUICK, samples=4, workers=1, output=tmp_path / "a.zarr")
    with pytest.raises(ValueError, match="holds another sweep, of other points"):
        sweep(axis, INERTIA, figures=QUICK, samples=8, workers=1, output=tmp_path / "a.zarr")
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match="cannot be written"):
        sweep(axis, INERTIA, figures=QUICK, samples=4, workers=1, output=tmp_path / "file/a.zarr")
    for missing in ("b.zarr", "b.nc"):
        with pytest.raises(ValueError, match=r"is no sweep \(there is none\)"):
            ScenarioSweep.load(tmp_path / missing)
    with pytest.raises(ValueError, match=r"ends in \.zarr or \.nc"):
        sweep(axis, INERTIA, figures=QUICK, samples=8, workers=1, output=tmp_path / "a.csv")


def test_the_command_prints_answers_and_writes_files(axis, tmp_path, run, monkeypatch):
    (tmp_path / "sweep.toml").write_text(
        'figures = ["phase_margin"]\nsamples = 4\n[parameters]\n'
        'plant.inertia = { uniform = ["1.9 kg m^2", "2.1 kg m^2"] }\n',
        encoding="utf-8",
    )
    output = tmp_path / "out"
    arguments = ("sweep", axis, tmp_path / "sweep.toml", "--output", output, "--workers", 1)
    status, out, errors = run(*arguments)
    assert (status, errors) == (0, [])
    assert "of 4 points meet what is required" in out
    assert {path.name for path in output.iterdir()} == {
        *("sweep.zarr", "phase_margin.png", "worst_phase_margin.toml")
    }
    monkeypatch.setattr(sweep_command, "_write", lambda *_: [])  # pictures take their time
    status, out, _ = run(*arguments, "--json")
    answers = json.loads(out)
    assert answers["points"] == 4
    assert answers["worst"]["phase_margin"]["unit"] == "deg"
    (tmp_path / "sweep.toml").write_text("samples = 4\nfigure = 3\n", encoding="utf-8")
    status, _, errors = run(*arguments)
    assert status == 2
    assert "figure is no key" in errors[0]


def test_a_notebook_shows_rate_and_time_left_in_one_line(monkeypatch):
    from jounce.app.sweeps import progress

    shown, clock = [], iter([0.0, 2.0, 4.0])
    line = SimpleNamespace(update=lambda data, **_: shown.append(data["text/plain"]))
    told = SimpleNamespace(display=lambda data, **_: shown.append(data["text/plain"]) or line)
    shell = SimpleNamespace(kernel="a notebook's")
    ipython = SimpleNamespace(get_ipython=lambda: shell, display=told)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", told)
    monkeypatch.setattr(progress, "perf_counter", lambda: next(clock))
    with progress.shown_progress(100, 20, None) as advance:
        advance(20)
        advance(60)
    del shell.kernel  # a shell of its own: no notebook
    with progress.shown_progress(100, 20, None) as advance:
        advance(80)
    assert shown == [
        "20 of 100 points",
        "40 of 100 points, 10 points/s, 6 s left",
        "100 of 100 points, 20 points/s",
    ]
