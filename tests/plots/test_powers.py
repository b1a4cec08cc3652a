"""Labels of logarithmic axes say what matplotlib's own do, without its mathematics."""

import pytest
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation

from jounce.plots.powers import PlainPowers, label_powers


@pytest.mark.parametrize(
    ("value", "told"),
    [(1e-3, "10⁻³"), (1.0, "10⁰"), (1e12, "10¹²"), (-10.0, "−10¹"), (0.0, "0"), (0.2, "2×10⁻¹")],
)
def test_powers_and_their_multiples(value, told):
    assert PlainPowers()(value) == told


@pytest.mark.parametrize("ends", [(1e-4, 1e3), (0.2, 3.0)], ids=str)
def test_the_same_ticks_are_labelled_as_by_matplotlib(ends):
    own, plain = Figure().subplots(), Figure().subplots()
    for ax in (own, plain):
        ax.loglog(ends, ends)
    label_powers(plain)
    for minor in (False, True):
        theirs = [bool(each.get_text()) for each in own.get_xticklabels(minor=minor)]
        ours = [each.get_text() for each in plain.get_xticklabels(minor=minor)]
        assert [bool(text) for text in ours] == theirs
        assert not any("$" in text for text in ours)


def test_other_formatters_stay():
    ax = Figure().subplots()
    ax.semilogx([1.0, 10.0], [0.0, 1.0])
    ax.xaxis.set_major_formatter(FuncFormatter(lambda *_: "x"))
    label_powers(ax)
    assert type(ax.xaxis.get_major_formatter()) is FuncFormatter
    assert type(ax.xaxis.get_minor_formatter()) is not LogFormatterSciNotation
