"""Pictures of results: one function for each, in the Axes given or pyplot's own."""

from typing import TYPE_CHECKING

from ..later import later

if TYPE_CHECKING:
    from .conformance import plot_conformance
    from .cosimulation import plot_cosimulation
    from .describing_functions import (
        plot_describing_function,
        plot_describing_gain,
        plot_describing_phase,
        plot_periodic_response,
    )
    from .dispatch import draw
    from .frequency_view import (
        plot_cascaded_lags,
        plot_frequency_responses,
        plot_null_by_size,
        plot_vibration_by_size,
        plot_vibration_map,
    )
    from .loop_response import plot_loop_response
    from .margin_contours import plot_margin_contours
    from .measured import plot_measured_nyquist, plot_measured_response
    from .motions import plot_following, plot_motions, plot_phase_plane, plot_trajectory
    from .paths import plot_synchronized, plot_tour
    from .survey import plot_survey
    from .survey_details import plot_survey_details
    from .sweep import plot_scatter_matrix, plot_sweep

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "draw": "dispatch",
    "plot_cascaded_lags": "frequency_view",
    "plot_conformance": "conformance",
    "plot_cosimulation": "cosimulation",
    "plot_describing_function": "describing_functions",
    "plot_describing_gain": "describing_functions",
    "plot_describing_phase": "describing_functions",
    "plot_following": "motions",
    "plot_frequency_responses": "frequency_view",
    "plot_loop_response": "loop_response",
    "plot_margin_contours": "margin_contours",
    "plot_measured_nyquist": "measured",
    "plot_measured_response": "measured",
    "plot_motions": "motions",
    "plot_null_by_size": "frequency_view",
    "plot_periodic_response": "describing_functions",
    "plot_phase_plane": "motions",
    "plot_scatter_matrix": "sweep",
    "plot_survey": "survey",
    "plot_survey_details": "survey_details",
    "plot_sweep": "sweep",
    "plot_synchronized": "paths",
    "plot_tour": "paths",
    "plot_trajectory": "motions",
    "plot_vibration_by_size": "frequency_view",
    "plot_vibration_map": "frequency_view",
}

__all__ = [
    "draw",
    "plot_cascaded_lags",
    "plot_conformance",
    "plot_cosimulation",
    "plot_describing_function",
    "plot_describing_gain",
    "plot_describing_phase",
    "plot_following",
    "plot_frequency_responses",
    "plot_loop_response",
    "plot_margin_contours",
    "plot_measured_nyquist",
    "plot_measured_response",
    "plot_motions",
    "plot_null_by_size",
    "plot_periodic_response",
    "plot_phase_plane",
    "plot_scatter_matrix",
    "plot_survey",
    "plot_survey_details",
    "plot_sweep",
    "plot_synchronized",
    "plot_tour",
    "plot_trajectory",
    "plot_vibration_by_size",
    "plot_vibration_map",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
