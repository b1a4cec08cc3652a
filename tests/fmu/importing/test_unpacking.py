"""Archives built to do harm: each refused with its name, and nothing left on disk."""

import io
import os
import stat
import struct
import subprocess
import warnings
import zipfile
from dataclasses import replace

import pytest
from handmade_fmus import INERTIA, archive, description, fmu, sha256

from jounce.fmu.importing import unpacking
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.fmu.importing.reading import inspect_fmu
from jounce.fmu.importing.unpacking import MAX_ENTRIES, open_fmu, unpack

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
XML = ("modelDescription.xml", description(INERTIA, "2.0").encode())


def linked(name, mode):
    entry = zipfile.ZipInfo(name)
    entry.create_system = 3
    entry.external_attr = (mode | 0o777) << 16
    return entry


def refused(path, match):
    for read in (inspect_fmu, load_fmu):
        with pytest.raises(FmuError, match=match):
            read(path)


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("../outside.txt", "leaves the archive"),
        ("resources/../../outside.txt", "leaves the archive"),
        ("..", "leaves the archive"),
        ("/etc/outside.txt", "absolute path"),
        ("//server/share/x", "absolute path"),
        ("C:/outside.txt", "absolute path"),
        ("c:outside.txt", "absolute path"),
        ("resources\\..\\..\\outside.txt", "plain relative paths"),
        (linked("resources/link", stat.S_IFLNK), "link or a device"),
        (linked("binaries/linux64/plant.so", stat.S_IFLNK), "link or a device"),
        (linked("resources/fifo", stat.S_IFIFO), "link or a device"),
        (linked("resources/device", stat.S_IFCHR), "link or a device"),
    ],
    ids=str,
)
def test_entries_that_no_honest_fmu_has(tmp_path, name, match):
    refused(archive(tmp_path / "x.fmu", [XML, (name, b"/etc/passwd")]), match)
    assert not list(tmp_path.rglob("outside.txt"))


def doubled(path, first, second):
    """Return an FMU with two more entries, which may have one name."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return fmu(path, extra=[first, second])


NAMES = [("a.txt", "a.txt"), ("r/a", "r//a"), ("r/a", "./r/a")]


@pytest.mark.parametrize("names", NAMES, ids=str)
def test_two_entries_of_one_name_that_differ(tmp_path, names):
    path = doubled(tmp_path, *zip(names, (b"1", b"2"), strict=True))
    refused(path, f"two entries '{names[0]}' that differ")


@pytest.mark.parametrize("names", [*NAMES, ("sources/", "sources/")], ids=str)
def test_two_entries_of_one_name_that_are_the_same(tmp_path, names):
    content = b"" if names[0].endswith("/") else b"1"
    path = doubled(tmp_path, *((name, content) for name in names))
    assert inspect_fmu(path).model_name == "plant"
    with load_fmu(path) as plant:
        assert plant.step([1.0])[1] == 0.0005


@VERSIONS
def test_paths_that_begin_with_a_dot(tmp_path, version):
    """As tar writes them."""
    with zipfile.ZipFile(fmu(tmp_path, version=version)) as packed:
        entries = [(f"./{name}", packed.read(name)) for name in packed.namelist()]
    path = archive(tmp_path / "x.fmu", [("./", b""), ("./sources/", b""), *entries])
    assert inspect_fmu(path).has_sources
    assert len(inspect_fmu(path).platforms) == 1
    with load_fmu(path) as plant:
        assert plant.step([1.0])[1] == 0.0005


def test_a_file_and_a_folder_of_one_name_differ(tmp_path):
    refused(doubled(tmp_path, ("a", b""), ("a/", b"")), "two entries 'a' that differ")


def test_a_second_description(tmp_path):
    assert inspect_fmu(doubled(tmp_path, XML, ("a", b""))).model_name == "plant"
    other = (XML[0], XML[1].replace(b"by hand", b"by foot"))
    refused(
        doubled(tmp_path, other, ("a", b"")), r"two entries 'modelDescription\.xml' that differ"
    )


def test_a_file_that_is_a_folder_too(tmp_path):
    path = fmu(tmp_path, extra=[("resources/a", b"1"), ("resources/a/b", b"2")])
    with pytest.raises(FmuError, match="collides with another entry"):
        load_fmu(path)


def test_a_zip_bomb(tmp_path, monkeypatch):
    monkeypatch.setattr(unpacking, "FREE_BYTES", 2**22)
    path = fmu(tmp_path, extra=[("resources/zeros", bytes(2**23))])
    assert path.stat().st_size < 2**22 / unpacking.MAX_RATIO
    refused(path, "zip bomb")
    with zipfile.ZipFile(path) as packed:
        size = sum(entry.file_size for entry in packed.infolist())
    with pytest.raises(FmuError, match=rf"max_unpacked_bytes={size} .*--max-size {size}\)"):
        inspect_fmu(path)
    for read in (inspect_fmu, load_fmu):
        with pytest.raises(FmuError, match="zip bomb"):
            read(path, max_unpacked_bytes=size - 1)
        with pytest.raises(ValueError, match="max_unpacked_bytes = -1"):
            read(path, max_unpacked_bytes=-1)
    assert inspect_fmu(path, max_unpacked_bytes=size).model_name == "plant"
    load_fmu(path, max_unpacked_bytes=size).close()


def test_much_that_packs_well_is_no_bomb(tmp_path):
    path = fmu(tmp_path, extra=[("resources/zeros", bytes(40_000_000))])
    assert path.stat().st_size < 100_000
    load_fmu(path).close()


def test_a_bomb_of_overlapping_entries(tmp_path):
    """Every name of the directory points at the same data."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("resources/000", bytes(2**24))
    raw = data.getvalue()
    start = raw.index(b"PK\x01\x02")
    end = raw.index(b"PK\x05\x06")
    names = [f"resources/{i:03d}".encode() for i in range(100)]
    directory = b"".join(raw[start:end].replace(b"resources/000", name) for name in names)
    tail = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, 100, 100, len(directory), start, 0)
    path = tmp_path / "x.fmu"
    path.write_bytes(raw[:start] + directory + tail)
    refused(path, "zip bomb")


