"""Pictures of results: each function takes a result and an Axes, draws, returns the Axes."""

from .conformance import plot_conformance
from .describing import (
    plot_describing_function,
    plot_describing_gain,
    plot_describing_phase,
    plot_periodic_response,
)
from .motions import plot_following, plot_motions, plot_phase_plane, plot_trajectory
from .shapers import (
    plot_cascaded_lags,
    plot_frequency_responses,
    plot_null_by_size,
    plot_vibration_by_size,
    plot_vibration_map,
)
from .survey import plot_survey

__all__ = [
    "plot_cascaded_lags",
    "plot_conformance",
    "plot_describing_function",
    "plot_describing_gain",
    "plot_describing_phase",
    "plot_following",
    "plot_frequency_responses",
    "plot_motions",
    "plot_null_by_size",
    "plot_periodic_response",
    "plot_phase_plane",
    "plot_survey",
    "plot_trajectory",
    "plot_vibration_by_size",
    "plot_vibration_map",
]
