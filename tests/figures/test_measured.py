"""The gallery's measured loops: labelled, told, in their size, and what they show is so."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from figures.measured import MEASURED
from PIL import Image

PICTURES = Path(__file__).parents[2] / "docs" / "gallery"


@cache
def figure(name):
    return MEASURED[name]()


@pytest.mark.parametrize("name", MEASURED)
def test_the_gallery_has_every_measured_picture_in_its_size(name):
    path = PICTURES / f"{name}.png"
    assert path.stat().st_size < 80_000
    with Image.open(path) as picture:
        size = tuple(np.rint(100.0 * figure(name).get_size_inches()).astype(int))
        assert picture.size == size, "run: python docs/gallery.py"


@pytest.mark.parametrize("name", MEASURED)
def test_axes_are_labelled(name):
    for ax in figure(name).axes:
        assert ax.get_xlabel()
        assert ax.get_ylabel()


def test_fits_follow_the_mode_and_straight_lines_do_not():
    (ax,) = figure("measured_light_mode").axes
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    assert abs(drawn["rational fits"] - drawn["exact"]).max() < 0.1
    assert drawn["straight lines, log over log"].max() < 0.0 < drawn["exact"].max()
    assert len(drawn["crossovers found"]) == 2
