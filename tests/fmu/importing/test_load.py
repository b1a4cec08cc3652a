"""Loading FMUs: what is refused, what runs, and that nothing stays behind."""

import ctypes
import subprocess
import sys
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from handmade_fmus import INERTIA, archive, description, fmu, sha256

from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.fmu.importing.reading import inspect_fmu

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
DT = 0.001


# What may go wrong


@VERSIONS
def test_a_wrong_digest_is_refused_before_anything_runs(tmp_path, version, monkeypatch):
    path = fmu(tmp_path, version=version)
    load_fmu(path, sha256=sha256(path).upper()).close()
    monkeypatch.setattr(ctypes, "CDLL", None)
    with pytest.raises(FmuError, match="not the file that was pinned"):
        load_fmu(path, sha256="0" * 64)


@VERSIONS
def test_a_wrong_token_is_told(tmp_path, version):
    model = replace(INERTIA, xml=(("{handmade}", "{other}"),))
    with pytest.raises(FmuError, match="cannot be instantiated: wrong"):
        load_fmu(fmu(tmp_path, model, version))


@VERSIONS
def test_after_a_failure_outside_nothing_is_left(tmp_path, version):
    """The fixture looks for what is left."""
    path = fmu(tmp_path, version=version)
    with pytest.raises(ZeroDivisionError), load_fmu(path) as plant:
        plant.step([1.0 / 0.0])
    forgotten = load_fmu(path)
    forgotten.step([1.0])
    del forgotten


def test_parameters_that_are_refused(tmp_path):
    path = fmu(tmp_path)
    with pytest.raises(FmuError, match="has no variable 'K'"):
        load_fmu(path, parameters={"K": 1.0})
    with pytest.raises(FmuError, match="'y' cannot be set"):
        load_fmu(path, parameters={"y": 1.0})
    with pytest.raises(ValueError, match="J = nan"):
        load_fmu(path, parameters={"J": np.nan})
    with load_fmu(path) as plant:
        with pytest.raises(FmuError, match="'u' is an input: give it to `step`"):
            plant.set("u", 1.0)
        with pytest.raises(FmuError, match=r"not a tunable parameter.*tunable are J"):
            plant.set("y", 1.0)
        with pytest.raises(TypeError, match="expected a number"):
            plant.set("J", "heavy")


@VERSIONS
def test_no_binary_for_this_machine(tmp_path, version):
    with pytest.raises(FmuError, match=r"no binary for this machine .*, none at all: compile its "):
        load_fmu(fmu(tmp_path, version=version, binary=False))
    foreign = [("binaries/win64/plant.dll", b"MZ"), ("binaries/x86_64-windows/plant.dll", b"MZ")]
    with pytest.raises(FmuError, match="only for win64, x86_64-windows"):
        load_fmu(fmu(tmp_path, version=version, binary=False, extra=foreign))


@VERSIONS
def test_a_library_that_is_none(tmp_path, version):
    entries = [
        ("modelDescription.xml", description(INERTIA, version).encode()),
        ("binaries/linux64/plant.so", b"not ELF"),
        ("binaries/x86_64-linux/plant.so", b"not ELF"),
    ]
    with pytest.raises(FmuError, match=r"plant\.so cannot be loaded"):
        load_fmu(archive(tmp_path / "x.fmu", entries))


@VERSIONS
def test_a_library_without_a_function(tmp_path, version):
    word = f"fmi{version[0]}DoStep"
    with pytest.raises(FmuError, match=f"no function {word}"):
        load_fmu(fmu(tmp_path, replace(INERTIA, missing=word), version))


@pytest.mark.parametrize("kind", ["ModelExchange", "ScheduledExecution"])
def test_other_kinds_than_co_simulation(tmp_path, kind):
    model = replace(INERTIA, xml=(("<CoSimulation", f"<{kind}"),))
    path = fmu(tmp_path, model, "3.0")
    word = {"ModelExchange": "model-exchange", "ScheduledExecution": "scheduled-execution"}[kind]
    match = f"plant is for {word} only: export it for co-simulation from by hand, with its solver"
    with pytest.raises(FmuError, match=match):
        load_fmu(path)
    says = inspect_fmu(path)
    assert (says.kinds, len(says.variables)) == ((word,), 8)


@VERSIONS
def test_one_that_says_that_it_needs_its_tool_is_tried(tmp_path, version):
    flag = ("<CoSimulation", '<CoSimulation needsExecutionTool="true"')
    path = fmu(tmp_path, replace(INERTIA, xml=(flag,)), version)
    with load_fmu(path) as plant:
        assert plant.step([1.0])[1] == 0.0005
    told = r" \(it declares needsExecutionTool: it may need the tool that made it, by hand, on "
    with pytest.raises(FmuError, match=f"could not be initialised{told}.*: parameter too small"):
        load_fmu(path, parameters={"J": -1e7})
    with pytest.raises(FmuError, match=f"instantiated: wrong .*{told}"):
        load_fmu(fmu(tmp_path, replace(INERTIA, xml=(flag, ("{handmade}", "{other}"))), version))


def test_a_file_changed_on_the_way_is_not_run(tmp_path):
    """A library with a wrong checksum is damage, not code to run."""
    path = fmu(tmp_path)
    with zipfile.ZipFile(path) as packed:
        place = packed.getinfo("binaries/linux64/plant.so").header_offset
    raw = bytearray(path.read_bytes())
    raw[place + 200] ^= 255
    path.write_bytes(bytes(raw))
    with pytest.raises(FmuError, match="damaged"):
        load_fmu(path)


@VERSIONS
def test_only_loading_runs_code_of_the_file(tmp_path, version):
    """A library's initialiser writes a file as soon as the library is loaded."""
    told = tmp_path / "told.txt"
    prelude = f"""
    #include <stdio.h>
    __attribute__((constructor)) static void tell(void) {{ fclose(fopen("{told}", "w")); }}
    """
    path = fmu(tmp_path, replace(INERTIA, name="teller", prelude=prelude), version)
    inspect_fmu(path)
    with pytest.raises(FmuError, match="pinned"):
        load_fmu(path, sha256="0" * 64)
    assert not told.exists()
    load_fmu(path, sha256=sha256(path)).close()
    assert told.exists()


def test_a_process_that_ends_leaves_nothing(tmp_path):
    path = fmu(tmp_path)
    code = (
        "import tempfile; from jounce.fmu.importing.load import load_fmu; "
        f"tempfile.tempdir = {str(tmp_path / 'temporary')!r}; "
        f"plant = load_fmu({str(path)!r}); state = plant.get_state(); system = plant.system(); "
        "print(plant.step([1.0])[1]); raise SystemExit(3)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (3, "0.0005\n", "")


def test_a_structural_parameter_stays(tmp_path):
    sized = replace(INERTIA, xml=(('name="J"', 'name="n"'), ('causality="parameter"',
                    'causality="structuralParameter"')))  # fmt: skip
    with pytest.raises(FmuError, match="'n' is a structural parameter"):
        load_fmu(fmu(tmp_path, sized, "3.0"), parameters={"n": 3})
