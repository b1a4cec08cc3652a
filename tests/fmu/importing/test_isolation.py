"""FMUs that crash, exit, hang or print, in a process of their own."""

import os
import subprocess
import sys
import threading
import time
from dataclasses import replace
from itertools import product
from pathlib import Path

import control
import handmade_fmus
import numpy as np
import pytest
from handmade_fmus import INERTIA, PD, fmu
from tiers import some

from jounce.fmu import FmuError, cosimulate, export_fmu, linearize_fmu, load_fmu
from jounce.plant import Inertia

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
DT = 0.001
LATE = "if (t > 0.0045) "
FOREVER = "for (volatile int i = 0;; i++) {}"


def bad(name, step="", **changes):
    return replace(INERTIA, name=name, step=step + INERTIA.step, **changes)


def children():
    """Return the processes that this one has begun and not yet waited for."""
    tasks = Path("/proc/self/task").glob("*/children")
    return [pid for task in tasks for pid in task.read_text().split()]


@pytest.fixture(autouse=True)
def no_process_left():
    before, threads = children(), threading.active_count()
    yield
    assert children() == before
    assert threading.active_count() == threads


ENDS = {
    "null pointer": ("*(volatile int *)0 = 1;", r"crashed \(SIGSEGV: Segmentation fault\)"),
    "abort": ("abort();", r"crashed \(SIGABRT: Aborted\)"),
    "exit(0)": ("exit(0);", r"ended its own process \(exit code 0\)"),
    "exit(3)": ("exit(3);", r"ended its own process \(exit code 3\)"),
    "for ever": (FOREVER, r"did not return within 0\.5 s"),
    "sleeping": ("sleep(1000);", r"did not return within 0\.5 s"),
}


@pytest.mark.parametrize(("version", "end"), some(product(["2.0", "3.0"], ENDS), 4))
def test_what_ends_a_step_is_one_error_and_the_rows_are_kept(tmp_path, version, end):
    code, told = ENDS[end]
    path = fmu(tmp_path, bad("bad", LATE + code), version)
    with load_fmu(path, isolated=True, timeout=0.5) as plant:
        begun = time.monotonic()
        when = r" when it was to step from time 0\.005 by 0\.001"
        with pytest.raises(FmuError, match=f"bad {told}{when}.*: load it again$") as error:
            cosimulate({"plant": plant}, [(1.0, "plant.u")], dt=DT, duration=1.0)
        assert time.monotonic() - begun < 3.0
        assert error.value.result.time[-1] == 0.005
        for use in (plant.step, plant.reset, plant.get_state, lambda: plant.outputs):
            with pytest.raises(FmuError, match=rf"bad is closed \(bad {told}.*load it again"):
                use()
    assert "closed" in repr(plant)


BEGINNINGS = {
    "fmi2Instantiate": "it was to be instantiated",
    "fmi2EnterInitializationMode": "it was to be initialised",
    "constructor": "its library was to be loaded",
}
ENDED = product(["null pointer", "for ever", "exit(3)"], BEGINNINGS)


@pytest.mark.parametrize(("end", "function"), some(ENDED, 3))
def test_what_ends_the_beginning(tmp_path, function, end):
    (code, told), when = ENDS[end], BEGINNINGS[function]
    early = bad(
        "early",
        missing="" if function == "constructor" else function,
        epilogue={
            "fmi2Instantiate": "fmi2Component fmi2Instantiate(fmi2String a, fmi2Type b, "
            "fmi2String c, fmi2String d, const fmi2CallbackFunctions *e, fmi2Boolean f, "
            f"fmi2Boolean g) {{ {code} return 0; }}",
            "fmi2EnterInitializationMode": "fmi2Status fmi2EnterInitializationMode("
            f"fmi2Component c) {{ {code} return 0; }}",
            "constructor": f"__attribute__((constructor)) static void begin(void) {{ {code} }}",
        }[function],
    )
    with pytest.raises(FmuError, match=f"^early {told} when {when}"):
        load_fmu(fmu(tmp_path, early), isolated=True, timeout=0.5)


@pytest.mark.parametrize("end", ["null pointer", "exit(3)", "for ever"])
def test_what_ends_the_end_costs_nothing(tmp_path, end):
    code, _ = ENDS[end]
    late = bad(
        "late",
        missing="fmi2FreeInstance",
        epilogue=f"void fmi2FreeInstance(fmi2Component c) {{ {code} }}",
    )
    with load_fmu(fmu(tmp_path, late), isolated=True, timeout=0.5) as plant:
        assert plant.step([1.0])[1] == 0.0005
    with pytest.raises(FmuError, match="late is closed: load it again"):
        plant.step()


def test_a_crash_does_not_lose_what_was_logged(tmp_path, monkeypatch):
    refusal = 'return fail(c, "input is not finite");'
    assert refusal in handmade_fmus._FMI2
    deadly = '{ fail(c, "input is not finite"); abort(); }'
    monkeypatch.setattr(handmade_fmus, "_FMI2", handmade_fmus._FMI2.replace(refusal, deadly))
    with load_fmu(fmu(tmp_path, bad("bad")), isolated=True) as plant:
        told = r"crashed \(SIGABRT: Aborted\) when .*: input is not finite: load it again"
        with pytest.raises(FmuError, match=told):
            plant.step([np.nan])


