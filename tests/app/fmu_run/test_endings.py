"""`jounce fmu run` where an FMU ends, fails, crashes or prints, in its own process or not."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from functools import partial

import pytest
from fmu_runs import DT, columns
from handmade_fmus import Model, fmu
from tiers import some


def test_an_fmu_that_ends_the_run_leaves_its_rows(run, folder):
    ending = Model("ending", states=1, step_size=DT,
                   step="y[0] = ++x[0]; if (t > 0.3) { s->t += h; return 100; }")  # fmt: skip
    status, out, errors = run(fmu(folder, ending, "3.0"), "--duration", 2, "--csv", "out.csv")
    assert (status, errors) == (0, [])
    assert "ending ended the simulation at time 0.5" in out
    assert columns("out.csv")["ending.y"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_an_error_on_the_way_leaves_the_rows_before_it(run, folder):
    failing = Model("failing", states=1, step_size=DT,
                    step='x[0] += 1; y[0] = x[0]; if (t > 0.3) return 3;')  # fmt: skip
    path = fmu(folder, failing)
    status, out, (line,) = run(path, "--duration", 2, "--csv", "out.csv", "--plot", "out.png")
    assert (status, out) == (2, "")
    assert "could not step from time 0.375" in line
    assert line.endswith("wrote out.csv, out.png up to time 0.375")
    assert columns("out.csv")["failing.y"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert "wrote" not in run(path, "--duration", 2)[2][0]


@pytest.mark.parametrize(
    ("step", "words"),
    [("abort();", "plant"), ("exit(3);", "plant"), ("for (;;) {}", "0.5")],
    ids=["crash", "exit", "endless"],
)
def test_an_fmu_in_its_own_process_takes_nothing_with_it(run, folder, monkeypatch, step, words):
    path = fmu(folder, Model("plant", step=f"if (t > 0.2) {step} y[0] = t + h;", step_size=DT))
    (folder / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder / "temporary"))
    own = partial(run.func, "fmu", "run")
    status, out, (line,) = own(path, "--duration", 1, "--csv", "out.csv", "--timeout", "500 ms")
    assert (status, out) == (2, "")
    assert words in line
    assert line.endswith("wrote out.csv up to time 0.25")
    assert columns("out.csv")["plant.y"].tolist() == [0.0, 0.125, 0.25]
    assert list((folder / "temporary").iterdir()) == []


def test_what_an_fmu_prints_is_no_result(folder):
    """Neither what it writes nor what C keeps in its own buffer up to the end."""
    says = {
        "--isolated": 'write(1, "written", 7); printf("kept")',
        "--no-isolated": 'printf("printed")',
    }
    code = "import sys; from jounce.app.command_line import main\n"
    for number, (option, said) in enumerate(says.items()):
        loud = Model(f"loud{number}", step=f"{said}; y[0] = t + h;", step_size=DT)
        words = ["jounce", "fmu", "run", str(fmu(folder, loud)), option, "--duration", "0.25"]
        code += f"sys.argv = {words}\ntry: main()\nexcept SystemExit as end: assert not end.code\n"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert "kept" not in found.stdout
    for number, said in enumerate(("written", "printed")):
        assert said not in found.stdout
        assert said in found.stderr
        assert f"loud{number}.y" in found.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
@pytest.mark.parametrize("name", some(["SIGTERM", "SIGHUP"], 1))
def test_the_end_of_the_process_leaves_nothing(folder, name):
    """The FMU tells that it is in its step by a file, and never returns."""
    step = 'close(creat("begun", 384)); for (volatile int i = 0;;) i++;'
    endless = fmu(folder, Model("endless", step=step, step_size=DT))
    (folder / "temporary").mkdir()
    code = "from jounce.app.command_line import main; main()"
    command = [sys.executable, "-c", code, "fmu", "run", str(endless), "--duration", "0.25"]
    environment = {**os.environ, "TMPDIR": str(folder / "temporary")}
    with subprocess.Popen(command, env=environment, cwd=folder) as running:
        while not (folder / "begun").exists():
            assert running.poll() is None
            time.sleep(0.02)
        assert list((folder / "temporary").iterdir())
        number = signal.Signals[name]
        running.send_signal(number)
        assert running.wait(60) == 128 + number
    assert not list((folder / "temporary").iterdir())
