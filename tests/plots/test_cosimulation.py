"""Pictures of co-simulations show the signals that they are asked for."""

import control
import numpy as np
import pytest

from jounce.fmu.cosimulation.cosimulate import cosimulate
from jounce.plots.cosimulation import plot_cosimulation

LAG = control.tf([1], [1, 1], inputs="u", outputs="y")
RUN = cosimulate({"a": LAG, "b": LAG}, [(1.0, "a.u"), ("a.y", "b.u")], dt=0.1, duration=2.0)


def curves(figure):
    return [[line.get_label() for line in ax.get_lines()] for ax in figure.axes]


def test_every_output_by_default():
    figure = plot_cosimulation(RUN)
    assert curves(figure) == [["a.y"], ["b.y"]]
    line = figure.axes[1].get_lines()[0]
    np.testing.assert_array_equal(line.get_ydata(), RUN["b.y"])
    assert figure.axes[-1].get_xlabel() == "time [s]"
    assert figure.get_suptitle() == "co-simulation, a, then b (Gauss–Seidel)"
    figure.savefig("/dev/null", format="png")


def test_groups_and_held_inputs():
    figure = plot_cosimulation(RUN, [["a.y", "b.y"], "b.u"], time_unit="ms")
    assert curves(figure) == [["a.y", "b.y"], ["b.u"]]
    assert figure.axes[1].get_lines()[0].get_drawstyle() == "steps-post"
    assert figure.axes[0].get_lines()[0].get_drawstyle() == "default"
    assert figure.axes[-1].get_xlabel() == "time [ms]"


def test_what_is_refused():
    with pytest.raises(ValueError, match=r"no signal 'a\.x'"):
        plot_cosimulation(RUN, ["a.x"])
    with pytest.raises(ValueError, match="0 panels: expected 1 to 40"):
        plot_cosimulation(RUN, [])