def test_an_entry_that_lies_about_its_size(tmp_path):
    path = archive(tmp_path / "x.fmu", [XML, ("resources/zeros", bytes(10**6))])
    raw = path.read_bytes().replace(struct.pack("<L", 10**6), struct.pack("<L", 10))
    path.write_bytes(raw)
    with open_fmu(path) as (packed, _), pytest.raises(FmuError, match=r"damaged|collides"):
        unpack(packed, tmp_path / "temporary" / "folder")
    files = list((tmp_path / "temporary").rglob("zeros"))
    assert sum(file.stat().st_size for file in files) <= 10
    for file in sorted((tmp_path / "temporary").rglob("*"), reverse=True):
        file.rmdir() if file.is_dir() else file.unlink()


def test_too_many_entries(tmp_path):
    entries = [XML, *((f"resources/{i}", b"") for i in range(MAX_ENTRIES))]
    refused(archive(tmp_path / "x.fmu", entries), "entries; expected at most")


def test_encrypted_and_strangely_packed_entries(tmp_path):
    path = tmp_path / "x.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_BZIP2) as packed:
        packed.writestr(*XML)
    refused(path, "packed by method 12")
    raw = bytearray(archive(path, [XML]).read_bytes())
    raw[raw.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(bytes(raw))
    refused(path, "encrypted")


@pytest.mark.parametrize("content", [b"", b"PK", b"no zip at all", bytes(1000)], ids=repr)
def test_what_is_no_zip(tmp_path, content):
    path = tmp_path / "x.fmu"
    path.write_bytes(content)
    refused(path, "not an FMU")


def test_damaged_bytes(tmp_path):
    path = fmu(tmp_path)
    raw = bytearray(path.read_bytes())
    raw[60:90] = bytes(30)
    path.write_bytes(bytes(raw))
    refused(path, "damaged")


def test_a_missing_file_and_a_folder(tmp_path):
    with pytest.raises(FileNotFoundError):
        inspect_fmu(tmp_path / "none.fmu")
    with pytest.raises(OSError, match=r"directory without a modelDescription\.xml"):
        inspect_fmu(tmp_path)


@pytest.mark.parametrize("cut", [0.2, 0.5, 0.9, 0.99])
def test_files_cut_short(tmp_path, cut):
    path = fmu(tmp_path)
    raw = path.read_bytes()
    path.write_bytes(raw[: int(cut * len(raw))])
    refused(path, "not an FMU")


# Folders


def unpacked(folder, path):
    with zipfile.ZipFile(path) as packed:
        packed.extractall(folder)
    return folder


@VERSIONS
def test_a_folder_is_as_good_as_its_archive(tmp_path, version):
    path = fmu(tmp_path, version=version)
    folder = unpacked(tmp_path / "plant", path)
    (folder / "resources").mkdir()
    before = sorted(folder.rglob("*"))
    says = inspect_fmu(folder)
    assert replace(says, sha256="") == replace(inspect_fmu(path), sha256="")
    with load_fmu(folder, sha256=says.sha256) as one, load_fmu(folder) as two:
        assert one.step([1.0])[1] == 0.0005
        assert two.step([2.0])[1] == 0.001
    assert sorted(folder.rglob("*")) == before
    with pytest.raises(FmuError, match="not the file that was pinned"):
        load_fmu(folder, sha256=sha256(path))


def test_the_digest_of_a_folder_is_what_its_docstring_says(tmp_path):
    folder = unpacked(tmp_path / "plant", fmu(tmp_path))
    command = "find . -type f | sed 's:^./::' | LC_ALL=C sort | xargs sha256sum | sha256sum"
    told = subprocess.run(command, shell=True, cwd=folder, capture_output=True, check=True)
    assert inspect_fmu(folder).sha256 == told.stdout.decode().split()[0]
    (folder / "sources" / "model.c").write_text("other")
    assert inspect_fmu(folder).sha256 != told.stdout.decode().split()[0]


def test_links_in_folders_are_refused(tmp_path):
    folder = unpacked(tmp_path / "plant", fmu(tmp_path))
    (folder / "resources").symlink_to("/etc")
    refused(folder, "resources is a link or a device")
    (folder / "resources").unlink()
    os.mkfifo(folder / "fifo")
    refused(folder, "fifo is a link or a device")


def test_folders_of_too_much(tmp_path, monkeypatch):
    folder = unpacked(tmp_path / "plant", fmu(tmp_path))
    for read in (inspect_fmu, load_fmu):
        with pytest.raises(FmuError, match="expected at most 20000 files and 1000 bytes"):
            read(folder, max_unpacked_bytes=1000)
    monkeypatch.setattr(unpacking, "MAX_ENTRIES", 2)
    refused(folder, "at most 2 files")
