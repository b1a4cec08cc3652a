"""Shapers as filters: frequency response, residual vibration, describing functions."""

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
