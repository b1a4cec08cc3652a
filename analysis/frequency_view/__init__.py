"""Shapers as filters: frequency response, residual vibration, describing functions."""

from typing import TYPE_CHECKING

from ...later import later

if TYPE_CHECKING:
    from .describing_functions import (
        DescribingFunction,
        PeriodicResponse,
        describing_function,
        periodic_response,
    )
    from .frequency_responses import (
        FrequencyResponse,
        corner_omega,
        fft_frequency_response,
        frequency_response,
        rollover_db_per_decade,
    )
    from .lag_cascade import CascadedLags, cascaded_lags
    from .nearest_lag import FirstOrderLag, first_order_lag, rate_limiter_corner_omega
    from .nulls import NullBySize, null_by_size, null_omegas, null_rise_time
    from .placement import place_null
    from .shaper_sensitivity import ShaperSensitivity, sensitivity_of_shapers
    from .vibration import VibrationMap, residual_vibration, vibration_map

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "CascadedLags": "lag_cascade",
    "DescribingFunction": "describing_functions",
    "FirstOrderLag": "nearest_lag",
    "FrequencyResponse": "frequency_responses",
    "NullBySize": "nulls",
    "PeriodicResponse": "describing_functions",
    "ShaperSensitivity": "shaper_sensitivity",
    "VibrationMap": "vibration",
    "cascaded_lags": "lag_cascade",
    "corner_omega": "frequency_responses",
    "describing_function": "describing_functions",
    "fft_frequency_response": "frequency_responses",
    "first_order_lag": "nearest_lag",
    "frequency_response": "frequency_responses",
    "null_by_size": "nulls",
    "null_omegas": "nulls",
    "null_rise_time": "nulls",
    "periodic_response": "describing_functions",
    "place_null": "placement",
    "rate_limiter_corner_omega": "nearest_lag",
    "residual_vibration": "vibration",
    "rollover_db_per_decade": "frequency_responses",
    "sensitivity_of_shapers": "shaper_sensitivity",
    "vibration_map": "vibration",
}

__all__ = [
    "CascadedLags",
    "DescribingFunction",
    "FirstOrderLag",
    "FrequencyResponse",
    "NullBySize",
    "PeriodicResponse",
    "ShaperSensitivity",
    "VibrationMap",
    "cascaded_lags",
    "corner_omega",
    "describing_function",
    "fft_frequency_response",
    "first_order_lag",
    "frequency_response",
    "null_by_size",
    "null_omegas",
    "null_rise_time",
    "periodic_response",
    "place_null",
    "rate_limiter_corner_omega",
    "residual_vibration",
    "rollover_db_per_decade",
    "sensitivity_of_shapers",
    "vibration_map",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
