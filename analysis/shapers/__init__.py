"""Shapers as filters: frequency response, residual vibration, describing functions."""

from .cascaded_lags import CascadedLags, cascaded_lags
from .frequency import (
    FrequencyResponse,
    corner_omega,
    fft_frequency_response,
    frequency_response,
    rollover_db_per_decade,
)
from .nulls import NullBySize, null_by_size, null_omegas, null_rise_time
from .placement import place_null
from .vibration import VibrationMap, residual_vibration, vibration_map

__all__ = [
    "CascadedLags",
    "FrequencyResponse",
    "NullBySize",
    "VibrationMap",
    "cascaded_lags",
    "corner_omega",
    "fft_frequency_response",
    "frequency_response",
    "null_by_size",
    "null_omegas",
    "null_rise_time",
    "place_null",
    "residual_vibration",
    "rollover_db_per_decade",
    "vibration_map",
]
