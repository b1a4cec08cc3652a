"""The paper's figures: all of them labelled, with legends that hide nothing, and in the gallery."""

import importlib.util
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from drawn import curves, words
from figures import paper
from matplotlib.figure import Figure
from PIL import Image

ROOT = Path(__file__).parents[2]
ONE_CURVE_A_PANEL = (1, 3)
ONE_LEGEND_FOR_SEVERAL_PANELS = (4, 6)


@cache
def figure(number: int) -> Figure:
    return paper.FIGURES[number]()


@pytest.fixture(autouse=True)
def _no_pyplot_state():
    yield
    assert plt.get_fignums() == []


@pytest.mark.parametrize("number", paper.FIGURES)
def test_axes_are_labelled_with_units(number):
    drawn = [ax for ax in figure(number).axes if ax.axison]
    for ax in drawn:
        along = [other for other in drawn if ax.get_shared_x_axes().joined(ax, other)]
        beside = [other for other in drawn if ax.get_shared_y_axes().joined(ax, other)]
        assert any("[" in other.get_xlabel() for other in [ax, *along])
        labels = [other.get_ylabel() for other in [ax, *beside]]
        assert any("[" in label or label == "position / step" for label in labels)


@pytest.mark.parametrize("number", paper.FIGURES)
def test_several_curves_have_a_legend_that_hides_none(number):
    figure(number).draw_without_rendering()
    legends = [ax for ax in figure(number).axes if ax.get_legend()]
    assert bool(legends) == (number not in ONE_CURVE_A_PANEL)
    for ax in figure(number).axes:
        if ax not in legends:
            assert len(curves(ax)) <= 1 or number in ONE_LEGEND_FOR_SEVERAL_PANELS
            continue
        assert len(set(words(ax))) == len(words(ax))
        box = ax.get_legend().get_window_extent()
        for curve in curves(ax):
            x, y = ax.transData.transform(np.column_stack(curve)).T
            assert not np.any((box.x0 < x) & (x < box.x1) & (box.y0 < y) & (y < box.y1))


def gallery():
    spec = importlib.util.spec_from_file_location("gallery", ROOT / "docs" / "gallery.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_gallery_page_is_up_to_date():
    module = gallery()
    assert module.PAGE.read_text(encoding="utf-8") == module.page(), "run: python docs/gallery.py"


@pytest.mark.parametrize("number", paper.FIGURES)
def test_the_gallery_has_every_picture_in_its_size(number):
    module = gallery()
    path = module.PICTURES / module.picture_name(number)
    assert path.stat().st_size < 80_000
    with Image.open(path) as picture:
        size = tuple(np.rint(100.0 * figure(number).get_size_inches()).astype(int))
        assert picture.size == size, "run: python docs/gallery.py"


def test_a_picture_is_always_the_same_bytes(tmp_path):
    module = gallery()
    for name in ("one.png", "two.png"):
        module.save(paper.figure_2(), tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
