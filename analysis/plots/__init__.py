"""Pictures of results: each function takes a result, draws in the Axes given or pyplot's own."""

from .conformance import plot_conformance
from .cosimulation import plot_cosimulation
from .describing import (
    plot_describing_function,
    plot_describing_gain,
    plot_describing_phase,
    plot_periodic_response,
)
from .margins import plot_margin_contours
from .motions import plot_following, plot_motions, plot_phase_plane, plot_trajectory
from .paper import (
    FIGURES,
    figure_1,
    figure_2,
    figure_3,
    figure_4,
    figure_6,
    figure_7,
    figure_8,
    figure_10,
)
from .shapers import (
    plot_cascaded_lags,
    plot_frequency_responses,
    plot_null_by_size,
    plot_vibration_by_size,
    plot_vibration_map,
)
from .survey import plot_survey

__all__ = [
    "FIGURES",
    "figure_1",
    "figure_2",
    "figure_3",
    "figure_4",
    "figure_6",
    "figure_7",
    "figure_8",
    "figure_10",
    "plot_cascaded_lags",
    "plot_conformance",
    "plot_cosimulation",
    "plot_describing_function",
    "plot_describing_gain",
    "plot_describing_phase",
    "plot_following",
    "plot_frequency_responses",
    "plot_margin_contours",
    "plot_motions",
    "plot_null_by_size",
    "plot_periodic_response",
    "plot_phase_plane",
    "plot_survey",
    "plot_trajectory",
    "plot_vibration_by_size",
    "plot_vibration_map",
]
