"""Contours of margins: at the values that they are labelled with, unstable loops hatched."""

import dataclasses
import math

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure

from jounce.analysis.margins.many_margins import ManyMargins, many_loop_margins, servo_margins
from jounce.plant import design_pid
from jounce.plots.margin_contours import TITLES, plot_margin_contours

GAINS = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
INERTIA, DELAY = np.linspace(0.3, 4.0, 60), np.linspace(0.0, 0.11, 50)


@pytest.fixture
def ax() -> Axes:
    return Figure().subplots()


@pytest.fixture(scope="module")
def margins() -> ManyMargins:
    return servo_margins(INERTIA, GAINS, delay=DELAY[:, None])


def render(figure: Figure) -> None:
    FigureCanvasAgg(figure).draw()


def lines(ax: Axes) -> ContourSet:
    """Return the contours drawn as lines."""
    [found] = [c for c in ax.collections if isinstance(c, ContourSet) and not c.filled]
    return found


def legend(ax: Axes) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_every_margin_has_a_title():
    names = [field.name for field in dataclasses.fields(ManyMargins)]
    assert ["stable", *TITLES] == names
    for name, title in TITLES.items():
        unit = {"hz": "[Hz]", "deg": "[deg]", "db": "[dB]", "s": "[s]"}.get(name.rsplit("_")[-1])
        assert unit is None or title.endswith(unit)


@pytest.mark.parametrize("name", TITLES)
def test_each_margin_is_drawn_and_labelled(margins, ax, name):
    drawn = plot_margin_contours(
        margins, INERTIA, DELAY, margin=name, ax=ax, xlabel="inertia [kg m²]", ylabel="delay [s]"
    )
    assert drawn is ax
    assert ax.get_title() == TITLES[name]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("inertia [kg m²]", "delay [s]")
    assert "unstable" in legend(ax)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.3, 4.0), (0.0, 0.11))
    assert len(lines(ax).labelTexts) >= 1
    render(ax.figure)


def test_contours_run_where_the_margin_has_their_value(margins, ax):
    levels = [10.0, 30.0, 50.0]
    plot_margin_contours(margins, INERTIA, DELAY, ax=ax, levels=levels)
    contours = lines(ax)
    assert contours.levels.tolist() == levels
    for level, path in zip(levels, contours.get_paths(), strict=True):
        inertia, delay = path.vertices.T
        found = servo_margins(inertia, GAINS, delay=delay)
        assert found.stable.all()
        np.testing.assert_allclose(found.phase_margin_deg, level, atol=1.0)


def test_levels_beyond_the_values_are_left_out(margins, ax):
    plot_margin_contours(margins, INERTIA, DELAY, ax=ax, levels=[-5.0, 20.0, 1e3, 20.0])
    assert lines(ax).levels.tolist() == [20.0]


def test_unstable_loops_are_hatched_and_stable_ones_are_not(margins, ax):
    plot_margin_contours(margins, INERTIA, DELAY, ax=ax)
    [background] = [patch for patch in ax.patches if patch.get_hatch()]
    assert background.get_zorder() < min(c.get_zorder() for c in ax.collections)
    filled = next(c for c in ax.collections if isinstance(c, ContourSet) and c.filled)
    [region] = [path for path in filled.get_paths() if len(path.vertices)]
    inner = np.array([(i, k) for i in range(5, 45, 5) for k in range(5, 55, 5)])
    for i, k in inner:
        around = margins.stable[i - 1 : i + 2, k - 1 : k + 2]
        if around.all() or not around.any():
            inside = region.contains_point((INERTIA[k], DELAY[i]))
            assert inside == bool(around.all())


def test_where_nothing_limits_the_margin(ax):
    delay = np.linspace(0.0, 0.05, 20)
    found = servo_margins(INERTIA[:20], GAINS, delay=delay[:, None])
    plot_margin_contours(found, INERTIA[:20], delay, margin="upper_gain_margin_db", ax=ax)
    assert legend(ax) == ["no limit"]
    render(ax.figure)


@pytest.mark.parametrize(
    ("numerator", "entries"),
    [(1.0, None), (-2.0, ["unstable"]), (0.0, ["no limit"])],
    ids=["one value", "all unstable", "no limit"],
)
def test_planes_without_contours(ax, numerator, entries):
    found = many_loop_margins(np.full((3, 4, 1), numerator), [1.0, 1.0, 1e-3])
    plot_margin_contours(found, np.arange(4.0), np.arange(3.0), ax=ax)
    assert not [c for c in ax.collections if isinstance(c, ContourSet) and not c.filled]
    assert (legend(ax) if ax.get_legend() else None) == entries
    render(ax.figure)


def test_logarithmic_axes_and_descending_values(margins, ax):
    ax.set_xscale("log")
    plot_margin_contours(margins[::-1, ::-1], INERTIA[::-1], DELAY[::-1], ax=ax)
    assert ax.get_xscale() == "log"
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.3, 4.0), (0.0, 0.11))
    render(ax.figure)


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_tiny_and_huge_units(factor, ax):
    gains = design_pid(1.0, crossover_hz=factor, phase_margin_deg=45, lower_gain_margin_db=12)
    found = servo_margins(INERTIA, gains, delay=DELAY[:, None] / factor)
    plot_margin_contours(found, INERTIA, DELAY / factor, margin="delay_margin_s", ax=ax)
    assert len(lines(ax).levels) >= 4
    render(ax.figure)


def test_the_result_draws_itself(margins, ax):
    drawn = margins.plot(INERTIA, DELAY, margin="modulus_margin", levels=[0.5], ylabel="delay [s]")
    assert isinstance(drawn.figure, Figure)
    assert drawn.get_title() == TITLES["modulus_margin"]
    assert drawn.get_ylabel() == "delay [s]"
    assert lines(drawn).levels.tolist() == [0.5]
    assert margins.plot(INERTIA, DELAY, ax=ax) is ax
    render(drawn.figure)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"margin": "phase"}, "margin = 'phase': expected one of crossover_hz, phase_margin_deg"),
        ({"margin": "stable"}, "margin = 'stable': expected one of"),
        (
            {"x": DELAY},
            r"x of shape \(50,\) does not fit: expected \(60,\), a value for each column",
        ),
        (
            {"y": INERTIA},
            r"y of shape \(60,\) does not fit: expected \(50,\), a value for each row",
        ),
        ({"x": np.zeros(60)}, "x: expected two values or more, ascending or descending"),
        ({"y": np.full(50, math.nan)}, "y must be finite"),
    ],
    ids=["name", "stable", "x", "y", "constant", "nan"],
)
def test_what_does_not_fit_is_refused(margins, change, message):
    arguments = {"x": INERTIA, "y": DELAY} | change
    with pytest.raises(ValueError, match=message):
        margins.plot(**arguments)


def test_only_a_plane_of_loops_can_be_drawn(margins):
    with pytest.raises(ValueError, match=r"margins of shape \(60,\) are not a plane"):
        margins[0].plot(INERTIA, DELAY)
