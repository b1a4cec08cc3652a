"""Archives built to do harm: each refused with its name, and nothing left on disk."""

import io
import stat
import struct
import warnings
import zipfile

import pytest
from handmade_fmus import INERTIA, archive, description, fmu

from jounce.plant.fmu.importing.description import FmuError
from jounce.plant.fmu.importing.load import load_fmu
from jounce.plant.fmu.importing.reading import inspect_fmu
from jounce.plant.fmu.importing.unpacking import FREE_BYTES, MAX_ENTRIES, open_fmu, unpack

pytestmark = pytest.mark.usefixtures("nothing_left")
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


@pytest.mark.parametrize("names", [("a.txt", "a.txt"), ("r/a", "r//a"), ("r/a", "./r/a")], ids=str)
def test_two_entries_of_one_name(tmp_path, names):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = archive(tmp_path / "x.fmu", [XML, *((name, b"1") for name in names)])
    refused(path, "two entries")


def test_a_second_description_is_a_duplicate(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = archive(tmp_path / "x.fmu", [XML, XML])
    refused(path, r"two entries 'modelDescription\.xml'")


def test_a_file_that_is_a_folder_too(tmp_path):
    path = fmu(tmp_path, extra=[("resources/a", b"1"), ("resources/a/b", b"2")])
    with pytest.raises(FmuError, match="collides with another entry"):
        load_fmu(path)


def test_a_zip_bomb(tmp_path):
    path = archive(tmp_path / "x.fmu", [XML, ("resources/zeros", bytes(FREE_BYTES * 2))])
    assert path.stat().st_size < FREE_BYTES / 100
    refused(path, "zip bomb")


def test_a_bomb_of_overlapping_entries(tmp_path):
    """Every name of the directory points at the same data."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("resources/000", bytes(FREE_BYTES))
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
    with pytest.raises(OSError, match="directory"):
        inspect_fmu(tmp_path)


@pytest.mark.parametrize("cut", [0.2, 0.5, 0.9, 0.99])
def test_files_cut_short(tmp_path, cut):
    path = fmu(tmp_path)
    raw = path.read_bytes()
    path.write_bytes(raw[: int(cut * len(raw))])
    refused(path, "not an FMU")
