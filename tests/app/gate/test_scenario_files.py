"""Names and patterns: every scenario once, nothing else, and nothing left out in silence."""

from pathlib import Path

import pytest

from jounce.app.gate.scenario_files import scenario_files


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """Work among scenarios, their baselines and check files, and other files."""
    names = (
        "a.toml",
        "a.check.toml",
        "axes/b.toml",
        "axes/b.check.toml",
        "axes/b.baseline.json",
        "axes/c.toml",
        "axes/notes.md",
        "axes/deep/d.toml",
        "odd [1].toml",
    )
    for name in names:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    (tmp_path / "axes" / "folder.toml").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["a.toml"], ["a.toml"]),
        (["axes/c.toml", "a.toml"], ["axes/c.toml", "a.toml"]),
        (["axes/*.toml"], ["axes/b.toml", "axes/c.toml"]),
        (["axes/*"], ["axes/b.toml", "axes/c.toml"]),
        (["axes/[cx].toml", "?.toml"], ["axes/c.toml", "a.toml"]),
        (["axes/**/*.toml"], ["axes/b.toml", "axes/c.toml", "axes/deep/d.toml"]),
        (["a.toml", "a.check.toml"], ["a.toml"]),
        (["axes/b.baseline.json", "axes/b.check.toml", "axes/b.toml"], ["axes/b.toml"]),
        (["a.toml", "./a.toml", "*.toml"], ["a.toml", "odd [1].toml"]),
        (["odd [1].toml"], ["odd [1].toml"]),
        (["absent.toml"], ["absent.toml"]),
        (["axes/notes.md"], ["axes/notes.md"]),
    ],
    ids=range(12),
)
def test_they_are_found(arguments, names):
    assert scenario_files(arguments) == [Path(name) for name in names]


def test_a_path_in_full_is_the_same_file(folder):
    assert scenario_files(["a.toml", str(folder / "a.toml")]) == [Path("a.toml")]


@pytest.mark.parametrize("pattern", ["none/*.toml", "*.tml", "*.check.toml", "axes/*.md"])
def test_a_pattern_without_a_match_is_an_error(pattern):
    with pytest.raises(ValueError, match="matches no scenario file") as refusal:
        scenario_files(["a.toml", pattern])
    assert str(refusal.value).startswith(f"{pattern}: ")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["a.check.toml"], "a.check.toml: is a check file; name its scenario, a.toml"),
        (["axes/c.toml", "axes/b.baseline.json"],
         "axes/b.baseline.json: is a baseline; name its scenario, axes/b.toml"),
    ],
)  # fmt: skip
def test_no_scenario_is_left_out_in_silence(arguments, line):
    with pytest.raises(ValueError, match="name its scenario") as refusal:
        scenario_files(arguments)
    assert str(refusal.value) == line