def test_what_it_prints_goes_to_standard_error(tmp_path, capfd):
    loud = bad("loud", 'extern int puts(const char *); puts("hello from C");')
    with load_fmu(fmu(tmp_path, loud), isolated=True) as plant:
        assert plant.step([1.0])[1] == 0.0005
    printed = capfd.readouterr()
    assert printed.out == ""


def test_an_interrupt_stops_it(tmp_path):
    """Ctrl-C in a step that hangs, as a user would; in a program of its own."""
    path = fmu(tmp_path, bad("bad", LATE + FOREVER))
    program = f"""
import signal, threading, os
from jounce.fmu import load_fmu, FmuError
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
with load_fmu({str(path)!r}, isolated=True) as plant:
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        while True:
            plant.step([1.0])
    except KeyboardInterrupt:
        try:
            plant.step()
        except FmuError as error:
            print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "interrupted" in done.stdout


@pytest.mark.parametrize("hangs", [False, True], ids=["idle", "in an endless step"])
def test_it_dies_with_its_parent(tmp_path, hangs):
    path = fmu(tmp_path, bad("bad", FOREVER if hangs else ""))
    program = f"""
import os, threading
from jounce.fmu import load_fmu
plant = load_fmu({str(path)!r}, isolated=True)
print(plant._session.process._popen.pid, flush=True)
plant.step([1.0])
input()
"""
    # nobody can remove the folder of a parent that is killed: let it be the test's
    parent = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )  # fmt: skip
    pid = parent.stdout.readline().strip()
    assert Path("/proc", pid).exists()
    time.sleep(0.2)
    parent.kill()
    parent.communicate()
    for _ in range(100):
        if not alive(pid):
            break
        time.sleep(0.05)
    assert not alive(pid)


def alive(pid):
    """Return whether a process runs: it may be a zombie until somebody waits for it."""
    try:
        return Path("/proc", pid, "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@VERSIONS
def test_all_that_an_fmu_can_do(tmp_path, version):
    """The same numbers, to the last bit, as inside this process."""
    path = fmu(tmp_path, version=version)
    random = np.random.default_rng(1).normal(size=50)
    with load_fmu(path) as inside, load_fmu(path, isolated=True, timeout=20.0) as plant:
        for u in random:
            np.testing.assert_array_equal(plant.step([u]), inside.step([u]))
        assert (plant.time, plant.parameters) == (inside.time, inside.parameters)
        plant.set("J", 3.0)
        assert plant.get("J") == 3.0
        state = plant.get_state()
        after = [plant.step([u]).tolist() for u in random]
        plant.set_state(state)
        assert [plant.step([u]).tolist() for u in random] == after
        for _ in range(200):
            plant.get_state()
        plant.reset({"J": 4.0})
        inside.reset({"J": 4.0})
        np.testing.assert_array_equal(plant.step({"u": 2.0}), inside.step({"u": 2.0}))
        for model in (linearize_fmu(plant), linearize_fmu(plant, horizon=50, method="impulse")):
            np.testing.assert_allclose(model.A.trace(), 2.0, rtol=1e-9)
        system = plant.system()
        steps = control.input_output_response(system, DT * np.arange(20), np.ones(20)).outputs
        np.testing.assert_allclose(np.diff(steps[1]), DT / 4.0, rtol=1e-9)


def test_two_of_them_in_a_loop(tmp_path):
    inside, isolated = [], []
    for found, own in ((inside, False), (isolated, True)):
        with (
            load_fmu(fmu(tmp_path, PD), isolated=own) as controller,
            load_fmu(fmu(tmp_path), isolated=own) as plant,
        ):
            links = [("plant.y", "c.y"), ("plant.y_rate", "c.y_rate"), ("c.u", "plant.u")]
            run = cosimulate(
                {"c": controller, "plant": plant}, [(1.0, "c.r"), *links], dt=DT, duration=0.5
            )
            found.append(run["plant.y"])
    np.testing.assert_array_equal(isolated, inside)


@VERSIONS
def test_inputs_that_it_refuses(tmp_path, version):
    """An error in setting inputs is told as such, though they travel with the step."""
    export_fmu(Inertia(2.0), tmp_path / "x.fmu", fmi_version=version, platforms=["host"])
    told = []
    for isolated in (False, True):
        with load_fmu(tmp_path / "x.fmu", isolated=isolated, dt=1.0) as block:
            block.step([1.0])
            with pytest.raises(FmuError, match=r"could not take the inputs \[nan\]") as error:
                block.step([np.nan])
            told.append(str(error.value))
            assert block.step().tolist() == [1.0, 1.0]
    assert told[0] == told[1]


def test_it_needs_no_python_control(tmp_path):
    with load_fmu(fmu(tmp_path), isolated=True) as plant:
        maps = Path("/proc", str(plant._session.process._popen.pid), "maps").read_text()
    assert "/plant.so" in maps
    assert "/scipy/" not in maps
    assert "/matplotlib/" not in maps


def test_a_timeout_needs_a_process(tmp_path):
    with pytest.raises(FmuError, match=r"timeout = 5\.0: .* give isolated=True, too"):
        load_fmu(fmu(tmp_path), timeout=5.0)
    with pytest.raises(ValueError, match="timeout = 0"):
        load_fmu(fmu(tmp_path), isolated=True, timeout=0)
