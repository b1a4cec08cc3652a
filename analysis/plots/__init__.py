"""Pictures of results: each function takes a result and an Axes, draws, returns the Axes."""

from .motions import plot_following, plot_motions, plot_phase_plane, plot_trajectory
from .survey import plot_survey

__all__ = [
    "plot_following",
    "plot_motions",
    "plot_phase_plane",
    "plot_survey",
    "plot_trajectory",
]
