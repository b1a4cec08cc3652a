"""Result files: complete, the same each time, and written whole or not at all."""

import csv
import json
import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

from jounce.app import survey_file
from jounce.app.result_files import save_figure, write_files, write_rows, write_survey
from jounce.plots import survey as drawn

EXAMPLES = Path(__file__).parents[2] / "examples"
ARCSEC = math.pi / 180 / 3600
FILES = {
    "survey.json",
    "survey.png",
    "step.csv",
    "move_1_60_arcsec_step.csv",
    "move_2_3600_arcsec_step.csv",
}


@pytest.fixture(scope="module")
def written(telescope, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("survey") / "new" / "out"
    files = write_survey(telescope, folder, pdf=True, details=True)
    assert {path.name for path in files} == FILES | {"survey.pdf"}
    assert all(path.parent == folder and path.stat().st_size for path in files)
    return folder


@pytest.fixture
def quick(monkeypatch):
    """Draw nothing and save empty pictures, where the picture is not the point."""
    monkeypatch.setattr(drawn, "plot_survey", lambda _, figure: figure)
    monkeypatch.setattr(Figure, "savefig", lambda *args, **_: Path(args[1]).write_bytes(b"picture"))


def columns(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert len(set(header)) == len(header)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def contents(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is not JSON")


def test_the_folder_holds_the_files_and_nothing_else(written):
    assert {path.name for path in written.iterdir()} == FILES | {"survey.pdf"}


def test_survey_json_is_strict_json(written):
    text = (written / "survey.json").read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=refuse)
    assert text.endswith("}\n")
    assert data["units"]["position"] == "arcsec"
    assert data["margins"]["crossover_hz"] == pytest.approx(1.0)
    assert data["margins"]["upper_gain_margin_db"] is None
    assert [move["name"] for move in data["moves"]] == ["60 arcsec step", "3600 arcsec step"]


def test_step_csv_agrees_with_survey_json(written):
    data = json.loads((written / "survey.json").read_text(encoding="utf-8"))["step"]
    table = columns(written / "step.csv")
    time, position = table["time_s"], table["position"]
    assert position[0] == 0.0
    assert position[-1] == pytest.approx(1.0, abs=1e-4)
    assert 100 * (position.max() - 1) == pytest.approx(data["overshoot_percent"], abs=1e-3)
    assert time[position.argmax()] == pytest.approx(data["peak_time_s"], abs=2 * time[1])
    last = time[np.flatnonzero(np.abs(position - 1) > 0.02)[-1]]
    assert last == pytest.approx(data["settling_time_s"], abs=2 * time[1])


def test_move_csvs_agree_with_survey_json(written, telescope):
    moves = json.loads((written / "survey.json").read_text(encoding="utf-8"))["moves"]
    labels = ("without_feedforward", "with_feedforward", "j_hat_plus_10_percent",
              "j_hat_minus_10_percent")  # fmt: skip
    for i, move in enumerate(moves):
        (path,) = written.glob(f"move_{i + 1}_*.csv")
        table = columns(path)
        time = table["time_s"]
        assert np.all(np.diff(time) > 0)
        ramp = np.minimum(time, move["duration_s"])
        half = move["duration_s"] / 2
        exact = np.where(
            ramp <= half, 360 * ramp**2, move["distance"] - 360 * (move["duration_s"] - ramp) ** 2
        )
        np.testing.assert_allclose(table["shaped_command_arcsec"], exact, atol=1e-9)
        for label, entry in zip(labels, move["responses"], strict=True):
            position, error = table[f"position_{label}_arcsec"], table[f"error_{label}_arcsec"]
            torque = table[f"torque_{label}"]
            np.testing.assert_allclose(table["command_arcsec"] - position, error, atol=1e-9)
            # the figures are of all samples, of which the file has up to 4000
            assert np.abs(error).max() == pytest.approx(entry["peak_error"], rel=1e-4, abs=1e-9)
            assert np.abs(torque).max() == pytest.approx(entry["peak_torque"], rel=1e-4)
            assert np.abs(error).max() <= entry["peak_error"]
            outside = np.abs(position - move["distance"]) > move["settle_to"]
            k = int(np.flatnonzero(outside)[-1])
            assert time[k] <= entry["settling_time_s"] <= time[k + 1]
        response = telescope.moves[i].configured.response
        assert 2000 <= len(time) <= 4000
        assert np.isin(time, response.time).all()


def test_the_same_input_gives_the_same_files(written, tmp_path):
    write_survey(survey_file(EXAMPLES / "telescope.toml"), tmp_path, pdf=True)
    assert contents(tmp_path) == contents(written)


def test_pictures_are_pictures(written):
    assert (written / "survey.png").read_bytes().startswith(b"\x89PNG\r\n")
    assert (written / "survey.pdf").read_bytes().startswith(b"%PDF-")
    assert b"CreationDate" not in (written / "survey.pdf").read_bytes()


@pytest.mark.parametrize("suffix", [".png", ".pdf", ".PDF", ".svg"])
def test_a_saved_figure_is_the_same_each_time(tmp_path, suffix, monkeypatch):
    saved = []
    for epoch in (10**9, 10**9 + 5):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", str(epoch))
        figure = Figure()
        figure.subplots().plot([0.0, 1.0], [0.0, 1.0])
        save_figure(figure, tmp_path / f"picture{suffix}")
        saved.append((tmp_path / f"picture{suffix}").read_bytes())
    assert saved[0] == saved[1]


@pytest.mark.usefixtures("quick")
def test_other_files_are_left_alone(telescope, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "sub").mkdir()
    (tmp_path / "survey.json").write_text("old")
    write_survey(telescope, tmp_path)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == FILES | {"notes.txt", "sub"}
    json.loads((tmp_path / "survey.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("broken", ["survey.png", "survey.pdf"])
def test_nothing_changes_when_a_picture_fails(telescope, tmp_path, monkeypatch, broken):
    def fail(*args, **_):
        if Path(args[1]).name == broken:
            raise OSError(28, "No space left on device", str(args[1]))
        Path(args[1]).write_bytes(b"picture")

    monkeypatch.setattr(Figure, "savefig", fail)
    (tmp_path / "survey.json").write_text("old")
    before = contents(tmp_path)
    with pytest.raises(OSError, match="No space"):
        write_survey(telescope, tmp_path, pdf=True)
    assert contents(tmp_path) == before
    assert plt.get_fignums() == []


def test_a_new_folder_goes_again_when_writing_fails(telescope, tmp_path, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda *_, **__: (_ for _ in ()).throw(OSError("full")))
    with pytest.raises(OSError, match="full"):
        write_survey(telescope, tmp_path / "out")
    assert contents(tmp_path) == {}


def test_new_parent_folders_go_again_when_writing_fails(telescope, tmp_path, monkeypatch):
    monkeypatch.setattr(Figure, "savefig", lambda *_, **__: (_ for _ in ()).throw(OSError("full")))
    with pytest.raises(OSError, match="full"):
        write_survey(telescope, tmp_path / "some" / "where" / "out")
    assert contents(tmp_path) == {}


@pytest.mark.usefixtures("quick")
def test_nothing_changes_when_a_file_cannot_be_replaced(telescope, tmp_path):
    (tmp_path / "survey.png").mkdir()
    (tmp_path / "survey.json").write_text("old")
    before = contents(tmp_path)
    with pytest.raises(OSError, match=r"survey\.png"):
        write_survey(telescope, tmp_path)
    assert contents(tmp_path) == before


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("folder", ["taken", "taken/out"])
def test_a_file_in_the_place_of_the_folder(telescope, tmp_path, folder):
    (tmp_path / "taken").write_text("mine")
    with pytest.raises(OSError, match="taken"):
        write_survey(telescope, tmp_path / folder)
    assert contents(tmp_path) == {"taken": b"mine"}


@pytest.mark.usefixtures("quick")
def test_names_of_moves_become_names_of_files(tmp_path):
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    text = text.replace("3600 arcsec step", "../Größe: 50 % / zurück?")
    text = text.replace('"60 arcsec step"', '"+-*"')
    scenario = tmp_path / "case.toml"
    scenario.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    names = {path.name for path in write_survey(survey_file(scenario), out)}
    assert names == {path.name for path in out.iterdir()}
    moves = sorted(name for name in names if name.startswith("move_"))
    assert len(moves) == 2
    assert not any(set(name) & set('/\\:*?"<>|% ') for name in moves)


@pytest.mark.usefixtures("quick")
def test_a_long_name_of_a_move_does_not_stop_the_survey(tmp_path):
    text = (EXAMPLES / "telescope.toml").read_text(encoding="utf-8")
    scenario = tmp_path / "case.toml"
    scenario.write_text(text.replace("3600 arcsec step", "long " * 60), encoding="utf-8")
    assert len(write_survey(survey_file(scenario), tmp_path / "out")) == len(FILES)


def test_rows_keep_every_digit(tmp_path):
    values = [[1 / 3, 1e-300, -0.1], [math.pi, 2.0**60, 5e-324]]
    write_rows(tmp_path / "rows.csv", ["a, b", "c", "d"], values)
    with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == ["a, b", "c", "d"]
    assert [[float(x) for x in row] for row in rows] == values


def test_a_file_is_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "result.csv"
    path.write_text("old")

    def fail(draft: Path) -> None:
        draft.write_text("half")
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        write_files({path: fail})
    assert contents(tmp_path) == {"result.csv": b"old"}
    write_files({path: lambda draft: draft.write_text("new") and None})
    assert contents(tmp_path) == {"result.csv": b"new"}


@pytest.mark.parametrize("name", ["nowhere/result.csv", "folder", "taken/result.csv"])
def test_an_unwritable_place_is_named(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "taken").write_text("mine")
    before = contents(tmp_path)
    with pytest.raises(OSError, match=r"\S") as refusal:
        write_files({tmp_path / name: lambda draft: draft.write_text("new") and None})
    assert contents(tmp_path) == before
    named = {str(refusal.value.filename), str(refusal.value.filename2)}
    assert named & {str(tmp_path / name), str((tmp_path / name).parent)}
