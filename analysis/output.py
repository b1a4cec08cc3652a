"""Result files of a survey and of a move: written whole, or not at all."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .report import survey_data

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .survey import MoveSurvey, Survey

_DPI = 100


def write_survey(survey: Survey, folder: Path) -> list[Path]:
    """Write survey.json, CSV responses and the picture of a survey into a folder.

    Parameters
    ----------
    survey : Survey
    folder : Path
        Made if it is not there; files of the same names are replaced, others left alone.

    Returns
    -------
    list of Path
        The files: survey.json, survey.png, survey.pdf, step.csv, one move_*.csv per move.

    Raises
    ------
    OSError
        Where the folder cannot be written. No file of it has changed then.
    """
    with _all_or_nothing(folder) as draft:
        text = json.dumps(survey_data(survey), indent=2, ensure_ascii=False, allow_nan=False)
        (draft / "survey.json").write_text(text + "\n", encoding="utf-8")
        step = survey.step
        _write_csv(draft / "step.csv", ["time_s", "position"], [step.time, step.position])
        for i, move in enumerate(survey.moves, start=1):
            _write_move(survey, move, draft / f"move_{i}_{_slug(move.name)}.csv")
        figure = survey.plot()
        save_figure(figure, draft / "survey.png")
        save_figure(figure, draft / "survey.pdf")
        names = sorted(path.name for path in draft.iterdir())
    return [folder / name for name in names]


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    """Write one CSV file, floats in full precision."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([repr(float(value)) for value in row] for row in rows)


def save_figure(figure: Figure, path: Path) -> None:
    """Save a figure without the date, so that the same input gives the same file."""
    metadata = {"CreationDate": None} if path.suffix == ".pdf" else None
    figure.savefig(path, dpi=_DPI, metadata=metadata)


def write_file(path: Path, write: Callable[[Path], None]) -> None:
    """Call write(draft) with a draft beside `path`, then move it into place."""
    descriptor, name = tempfile.mkstemp(prefix=".draft-", suffix=path.suffix, dir=path.parent)
    os.close(descriptor)
    draft = Path(name)
    try:
        write(draft)
        draft.chmod(0o644)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


@contextmanager
def _all_or_nothing(folder: Path) -> Iterator[Path]:
    """Yield an empty draft folder whose files move into `folder` once all are written."""
    made = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=".draft-", dir=folder))
    try:
        yield draft
        for path in sorted(draft.iterdir()):
            path.replace(folder / path.name)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
        if made and not any(folder.iterdir()):
            folder.rmdir()


def _write_move(survey: Survey, move: MoveSurvey, path: Path) -> None:
    scale = survey.scenario.position_scale
    unit = re.sub(r"\W+", "_", survey.scenario.position_unit)
    any_response = move.configured.response
    columns = {
        "time_s": any_response.time,
        f"shaped_command_{unit}": move.trajectory(any_response.time) / scale,
        f"command_{unit}": any_response.command / scale,
    }
    for name, result in move.responses.items():
        label = _slug(name)
        columns[f"position_{label}_{unit}"] = result.response.position / scale
        columns[f"error_{label}_{unit}"] = result.response.error / scale
        columns[f"torque_{label}"] = result.response.torque
    _write_csv(path, list(columns), list(columns.values()))


def _write_csv(path: Path, header: Sequence[str], columns: Sequence[np.ndarray]) -> None:
    write_rows(path, header, np.column_stack(columns).tolist())


def _slug(name: str) -> str:
    """Return a name fit for a file or a column: lower case, words joined by underscores."""
    words = name.replace("Ĵ", "j_hat").replace("+", "plus ").replace("-", "minus ")
    return re.sub(r"\W+", "_", words.replace("%", "percent").lower()).strip("_") or "unnamed"
