"""export_fmu: what is in the file, the same bytes every time, whole or not at all."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from every_block import BLOCKS
from fmpy.validation import validate_fmu
from fmus import SLOW, VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu import CompilerError, export_fmu
from jounce.fmu.exporting import compile, export
from jounce.fmu.exporting.ssp import export_ssp_of
from jounce.plant import Inertia
from jounce.shaping import Limits, min_time_move


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", BLOCKS)
@pytest.mark.parametrize("unit", some(["1", "rad", "mm"], 2))
def test_fmpy_finds_no_fault(name, version, unit, tmp_path):
    path = tmp_path / "a.fmu"
    linear = name in ("transfer_function", "gain", "discrete_system")
    export_fmu(
        BLOCKS[name](), path, fmi_version=version, platforms=[], unit="1" if linear else unit
    )
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(path)
    assert description.fmiVersion == version
    assert description.defaultExperiment.stepSize is not None
    assert all(variable.description for variable in description.modelVariables)
    assert all(variable.unit for variable in description.modelVariables)


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_in_the_file(version, tmp_path):
    made = export_fmu(Inertia(1.0), tmp_path / "a.fmu", fmi_version=version, platforms=[])
    with zipfile.ZipFile(made.path) as file:
        names = file.namelist()
        page = file.read("documentation/index.html").decode()
    assert names == sorted(names)
    assert {
        "modelDescription.xml",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "documentation/licenses/fmi_headers.txt",
        "sources/model.c",
        "sources/inertia.c",
    } <= set(names)
    assert ("sources/buildDescription.xml" in names) == (version == "3.0")
    assert "Moment of inertia" in page
    assert "http" not in page


def test_documentation_tells_of_the_delay_of_a_tick(tmp_path):
    for name in ("controller", "discrete_system", "follower"):
        made = export_fmu(BLOCKS[name](), tmp_path / "a.fmu", platforms=[])
        with zipfile.ZipFile(made.path) as file:
            page = file.read("documentation/index.html").decode()
        assert "Sample k runs in the communication step that starts at" in page
        assert "at its end" in page or "at the end of the step in which it runs" in page


@needs_compiler
@pytest.mark.parametrize("version", VERSIONS)
def test_the_same_bytes_every_time(version, tmp_path, monkeypatch):
    monkeypatch.setattr(export, "build", compile.build)  # not what was built before
    made = []
    for where in ("a", "b"):
        folder = tmp_path / where
        folder.mkdir()
        monkeypatch.setenv("TMPDIR", str(folder))
        monkeypatch.chdir(folder)
        path = folder / f"{where}.fmu"
        export_fmu(BLOCKS["trajectory"](), path, fmi_version=version, platforms=["host"])
        made.append(path.read_bytes())
        assert str(tmp_path).encode() not in made[-1]
        assert [file.name for file in folder.iterdir()] == [path.name]
    assert made[0] == made[1]
    with zipfile.ZipFile(path) as file:
        assert not any(b"jounce_fmu_" in file.read(name) for name in file.namelist())


def test_other_numbers_get_another_token(tmp_path):
    tokens = set()
    for inertia in (1.0, 2.0):
        for version in VERSIONS:
            path = tmp_path / "a.fmu"
            export_fmu(Inertia(inertia), path, fmi_version=version, platforms=[])
            description = fmpy.read_model_description(path)
            tokens.add(description.guid or description.instantiationToken)
    assert len(tokens) == 4


def test_a_build_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.fmu"
    path.write_bytes(b"old")

    def refuse(*_):
        raise CompilerError("no")

    monkeypatch.setattr(export, "build", refuse)
    with pytest.raises(CompilerError):
        export_fmu(Inertia(1.0), path, platforms=["x86_64-linux"])
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_without_a_compiler_there_are_sources_and_a_note(tmp_path, monkeypatch):
    monkeypatch.setattr(compile, "host_compiler", lambda: None)
    monkeypatch.setattr(compile, "has_zig", lambda: False)
    made = export_fmu(Inertia(1.0), tmp_path / "a.fmu")
    assert made.platforms == ()
    [note] = made.notes
    assert "holds sources only" in note
    assert "install a C compiler" in note
    with pytest.raises(CompilerError, match=r"for x86_64-windows: install .* ziglang"):
        export_fmu(Inertia(1.0), tmp_path / "b.fmu", platforms=["x86_64-windows"])
    assert not (tmp_path / "b.fmu").exists()


@pytest.mark.parametrize(
    ("wrong", "error", "told"),
    [
        ({"fmi_version": "1.0"}, ValueError, "expected '2.0' or '3.0'"),
        ({"fmi_version": 3.0}, ValueError, "expected '2.0' or '3.0'"),
        ({"platforms": ["amiga"]}, ValueError, "platform 'amiga': expected host, x86_64-linux"),
        ({"platforms": "x86_64-linux"}, TypeError, "expected a list"),
        ({"path": "missing/a.fmu"}, FileNotFoundError, "create it first"),
    ],
    ids=["version 1", "a number", "platform", "text", "folder"],
)
def test_wrong_arguments_are_refused(wrong, error, told, tmp_path):
    path = tmp_path / wrong.pop("path", "a.fmu")
    with pytest.raises(error, match=told):
        export_fmu(Inertia(1.0), path, **wrong)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ("", ValueError, "path = '': expected the path of a file"),
        ("here", IsADirectoryError, "path = 'here': is a folder; name a file in it"),
        ("no/a.fmu", FileNotFoundError, "path = 'no/a.fmu': no is not a folder; create it first"),
        (5, TypeError, "path = 5: expected the path of a file"),
    ],
    ids=["empty", "folder", "missing folder", "number"],
)
def test_a_path_that_is_no_file_is_refused(given, error, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("here").mkdir()
    with pytest.raises(error, match=told):
        export_fmu(Inertia(1.0), given, platforms=[])
    with pytest.raises(error, match=told):
        export_ssp_of(given, {"axis": Inertia(1.0)}, [], dt=1.0, duration=1.0, platforms=[])
    assert [path.name for path in tmp_path.rglob("*")] == ["here"]


@pytest.mark.parametrize("version", VERSIONS)
@needs_compiler
def test_a_serialised_state_of_another_length_is_refused(version):
    host = Host(fmu_of(BLOCKS["inertia"], version)).run()
    fmu = host.fmu
    if host.old:
        get, pack, unpack = fmu.getFMUstate, fmu.serializeFMUstate, fmu.deSerializeFMUstate
    else:
        get, pack, unpack = fmu.getFMUState, fmu.serializeFMUState, fmu.deserializeFMUState
    data = bytes(pack(get()))
    unpack(data)
    for wrong in (data + b"x", data[:-1], data[:10], data + data):
        told = f"size = {len(wrong)}: expected a serialised state of {len(data)}"
        assert host.refused(unpack, wrong) == told
    host.close()


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("make") is None, reason="no make for cmake to use")
@needs_compiler
@pytest.mark.parametrize("version", VERSIONS if SLOW else VERSIONS[1:])
def test_fmpy_compiles_the_sources(version, tmp_path, monkeypatch):
    path = tmp_path / "a.fmu"
    move = min_time_move(2.0, Limits(velocity=1.0, acceleration=2.0, jerk=10.0))
    assert export_fmu(move, path, fmi_version=version, platforms=[]).notes == ()
    bin_folder = Path(sys.executable).parent
    monkeypatch.setenv("PATH", f"{bin_folder}{os.pathsep}{os.environ['PATH']}")
    command = [sys.executable, "-m", "fmpy", "compile", str(path)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    host = Host(path).run()
    rows = host.record([0.01] * 100, "position", "jerk")
    host.close()
    expected = move.evaluate(np.add.accumulate([0.01] * 100))
    np.testing.assert_allclose(rows, expected[[0, 3]], rtol=0.0, atol=1e-12)
