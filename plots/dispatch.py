"""The picture of a result of any kind, found by its type."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# By the names of kinds, so that a picture imports no more than its own module.
_PANELS = {
    "Trajectory": "motions.plot_trajectory",
    "Planned": "motions.plot_trajectory",
    "Synchronized": "paths.plot_synchronized",
    "Tour": "paths.plot_tour",
    "LoopResponse": "loop_response.plot_loop_response",
    "Survey": "survey.plot_survey",
    "Conformance": "conformance.plot_conformance",
    "CascadedLags": "frequency_view.plot_cascaded_lags",
    "CosimulationResult": "cosimulation.plot_cosimulation",
    "TunedLimits": "limit_tuning.plot_tuned_limits",
    "MeasuredResponse": "measured.plot_measured_response",
    "MeasuredSurvey": "measured.plot_measured_survey",
    "SweepResult": "sweep.plot_sweep",
    "DescribingFunction": "describing_functions.plot_describing_function",
}
_SINGLE = {
    "FollowerResponse": "motions.plot_following",
    "ManyMargins": "margin_contours.plot_margin_contours",
    "VibrationMap": "frequency_view.plot_vibration_map",
    "NullBySize": "frequency_view.plot_null_by_size",
    "ShaperSensitivity": "frequency_view.plot_shaper_sensitivity",
    "PeriodicResponse": "describing_functions.plot_periodic_response",
    "DescribingFunction": "describing_functions.plot_describing_gain",
}


def draw(result: object, ax: Axes | None = None, **options: Any) -> Axes | Figure:
    """Draw a result by the function for its kind, with that function's options.

    Parameters
    ----------
    result : object
        A trajectory, a follower's response, a survey, conformance, margins of many loops, a
        co-simulation, or what shapers are as filters.
    ax : Axes, optional
        To draw in, for pictures of one panel. Default: pyplot's current ones.
    **options
        As `plot_trajectory`, `plot_survey` and the others have them.

    Returns
    -------
    Axes or Figure
        A Figure where the picture has several panels.

    Raises
    ------
    TypeError
        For a result of another kind, and for axes where a picture has several panels.
    """
    kind = _kind_of(result)
    if kind in _SINGLE and (ax is not None or kind not in _PANELS):
        alone: Axes = _picture(_SINGLE[kind])(result, ax=ax, **options)
        return alone
    if kind in _PANELS and ax is None:
        several: Axes | Figure = _picture(_PANELS[kind])(result, **options)
        return several
    if kind in _PANELS:
        raise TypeError(
            f"ax = {ax!r}: a {type(result).__name__} is drawn in several panels; leave ax out, "
            f"or give figure=… to jounce.plots.{_PANELS[kind].partition('.')[2]}"
        )
    raise TypeError(
        f"a {type(result).__name__} has no picture: expected a result such as a Trajectory or a "
        f"Survey; ax = {ax!r} and options {list(options)} are for those"
    )


def _kind_of(result: object) -> str:
    """Return the name of the first of its types that has a picture; empty for none."""
    ours = (kind for kind in type(result).__mro__ if kind.__module__.startswith("jounce."))
    return next((kind.__name__ for kind in ours if kind.__name__ in _PANELS | _SINGLE), "")


def _picture(place: str) -> Any:
    module, _, name = place.partition(".")
    return getattr(import_module(f".{module}", __package__), name)
