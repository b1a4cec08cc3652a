"""Files read whole: content whatever the platform wrote, and what is wrong with those that fail."""

import pytest

from jounce.app.text_files import read_json, read_toml

READERS = {"toml": (read_toml, b"a = 1\nb = 'x'\n"), "json": (read_json, b'{"a": 1,\n"b": "x"}\n')}


@pytest.fixture(params=sorted(READERS))
def reader(request):
    return READERS[request.param]


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["plain", "mark"])
@pytest.mark.parametrize("ends", [b"\n", b"\r\n"], ids=["lf", "crlf"])
def test_content_is_the_same_whatever_the_platform(tmp_path, reader, mark, ends):
    read, text = reader
    path = tmp_path / "file"
    path.write_bytes(mark + text.replace(b"\n", ends))
    assert read(path, "a file") == {"a": 1, "b": "x"}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\xff", "byte 0 is not UTF-8; save the file as UTF-8 text"),
        (b"a = [", ": not "),
        (b"\0", "; "),
        (b"a = " + b"[" * 99999, "a number of thousands of digits or brackets nested too deeply"),
        (b"a = " + b"9" * 9999, "a number of thousands of digits or brackets nested too deeply"),
    ],
    ids=["bytes", "cut", "nul", "nested", "digits"],
)
def test_what_cannot_be_read_is_one_line(tmp_path, reader, content, words):
    read, text = reader
    path = tmp_path / "file"
    if text.startswith(b"{"):
        content = content.removeprefix(b"a = ")
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"\S") as refusal:
        read(path, "a file")
    message = str(refusal.value)
    assert message.startswith(f"{path}: ")
    assert words in message
    assert "\n" not in message


@pytest.mark.parametrize("name", ["", "absent", "a\0b"], ids=["folder", "absent", "nul"])
def test_what_is_no_file_is_named(tmp_path, reader, name):
    with pytest.raises(ValueError, match=r"; name a file$"):
        reader[0](tmp_path / name, "a file")
