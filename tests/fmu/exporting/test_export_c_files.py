"""The folder of a block's firmware: what it holds, what it replaces, what is refused."""

from pathlib import Path

import pytest
from every_block import BLOCKS

from jounce import core
from jounce.fmu import export_c
from jounce.fmu.exporting import export_c as writing
from jounce.fmu.exporting import footprint
from jounce.plant import Inertia
from jounce.shaping import Limits, min_time_move


@pytest.mark.usefixtures("unmeasured")
@pytest.mark.parametrize(
    ("name", "needed"), [("follower", "follower.c"), ("trajectory", "evaluation.c")]
)
def test_the_core_leaves_as_it_is(name, needed, tmp_path):
    made = export_c(BLOCKS[name](), tmp_path / "c")
    shipped = [path for path in made.files if path.startswith("core/")]
    assert f"core/{needed}" in shipped
    assert "core/linear.c" not in shipped
    for path in shipped:
        own = Path(core.__file__).parent / Path(path).name
        assert (made.folder / path).read_bytes() == own.read_bytes()


@pytest.mark.usefixtures("unmeasured")
def test_an_earlier_export_is_replaced_and_nothing_else(tmp_path):
    where = tmp_path / "c"
    where.mkdir()
    first = export_c(Inertia(1.0), where, name="axis")
    (where / "build").mkdir()
    (where / "build/example").write_text("built")
    second = export_c(Inertia(2.0), where, name="plant")
    assert "axis.c" in first.files
    left = [path.relative_to(where).as_posix() for path in where.rglob("*") if path.is_file()]
    assert sorted(left) == list(second.files)
    (where / "notes.txt").write_text("mine")
    with pytest.raises(FileExistsError, match=r"holds notes.txt, which no export wrote; name"):
        export_c(Inertia(1.0), where)
    (where / "notes.txt").unlink()
    (where / "main.c").write_text("mine")
    with pytest.raises(FileExistsError, match=r"main.c has been changed since it was exported"):
        export_c(Inertia(1.0), where)
    assert list(tmp_path.iterdir()) == [where]


def test_what_fails_leaves_nothing(tmp_path, monkeypatch):
    where = export_c(Inertia(1.0), tmp_path / "c").folder
    before = {path: path.read_bytes() for path in where.rglob("*") if path.is_file()}

    monkeypatch.setattr(writing, "c_files", lambda _: {"a.c": b"", "b.c": None})
    with pytest.raises(TypeError):
        export_c(Inertia(1.0), where)
    assert {path: path.read_bytes() for path in where.rglob("*") if path.is_file()} == before
    assert list(tmp_path.iterdir()) == [where]


@pytest.mark.parametrize("name", ["main", "core", "Task", "evaluation", "jounce_follow", "2axes"])
def test_names_of_the_cores_own_are_refused(name, tmp_path):
    with pytest.raises(ValueError, match=f"name = '{name}'"):
        export_c(Inertia(1.0), tmp_path / "c", name=name)
    assert list(tmp_path.iterdir()) == []


def test_folders_that_cannot_be_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(NotADirectoryError, match="is a file; name a folder"):
        export_c(Inertia(1.0), tmp_path / "file")
    with pytest.raises(FileNotFoundError, match="is not a folder; create it first"):
        export_c(Inertia(1.0), tmp_path / "a" / "b")
    with pytest.raises(ValueError, match="give its name"):
        export_c(Inertia(1.0), "")
    with pytest.raises(TypeError, match="folder = 3"):
        export_c(Inertia(1.0), 3)


def test_without_a_compiler_the_readme_says_that_nothing_was_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(footprint, "has_zig", lambda: False)
    monkeypatch.setattr(footprint, "host_compiler", lambda: None)
    made = export_c(Inertia(1.0), tmp_path / "c").folder
    assert "were not measured" in (made / "README.md").read_text(encoding="utf-8")


@pytest.mark.usefixtures("unmeasured")
def test_examples_of_trajectories_of_other_times(tmp_path):
    move = min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0)).delay(2.0)
    text = (export_c(move, tmp_path / "c", name="go").folder / "main.c").read_text("utf-8")
    assert "go_at(2.0 + (double)(k + 1) *" in text


@pytest.mark.usefixtures("unmeasured")
def test_a_folder_that_cannot_be_made_is_told_in_one_line(tmp_path, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied", str(tmp_path / ".c.1234"))

    monkeypatch.setattr(writing, "mkdtemp", refuse)
    told = rf"c': {tmp_path} cannot be written \(Permission denied\); name a folder elsewhere$"
    with pytest.raises(PermissionError, match=told):
        export_c(Inertia(1.0), tmp_path / "c")
    assert list(tmp_path.iterdir()) == []
