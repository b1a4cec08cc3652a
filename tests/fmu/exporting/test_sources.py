"""The C sources: clean under strict warnings, one file to compile, no names of their own."""

import platform
import re
import shutil
import subprocess
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import pytest
from compiled_once import strictly
from every_block import BLOCKS, makers
from fmus import VERSIONS, fmu_of, needs_compiler, unpacked
from tiers import some

from jounce.fmu.exporting import sources
from jounce.fmu.exporting.c_texts import WARNINGS
from jounce.fmu.exporting.compile import host_compiler
from jounce.fmu.exporting.dispatch import block_of
from jounce.fmu.exporting.sources import MAIN, licences, sources_of
from jounce.fmu.exporting.xml_fmi3 import build_description

STRICTLY_BUILT = [*product(makers(), ["3.0"]), *product(some(makers(), 6), ["2.0"])]


@needs_compiler
@pytest.mark.parametrize(("make", "version"), STRICTLY_BUILT)
def test_strict_compilers_have_nothing_to_say(make, version):
    """Tests export with every warning an error: see compiled_once."""
    assert {*WARNINGS.split(), "-Werror"} <= set(strictly(["-O2"]))
    _, where = unpacked(fmu_of(make, version))
    assert len(list(Path(where, "binaries").rglob("*.so"))) == 1


@pytest.mark.parametrize("name", BLOCKS)
def test_nothing_stands_in_them_that_msvc_does_not_know(name):
    for version in VERSIONS:
        for file, text in sources_of(block_of(BLOCKS[name]()), version, "{token}").items():
            plain = re.sub(r"(?s)/\*.*?\*/|#if defined\(NO_C_RUNTIME\).*?#endif", "", text.decode())
            if not re.fullmatch(r"fmi.*\.h", file):  # FMI's own headers tell compilers apart
                assert not re.search(r"\brestrict\b|__attribute__|/ 0\.0", plain), file


@needs_compiler
@pytest.mark.skipif(platform.machine() != "x86_64", reason="the option is for x86_64")
@pytest.mark.skipif(shutil.which("objdump") is None, reason="no objdump to list instructions with")
def test_no_multiply_add_is_fused_whatever_the_options(tmp_path):
    for file, text in sources_of(block_of(BLOCKS["trajectory"]()), "2.0", "{token}").items():
        (tmp_path / file).write_bytes(text)
    options = ["-std=gnu11", "-O2", "-mfma", "-c", "-o", "model.o"]
    subprocess.run([*host_compiler(), *options, MAIN], cwd=tmp_path, check=True)
    listed = subprocess.run(
        ["objdump", "-d", "model.o"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    assert "mulsd" in listed
    assert "vfm" not in listed
    assert "vfnm" not in listed


def test_build_description_tells_the_option_for_it():
    root = ElementTree.fromstring(build_description(block_of(BLOCKS["inertia"]()), [MAIN]))
    [files] = root.iter("SourceFileSet")
    assert files.get("compilerOptions") == "-ffp-contract=off"


def test_files_that_are_not_needed_are_left_out():
    files = sources_of(block_of(BLOCKS["inertia"]()), "3.0", "{token}")
    assert "inertia.c" in files
    assert not {"following.c", "ticks.c", "fmi2.c", "fmi2Functions.h"} & set(files)
    assert {"following.c", "follower.c", "transfer.c", "ticks.c", "lags.c", "jounce.h"} <= set(
        sources_of(block_of(BLOCKS["filtered_follower"]()), "2.0", "{token}")
    )


@needs_compiler
@pytest.mark.skipif(shutil.which("nm") is None, reason="no nm to list symbols with")
@pytest.mark.parametrize(("version", "count"), [("2.0", 34), ("3.0", 75)])
@pytest.mark.parametrize("make", makers()[1:4], ids=lambda make: make.__name__)
def test_the_library_exports_fmi_alone_and_needs_no_mathematics(make, version, count):
    _, where = unpacked(fmu_of(make, version))
    [library] = Path(where, "binaries").rglob("*.so")
    listed = subprocess.run(["nm", "-D", library], capture_output=True, text=True, check=True)
    rows = [line.split() for line in listed.stdout.splitlines()]
    exported = [row[2] for row in rows if len(row) == 3 and row[1] in "TDBR"]
    assert len(exported) == count
    assert all(name.startswith(f"fmi{version[0]}") for name in exported)
    needed = {row[1].partition("@")[0] for row in rows if row[0] == "U"}
    assert needed <= {"calloc", "free", "memcpy", "memset", "memmove"}


def test_without_fmpy_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setattr(sources, "find_spec", lambda _: None)
    with pytest.raises(ModuleNotFoundError, match="pip install fmpy"):
        sources_of(block_of(BLOCKS["inertia"]()), "2.0", "{token}")


@pytest.mark.parametrize("version", VERSIONS)
def test_licences_are_kept(version):
    texts = licences(version)
    own = (Path(__file__).parents[3] / "LICENSE").read_text(encoding="utf-8")
    assert texts["license.txt"] == own
    assert "Modelica Association" in texts["fmi_headers.txt"]
    assert "Redistributions in binary form must reproduce" in texts["fmi_headers.txt"]
