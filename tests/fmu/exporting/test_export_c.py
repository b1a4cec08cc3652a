"""Blocks as C for firmware: what is compiled and run gives the bits that Python gives."""

import shutil
import struct
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from itertools import product

import control
import numpy as np
import pytest
from every_block import BLOCKS
from firmware import STRICT, driven, library
from fmus import SLOW, folder, needs_compiler, pointer
from scipy.linalg import expm
from tiers import some

from jounce.core import advance_lags
from jounce.fmu import SampledController, export_c
from jounce.fmu.exporting import export_c as writing
from jounce.fmu.exporting import footprint
from jounce.plant import PID, Inertia, InertiaFeedforward
from jounce.shaping import CommandFollower, JerkFilter, Limits

COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
NAMES = sorted(BLOCKS)
DT = 0.01


@cache
def exported(name):
    """Return the folder of a block's firmware, exported once; measured in the long tier."""
    with pytest.MonkeyPatch.context() as patch:
        if not SLOW:
            patch.setattr(writing, "measure", lambda *_: None)
        return export_c(BLOCKS[name](), folder() / f"c_{name}", name=name).folder


@cache
def compiled(where, compiler="gcc", *options):
    """Return the output of a folder's example."""
    optimised = "-O1" if SLOW else "-O0"
    flags = " ".join((optimised, "-Werror", *options))
    make = ["make", "-s", "-B", f"CC={compiler}", f"CFLAGS={flags}"]
    subprocess.run(make, cwd=where, check=True)
    made = subprocess.run([where / "build/example"], capture_output=True, text=True, check=True)
    return np.array([line.split() for line in made.stdout.splitlines()], dtype=float).T


@pytest.mark.skipif(not COMPILERS, reason="neither gcc nor clang")
@pytest.mark.parametrize("name", some(NAMES, 8))
def test_every_block_compiles_without_a_word_and_runs(name):
    compilers = COMPILERS if name in some(NAMES, 4) else COMPILERS[:1]
    rows = [compiled(exported(name), compiler) for compiler in compilers]
    assert np.isfinite(rows[0]).all()
    assert rows[0].size > 0
    for other in rows[1:]:
        np.testing.assert_array_equal(other, rows[0])


@pytest.mark.skipif(not COMPILERS, reason="neither gcc nor clang")
@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_trajectory_is_pythons_to_the_last_bit(compiler):
    trajectory = BLOCKS["trajectory"]()
    times = trajectory.start_time + np.arange(1.0, 1001.0) * (trajectory.duration / 1000)
    expected = [trajectory(times, k) for k in range(trajectory.order + 1)]
    np.testing.assert_array_equal(compiled(exported("trajectory"), compiler), expected)


@pytest.mark.skipif(not COMPILERS, reason="neither gcc nor clang")
@pytest.mark.parametrize(
    ("name", "compiler"), some(product(["follower", "filtered_follower"], COMPILERS), 2)
)
def test_the_followers_example_is_pythons_to_the_last_bit(name, compiler):
    expected = BLOCKS[name]().run(np.ones(1000)).states
    np.testing.assert_array_equal(compiled(exported(name), compiler), expected)


@pytest.mark.usefixtures("unmeasured")
@needs_compiler
@pytest.mark.parametrize("seed", range(6 if SLOW else 1))
@pytest.mark.parametrize(
    ("limits", "more"),
    [
        (Limits(velocity=(-1.0, 0.4), acceleration=(-3.0, 0.7)), {"period": 0.5}),
        (Limits(velocity=(-1.0, 0.4), acceleration=(-3.0, 0.7), jerk=(-20.0, 30.0)), {}),
        (Limits(velocity=1.0, acceleration=3.0, jerk=40.0), {"jerk_filter": JerkFilter(3.0, 4)}),
    ],
    ids=["order 2, period", "order 3", "order 3, filter"],
)
def test_followers_of_random_commands_are_pythons_to_the_last_bit(limits, more, seed, tmp_path):
    follower = CommandFollower(limits, dt=DT, **more)
    rng = np.random.default_rng(seed)
    command = np.repeat(rng.normal(size=100), 20) + 0.1 * rng.normal(size=2000)
    velocity = np.repeat(0.3 * rng.normal(size=100), 20)
    expected = follower.run(command, command_velocities=velocity).states
    inputs = {"command": command, "command_velocity": velocity}
    outputs = ["position", "velocity", "acceleration", "jerk"][: follower.order + 1]
    rows = driven(follower, tmp_path / "c", inputs, outputs)
    np.testing.assert_array_equal(rows, expected)


