"""Zip files: the same bytes for the same content, written whole or not at all."""

import stat
import zipfile

import pytest

from jounce.fmu.exporting.archive import archive, write_atomically


def test_order_and_time_do_not_matter(tmp_path):
    entries = {"b/x.txt": b"two", "a.txt": b"one" * 1000}
    content = archive(entries)
    assert content == archive(dict(reversed(entries.items())))
    path = tmp_path / "a.zip"
    write_atomically(path, content)
    with zipfile.ZipFile(path) as file:
        assert file.namelist() == ["a.txt", "b/x.txt"]
        assert {name: file.read(name) for name in entries} == entries
        assert {info.date_time for info in file.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_the_file_may_be_read_as_any_other(tmp_path):
    plain, written = tmp_path / "plain", tmp_path / "written"
    plain.write_bytes(b"")
    write_atomically(written, b"")
    assert stat.S_IMODE(written.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


def test_a_file_that_cannot_be_replaced_leaves_nothing_behind(tmp_path):
    target = tmp_path / "folder"
    (target / "full").mkdir(parents=True)
    with pytest.raises(OSError, match="folder"):
        write_atomically(target, b"content")
    with pytest.raises(FileNotFoundError, match=r"'\S*/no/a.fmu'$"):
        write_atomically(tmp_path / "no" / "a.fmu", b"content")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]
