"""The picture of a result of any kind, found by its type."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..analysis.frequency_view import (
    CascadedLags,
    DescribingFunction,
    NullBySize,
    PeriodicResponse,
    ShaperSensitivity,
    VibrationMap,
)
from ..analysis.limit_tuning import TunedLimits
from ..analysis.log_conformance import Conformance
from ..analysis.loop_survey import Survey
from ..analysis.margins import ManyMargins
from ..analysis.measured import MeasuredResponse
from ..analysis.measured_survey import MeasuredSurvey
from ..analysis.sweep_result import SweepResult
from ..fmu.cosimulation.cosimulation_result import CosimulationResult
from ..plant import LoopResponse
from ..shaping import FollowerResponse, Synchronized, Tour, Trajectory
from ..shaping.trajectory import Planned
from .conformance import plot_conformance
from .cosimulation import plot_cosimulation
from .describing_functions import (
    plot_describing_function,
    plot_describing_gain,
    plot_periodic_response,
)
from .frequency_view import (
    plot_cascaded_lags,
    plot_null_by_size,
    plot_shaper_sensitivity,
    plot_vibration_map,
)
from .limit_tuning import plot_tuned_limits
from .loop_response import plot_loop_response
from .margin_contours import plot_margin_contours
from .measured import plot_measured_response, plot_measured_survey
from .motions import plot_following, plot_trajectory
from .paths import plot_synchronized, plot_tour
from .survey import plot_survey
from .sweep import plot_sweep

Picture = Callable[..., Axes | Figure]


@singledispatch
def draw(result: object, ax: Axes | None = None, **options: Any) -> Axes | Figure:
    """Draw a result by the function for its kind, with that function's options.

    Parameters
    ----------
    result : object
        A trajectory, a follower's response, a survey, conformance, margins of many loops, a
        co-simulation, or what shapers are as filters.
    ax : Axes, optional
        To draw in, for pictures of one panel. Default: pyplot's current ones.

    Raises
    ------
    TypeError
        For a result of another kind, and for axes where a picture has several panels.
    """
    raise TypeError(
        f"a {type(result).__name__} has no picture: expected a result such as a Trajectory or a "
        f"Survey; ax = {ax!r} and options {list(options)} are for those"
    )


def _of_panels(plot: Picture) -> Picture:
    def drawn(result: object, ax: Axes | None = None, **options: Any) -> Axes | Figure:
        if ax is not None:
            raise TypeError(
                f"ax = {ax!r}: a {type(result).__name__} is drawn in several panels; leave ax out, "
                f"or give figure=… to jounce.plots.{plot.__name__}"
            )
        return plot(result, **options)

    return drawn


def _in_axes(plot: Picture) -> Picture:
    def drawn(result: object, ax: Axes | None = None, **options: Any) -> Axes | Figure:
        return plot(result, ax=ax, **options)

    return drawn


@draw.register(DescribingFunction)
def _(result: DescribingFunction, ax: Axes | None = None, **options: Any) -> Axes:
    if ax is None:
        return plot_describing_function(result, **options)
    return plot_describing_gain(result, ax=ax, **options)


_PANELS: dict[type, Picture] = {
    Trajectory: plot_trajectory,
    Planned: plot_trajectory,
    Synchronized: plot_synchronized,
    Tour: plot_tour,
    LoopResponse: plot_loop_response,
    Survey: plot_survey,
    Conformance: plot_conformance,
    CascadedLags: plot_cascaded_lags,
    CosimulationResult: plot_cosimulation,
    TunedLimits: plot_tuned_limits,
    MeasuredResponse: plot_measured_response,
    MeasuredSurvey: plot_measured_survey,
    SweepResult: plot_sweep,
}
_SINGLE: dict[type, Picture] = {
    FollowerResponse: plot_following,
    ManyMargins: plot_margin_contours,
    VibrationMap: plot_vibration_map,
    NullBySize: plot_null_by_size,
    ShaperSensitivity: plot_shaper_sensitivity,
    PeriodicResponse: plot_periodic_response,
}
for kind, plot in _PANELS.items():
    draw.register(kind, _of_panels(plot))
for kind, plot in _SINGLE.items():
    draw.register(kind, _in_axes(plot))