@pytest.mark.usefixtures("unmeasured")
@needs_compiler
def test_the_controller_is_its_formula_to_the_last_bit(tmp_path):
    source = SampledController(PID(10.0, 20.0, 3.0), DT, InertiaFeedforward(2.0))
    rng = np.random.default_rng(1)
    names = ("r", "r_rate", "r_acceleration", "y", "y_rate")
    given = {name: rng.normal(size=500) for name in names}
    expected, integral = [], 0.0
    for r, r_rate, r_acceleration, y, y_rate in zip(*given.values(), strict=True):
        u = 10.0 * (r - y) + 20.0 * (integral + DT * (r - y)) + 3.0 * (r_rate - y_rate)
        expected.append(u + 2.0 * r_acceleration)
        integral += DT * (r - y)
    np.testing.assert_array_equal(driven(source, tmp_path / "c", given, ["u"])[0], expected)


@pytest.mark.usefixtures("unmeasured")
@needs_compiler
def test_a_discrete_system_is_its_sums_to_the_last_bit(tmp_path):
    a, b, c, d = [[0.5, 1.0], [-0.3, 0.2]], [0.25, 1.0], [1.0, -0.7], 2.0
    system = control.ss(a, [[b[0]], [b[1]]], [c], [[d]], DT, inputs=["int"], outputs=["1 %"])
    given = np.random.default_rng(2).normal(size=400)
    expected, x = [], [0.0, 0.0]
    for u in given:
        expected.append(c[0] * x[0] + c[1] * x[1] + d * u)
        x = [row[0] * x[0] + row[1] * x[1] + own * u for row, own in zip(a, b, strict=True)]
    rows = driven(system, tmp_path / "c", {"int_": given}, ["n1"])
    np.testing.assert_array_equal(rows[0], expected)


