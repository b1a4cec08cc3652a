"""The names under `jounce`, and what leaves in the distributions."""

import re
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path
from shutil import copytree, ignore_patterns
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PACKAGES = ("core", "shaping", "plant", "fmu", "analysis", "plots", "app")
NOT_SENT = {"build", "dist", "out"}
MADE = (
    "__pycache__",
    ".*_cache",
    ".hypothesis",
    ".ipynb_checkpoints",
    "*.egg-info",
    "*.so",
    *NOT_SENT,
)
COMMAND = "from jounce.app.command_line import main; main()"
BUILD = """
import sys
sys.path.insert(0, "building")
import backend, compiler
compiler.FLAGS = [flag.replace("-O3", "-O0") for flag in compiler.FLAGS]  # sooner
getattr(backend, sys.argv[1])(sys.argv[2])
"""


def python(*arguments, cwd=ROOT):
    done = subprocess.run(
        [sys.executable, *arguments], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_folders_of_the_users_own_are_not_imported(tmp_path):
    for name in PACKAGES:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('the user’s own')")
    names = ", ".join(f"jounce.{name}" for name in PACKAGES)
    code = f"import {names}; print(jounce.analysis.loop_margins.__name__)"
    assert python("-c", code, cwd=tmp_path) == "loop_margins"


@pytest.mark.parametrize("name", ["jounce", *PACKAGES])
def test_each_package_says_that_it_is_typed(name):
    assert (ROOT / name / "py.typed").exists()


def test_the_name_jounce_loads_nothing(tmp_path):
    code = "import sys; before = set(sys.modules); import jounce; print(*set(sys.modules) - before)"
    assert python("-c", code, cwd=tmp_path) == "jounce"


def test_packages_are_loaded_when_asked_for(tmp_path):
    code = (
        "import sys, jounce; assert 'numpy' not in sys.modules; "
        "move = jounce.shaping.min_time_move(1.0, jounce.shaping.Limits(velocity=4.0)); "
        "assert 'control' not in sys.modules; "
        "print(move.duration, jounce.fmu.inspect_fmu.__name__, "
        "jounce.plots.draw.__name__)"
    )
    assert python("-c", code, cwd=tmp_path) == "0.25 inspect_fmu draw"


def test_names_of_jounce():
    import jounce

    assert dir(jounce) == ["__version__", *sorted(PACKAGES)]
    with pytest.raises(AttributeError, match="'jounce' has no attribute 'shapping'"):
        _ = jounce.shapping


def test_names_that_are_loaded_later_are_listed_for_completion(tmp_path):
    """From the lowest layer up, so that no package is loaded by another before."""
    listed = "; ".join(
        f"import jounce.{name} as it; print(dir(it) == sorted(it.__all__))" for name in PACKAGES
    )
    assert python("-c", listed, cwd=tmp_path).split() == ["True"] * len(PACKAGES)


def test_the_version_stands_once(tmp_path):
    asked = [("-c", "import jounce; print(jounce.__version__)"), ("-c", COMMAND, "--version")]
    printed = [python(*arguments, cwd=tmp_path) for arguments in asked]
    assert printed == [PROJECT["version"], f"jounce {PROJECT['version']}"]


@pytest.fixture(scope="module")
def sent(tmp_path_factory):
    """Names in the sdist, names in the wheel built from it, and the wheel's description."""
    folder = tmp_path_factory.mktemp("sent")
    left = ignore_patterns(".git", ".venv*", *MADE)
    copytree(ROOT, folder / "tree", ignore=left, symlinks=True)
    python("-c", BUILD, "build_sdist", folder, cwd=folder / "tree")
    name = f"jounce-{PROJECT['version']}"
    with tarfile.open(folder / f"{name}.tar.gz") as archive:
        inside = {m.name.removeprefix(f"{name}/") for m in archive.getmembers() if m.isfile()}
        archive.extractall(folder, filter="data")
    python("-c", BUILD, "build_wheel", folder, cwd=folder / name)
    [built] = folder.glob("*.whl")
    with ZipFile(built) as wheel:
        metadata = wheel.read(f"{name}.dist-info/METADATA").decode("utf-8")
        return inside, set(wheel.namelist()), metadata.partition("\n\n")[2]


def tree(*folders):
    """Return the files of a folder as they are named in the repository."""
    made = re.compile(r"/(__pycache__|[.].*_cache|.ipynb_checkpoints)/|\.so$")
    files = (p for folder in folders for p in (ROOT / folder).rglob("*") if p.is_file())
    return {name for p in files if not made.search(name := p.relative_to(ROOT).as_posix())}


def test_the_sdist_holds_what_its_tests_and_its_readme_need(sent):
    folders = ("jounce", *PACKAGES, "tests", "examples", "notebooks", "docs", "benchmarks", ".ci")
    files = {"Makefile", "README.md", "CHANGELOG.md", "LICENSE", "pyproject.toml", "setup.py"}
    assert (tree(*folders) | files) <= sent[0]


def test_the_wheel_holds_the_package_alone(sent):
    package = {
        f"jounce/{name}".replace("jounce/app/gate/plugin/", "jounce/pytest_plugin/")
        for name in tree(*PACKAGES)
    } | tree("jounce")
    information = f"jounce-{PROJECT['version']}.dist-info/"
    inside = {name for name in sent[1] if not name.startswith(information)}
    compiled = {
        name for name in inside if name.startswith("jounce/core/binding.") and ".so" in name
    }
    assert len(compiled) == 1
    assert inside - compiled == package
    assert f"{information}licenses/LICENSE" in sent[1]


def test_a_package_index_shows_the_pictures_and_follows_the_links(sent):
    address = PROJECT["urls"]["Repository"]
    assert all(url.startswith(address) for url in PROJECT["urls"].values())
    links = re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", (ROOT / "README.md").read_text("utf-8"))
    shown = re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", sent[2])
    assert any(picture for picture, _ in links)
    assert shown == [
        (picture, target)
        if target.startswith("https://")
        else (picture, f"{address}/{'raw' if picture else 'blob'}/HEAD/{target}")
        for picture, target in links
    ]
