"""Shapers as filters: frequency response, residual vibration, describing functions."""

from .frequency import (
    FrequencyResponse,
    corner_omega,
    fft_frequency_response,
    frequency_response,
    null_omegas,
    rollover_db_per_decade,
)

__all__ = [
    "FrequencyResponse",
    "corner_omega",
    "fft_frequency_response",
    "frequency_response",
    "null_omegas",
    "rollover_db_per_decade",
]
