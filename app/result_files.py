"""Result files of a survey and of a move: written whole, or not at all."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from errno import EISDIR, ENOTDIR
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.sampling import thinned
from .measured_report import measured_data
from .scenario_measured import MeasuredScenarioSurvey
from .survey_data import survey_data

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..analysis.loop_survey import MoveSurvey
    from ..plant import LoopResponse
    from .scenario_survey import ScenarioSurvey

PICTURES: dict[str, dict[str, None]] = {
    ".png": {},
    ".pdf": {"CreationDate": None},
    ".svg": {"Date": None},
}
"""Kinds of picture by suffix, each with what keeps the date out of it."""

_DPI = 100
_CSV_ROWS = 4_000
_LONGEST_NAME = 40


def write_survey(
    survey: ScenarioSurvey | MeasuredScenarioSurvey,
    folder: Path,
    *,
    details: bool = False,
    pdf: bool = False,
) -> list[Path]:
    """Write survey.json, CSV responses and the picture of a survey into a folder.

    Parameters
    ----------
    survey : ScenarioSurvey
    folder : Path
        Made if it is not there; files of the same names are replaced, others left alone.
    details : bool, optional
        Whether a loop that is not ideal gets a second page, details.png.
    pdf : bool, optional
        Whether the pictures are written as PDF, too.

    Returns
    -------
    list of Path
        The files: survey.json, survey.png, step.csv, one move_*.csv per move (each with at most
        4000 of the samples that the figures in survey.json are taken from), and of what was asked
        for disturbance.csv, one tracking_*.csv per command, details.png and PDFs. Responses have
        a column of the motor's current, behind the current loop, where the torque constant is
        known. Of a measured loop survey.json and its picture.

    Raises
    ------
    OSError
        Where the folder cannot be written. No file of it has changed then.
    """
    from matplotlib.figure import Figure

    from ..plots.survey import plot_survey

    if isinstance(survey, MeasuredScenarioSurvey):
        return _write_measured(survey, folder, pdf=pdf)
    with _all_or_nothing(folder) as draft:
        _write_json(data_of(survey), draft / "survey.json")
        step = survey.step
        _write_csv(draft / "step.csv", ["time_s", "position"], [step.time, step.position])
        for i, move in enumerate(survey.moves, start=1):
            _write_move(survey, move, draft / f"move_{i}_{slug(move.name)}.csv")
        _write_others(survey, draft)
        pages = {"survey": plot_survey(survey, figure=Figure())}  # without pyplot and a display
        if details and not survey.is_ideal:
            from ..plots.survey_details import plot_survey_details

            pages["details"] = plot_survey_details(survey, figure=Figure())
        names = _write_pages(pages, draft, pdf=pdf)
    return [folder / name for name in names]


def data_of(survey: ScenarioSurvey | MeasuredScenarioSurvey) -> dict[str, Any]:
    """Return every number of a survey, of a model or of a measurement, as plain data."""
    if isinstance(survey, MeasuredScenarioSurvey):
        return measured_data(survey)
    return survey_data(survey)


def _write_measured(survey: MeasuredScenarioSurvey, folder: Path, *, pdf: bool) -> list[Path]:
    from matplotlib.figure import Figure

    from ..plots.measured import plot_measured_survey

    with _all_or_nothing(folder) as draft:
        _write_json(data_of(survey), draft / "survey.json")
        pages = {"survey": plot_measured_survey(survey, figure=Figure())}
        names = _write_pages(pages, draft, pdf=pdf)
    return [folder / name for name in names]


def _write_json(data: Mapping[str, object], path: Path) -> None:
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _write_pages(pages: Mapping[str, Figure], draft: Path, *, pdf: bool) -> list[str]:
    """Save figures as PNG, and as PDF; return the names of all files that are there."""
    for name, figure in pages.items():
        for suffix in (".png", ".pdf")[: 1 + pdf]:
            save_figure(figure, draft / f"{name}{suffix}")
    return sorted(path.name for path in draft.iterdir())


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    """Write one CSV file, floats in full precision."""
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerow(header)
        file.writelines(",".join(map(repr, map(float, row))) + "\r\n" for row in rows)


def save_figure(figure: Figure, path: Path) -> None:
    """Save a figure as PICTURES says, without the date: the same input gives the same file.

    Its panels are laid out here, once: matplotlib would do it twice for each file.
    """
    from matplotlib import rc_context

    undated, engine = PICTURES[path.suffix.lower()], figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    with rc_context({"svg.hashsalt": "jounce"}):
        figure.savefig(path, dpi=_DPI, metadata=undated)


def check_picture(path: Path) -> None:
    """Refuse a file name whose suffix is not one of PICTURES."""
    if path.suffix.lower() not in PICTURES:
        raise ValueError(f"{path}: expected a file name that ends in {', '.join(PICTURES)}")


def write_files(writers: Mapping[Path, Callable[[Path], object]]) -> None:
    """Write several files, or none.

    Parameters
    ----------
    writers : mapping of Path to callable
        What writes each file, given the path of a draft beside it.

    Raises
    ------
    OSError
        Where a file cannot be written, naming it. No file has changed then.
    ValueError
        Where a path is a link or a device.
    """
    drafts: dict[Path, Path] = {}
    try:
        for path, write in writers.items():
            drafts[path] = _draft(path)
            try:
                write(drafts[path])
            except OSError as error:
                raise type(error)(error.errno, error.strerror, str(path)) from None
        for path, draft in drafts.items():
            draft.replace(path)
    finally:
        for draft in drafts.values():
            draft.unlink(missing_ok=True)


def _draft(path: Path) -> Path:
    """Return a new, empty file beside a path that can be replaced."""
    _refuse_other_than_files(path)
    try:
        descriptor, name = tempfile.mkstemp(prefix=".draft-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    os.close(descriptor)
    draft = Path(name)
    draft.chmod(0o644)
    return draft


def _refuse_other_than_files(path: Path) -> None:
    """Refuse what a file must not take the place of: a folder, a link, a device."""
    if path.is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(path))
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise ValueError(f"{path}: is a link or a device; name a file to be written")


@contextmanager
def _all_or_nothing(folder: Path) -> Iterator[Path]:
    """Yield an empty draft folder whose files move into `folder` once all are written."""
    made = [p for p in (folder, *folder.parents) if not p.exists()]
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=".draft-", dir=folder))
    try:
        yield draft
        files = sorted(draft.iterdir())
        for path in files:
            _refuse_other_than_files(folder / path.name)
        for path in files:
            path.replace(folder / path.name)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
        for parent in made:
            if not any(parent.iterdir()):
                parent.rmdir()


def _write_move(survey: ScenarioSurvey, move: MoveSurvey, path: Path) -> None:
    scale = survey.scenario.position_scale
    unit = re.sub(r"\W+", "_", survey.scenario.position_unit)
    any_response = move.configured.response
    columns = {
        "time_s": any_response.time,
        f"shaped_command_{unit}": move.trajectory(any_response.time) / scale,
        f"command_{unit}": any_response.command / scale,
    }
    for name, result in move.responses.items():
        label = slug(name)
        columns[f"position_{label}_{unit}"] = result.response.position / scale
        columns[f"error_{label}_{unit}"] = result.response.error / scale
        columns[f"torque_{label}"] = result.response.torque
        if survey.loop.axis.torque_constant is not None:
            columns[f"current_{label}_A"] = result.response.current
        if not survey.is_ideal:
            columns[f"load_{label}_{unit}"] = result.response.load / scale
    _write_csv(path, list(columns), list(columns.values()))


def _write_others(survey: ScenarioSurvey, draft: Path) -> None:
    """Write the responses to the torque step and to tracking commands."""
    if survey.disturbance is not None:
        _write_response(survey, survey.disturbance.response, draft / "disturbance.csv")
    for i, each in enumerate(survey.tracking, start=1):
        _write_response(survey, each.response, draft / f"tracking_{i}_{slug(each.name)}.csv")


def _write_response(survey: ScenarioSurvey, response: LoopResponse, path: Path) -> None:
    scale = survey.scenario.position_scale
    unit = re.sub(r"\W+", "_", survey.scenario.position_unit)
    columns = {
        "time_s": response.time,
        f"command_{unit}": response.command / scale,
        f"position_{unit}": response.position / scale,
        f"error_{unit}": response.error / scale,
        f"load_{unit}": response.load / scale,
        f"load_error_{unit}": response.load_error / scale,
        "torque": response.torque,
    }
    if survey.loop.axis.torque_constant is not None:
        columns["current_A"] = response.current
    _write_csv(path, list(columns), list(columns.values()))


def _write_csv(path: Path, header: Sequence[str], columns: Sequence[np.ndarray]) -> None:
    write_rows(path, header, np.column_stack(thinned(tuple(columns), _CSV_ROWS)).tolist())


def slug(name: str) -> str:
    """Return a name fit for a file or a column: lower case, words joined by underscores."""
    words = name.replace("Ĵ", "j_hat").replace("+", "plus ").replace("-", "minus ")
    joined = re.sub(r"\W+", "_", words.replace("%", "percent").lower())
    return joined[:_LONGEST_NAME].strip("_") or "unnamed"