@pytest.mark.skipif(not COMPILERS, reason="neither gcc nor clang")
def test_continuous_blocks_are_exact():
    rows = compiled(exported("transfer_function"), COMPILERS[0])
    system = control.ss(BLOCKS["transfer_function"]())
    count, step = rows.shape[1], 0.01
    both = expm(step * np.block([[system.A, system.B], [np.zeros((1, 4))]]))
    x, expected = np.zeros(3), []
    for _ in range(count):
        x = both[:3, :3] @ x + both[:3, 3]
        expected.append((system.C @ x)[0])
    np.testing.assert_allclose(rows[0], expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.skipif(not COMPILERS, reason="neither gcc nor clang")
def test_the_jerk_filters_lags_are_pythons_to_the_last_bit():
    jerk_filter = BLOCKS["jerk_filter"]()
    step = jerk_filter.settling_time(1e-6) / 1000
    lags, expected = (0.0,) * 4, []
    for _ in range(1000):
        lags = advance_lags(lags, (1.0, 0.0, 0.0), step, 2.0 * np.pi * jerk_filter.corner_hz)
        expected.append(lags[-1])
    np.testing.assert_array_equal(compiled(exported("jerk_filter"), COMPILERS[0])[0], expected)


@pytest.mark.usefixtures("unmeasured")
@needs_compiler
def test_start_takes_states_over_and_what_is_refused_changes_nothing(tmp_path):
    where = export_c(Inertia(2.0), tmp_path / "c", name="axis", unit="rad").folder
    code = """#include "axis.h"
int drive(double *out);
int drive(double *out) {
    static axis_block block;
    int k = 0;
    axis_init(&block);
    block.y = 3.0;
    block.y_rate = -1.0;
    out[k++] = axis_start(&block) + 10.0 * (sizeof block == 8 * 15);
    out[k++] = axis_step(0.5, &block);
    out[k++] = block.y;
    block.J = -1.0;
    out[k++] = axis_step(0.5, &block) + 10 * axis_start(&block);
    out[k++] = block.y;
    block.J = 1e-300;
    block.u = 1e300 * 1e300;
    out[k++] = axis_step(0.5, &block);
    block.u = 1e300;
    out[k++] = axis_step(0.5, &block) + 10 * axis_step(0.0, &block);
    return k;
}
"""
    out = np.empty(7)
    assert library(where, code).drive(pointer(out)) == 7
    assert out.tolist() == [10.0, 0.0, 2.5, 11.0, 2.5, 1.0, 11.0]
    assert "`sizeof(axis_block)`" in (where / "README.md").read_text(encoding="utf-8")
    assert "block: 120 bytes" in (where / "README.md").read_text(encoding="utf-8")


@pytest.mark.usefixtures("unmeasured")
@needs_compiler
def test_two_blocks_share_the_core_in_one_program(tmp_path):
    first = export_c(BLOCKS["follower"](), tmp_path / "a", name="pan").folder
    second = export_c(BLOCKS["filtered_follower"](), tmp_path / "b", name="tilt").folder
    for file in ("tilt.c", "tilt.h"):
        shutil.copy(second / file, first)
    code = """#include "pan.h"
#include "tilt.h"
int drive(void);
int drive(void) {
    static pan_block pan;
    static tilt_block tilt;
    return pan_init(&pan) + tilt_init(&tilt) + pan_step(&pan) + tilt_step(&tilt);
}
"""
    assert library(first, code).drive() == 0


def test_no_heap_no_mathematics_library_no_globals():
    for name in NAMES:
        for path in exported(name).rglob("*.[ch]"):
            if path.name != "main.c" and "build" not in path.parts:
                text = path.read_text(encoding="utf-8")
                assert not {"malloc(", "calloc(", "<math.h>", "<stdlib.h>"} & set(text.split())
                assert "<math.h>" not in text
                assert "alloc(" not in text


@pytest.mark.skipif(find_spec("ziglang") is None, reason="no ziglang to compile for ARM with")
@pytest.mark.parametrize("name", NAMES if SLOW else ["filtered_follower", "flexible_inertia"])
def test_it_compiles_for_a_cortex_m4_that_has_nothing(name, tmp_path):
    target = ["-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m4", "-Os", "-c"]
    zig = [sys.executable, "-m", "ziglang", "cc", *target, *STRICT.split()]
    where = exported(name)
    for path in [where / f"{name}.c", *(where / "core").glob("*.c")]:
        made = tmp_path / f"{path.stem}.o"
        subprocess.run([*zig, path, "-o", made], cwd=where, check=True)
        assert struct.unpack_from("<4sB13xH", made.read_bytes()) == (b"\x7fELF", 1, 40)  # ARM


@needs_compiler
@pytest.mark.skipif(sys.platform != "linux", reason="it reads objects of Linux")
def test_the_stack_told_is_what_a_run_uses(tmp_path, monkeypatch):
    monkeypatch.setattr(footprint, "has_zig", lambda: False)
    follower = CommandFollower(Limits(1.0, 2.0, 30.0), dt=DT)
    made = export_c(follower, tmp_path / "c", name="follower").folder
    text = (made / "README.md").read_text(encoding="utf-8")
    told = int(text.partition("at most ")[2].split()[0])
    (made / "build").mkdir()
    used = library(made, ON_A_STACK_OF_ITS_OWN, "-Os").drive()
    assert told / 4 < used <= told + 1024  # the context's own


ON_A_STACK_OF_ITS_OWN = """
#define _XOPEN_SOURCE 700
#include <ucontext.h>
#include "follower.h"
static unsigned char room[1 << 17];
static ucontext_t here, there;
static follower_block block;
static int refused;
int drive(void);
static void run(void) {
    int k;
    refused = follower_init(&block);
    for (k = 0; k < 400; k++) {
        block.command = k / 20 % 2 ? 1.0 : -0.3;
        block.velocity_max = k / 30 % 2 ? 1.0 : 0.2;
        refused += follower_step(&block);
    }
}
int drive(void) {
    int k, size = (int)sizeof room;
    for (k = 0; k < size; k++) {
        room[k] = 0xA5;
    }
    getcontext(&there);
    there.uc_stack.ss_sp = room;
    there.uc_stack.ss_size = sizeof room;
    there.uc_link = &here;
    makecontext(&there, run, 0);
    swapcontext(&here, &there);
    for (k = 0; k < size && room[k] == 0xA5; k++) {
    }
    return refused ? -1 : size - k;
}
"""
