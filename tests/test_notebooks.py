"""Every notebook runs, its two forms hold the same cells, and its figures are the known ones."""

import ast
import os
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.py"))


def test_there_are_notebooks_and_every_one_is_paired():
    assert NOTEBOOKS
    assert [path.stem for path in NOTEBOOKS] == sorted(p.stem for p in FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_pair_holds_the_same_cells_and_no_output(path):
    import jupytext  # in the worker that needs it: it takes a second

    script = jupytext.read(path)
    notebook = jupytext.read(path.with_suffix(".ipynb"))
    assert [(c.cell_type, c.source) for c in notebook.cells] == [
        (c.cell_type, c.source) for c in script.cells
    ], f"run: jupytext --to ipynb {path.name}"
    assert not any(c.get("outputs") for c in notebook.cells)


@pytest.fixture(scope="module")
def kernel():
    """Start one kernel, which loads the libraries once; the names of each notebook go."""
    from jupyter_client.manager import KernelManager
    from nbclient import NotebookClient
    from nbformat.v4 import new_notebook

    manager = KernelManager()
    place = {"metadata": {"path": str(FOLDER)}}
    client = NotebookClient(new_notebook(), km=manager, timeout=120, resources=place)
    yield client
    client.kc.stop_channels()
    manager.shutdown_kernel(now=True)
    manager.cleanup_resources()


# What `figures` holds at the end of a notebook, in its order.
FIGURES = {
    "08_telescope_azimuth": (4.37922, 1.49541, 1.629, 45.0, 184.38),
    "09_wafer_stage": (95.31, 83.872, 0.869, 603.2, 6.313e9),
    "10_gantry_crane": (70.61, 15.22, 28.54, 16.90, 2001.7, 30.30),
    "11_any_motion": (12.6003, 15.6923, 2.9000, 2.43198, 10.7634),
    "12_measure_shape_check_ship": (42.935, 17.457, 1.8, 1.298e6, 12.0, 78.0),
}
SLOW = os.environ.get("JOUNCE_TIER") == "slow"
RUN = [path for path in NOTEBOOKS if SLOW or path.stem[:2] == "10"]


@pytest.mark.parametrize("path", RUN, ids=lambda path: path.stem)
def test_it_runs_without_warnings(path, kernel):
    import nbformat
    from nbformat.v4 import new_code_cell

    notebook = nbformat.read(path.with_suffix(".ipynb"), as_version=4)
    notebook.cells.insert(0, new_code_cell("%reset -f"))
    asked = FIGURES.get(path.stem, ())
    if asked:
        notebook.cells.append(new_code_cell("print([float(each) for each in figures.values()])"))
    kernel.nb = notebook
    kernel.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in o.get("data", {}) for o in outputs), "a notebook shows a picture"
    assert not [o.text for o in outputs if o.get("name") == "stderr"]
    assert not [o.text for o in outputs if "HiGHS" in o.get("text", "")], "a library's banner"
    told = ast.literal_eval(notebook.cells[-1].outputs[0].text) if asked else []
    assert told == pytest.approx(asked, rel=1e-3)
