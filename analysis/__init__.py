"""Margins and surveys of servo loops, shapers as filters, conformance: results, no pictures."""

from .frequency_view import (
    CascadedLags,
    DescribingFunction,
    FirstOrderLag,
    FrequencyResponse,
    NullBySize,
    PeriodicResponse,
    ShaperSensitivity,
    VibrationMap,
    cascaded_lags,
    corner_omega,
    describing_function,
    fft_frequency_response,
    first_order_lag,
    frequency_response,
    null_by_size,
    null_omegas,
    null_rise_time,
    periodic_response,
    place_null,
    rate_limiter_corner_omega,
    residual_vibration,
    rollover_db_per_decade,
    sensitivity_of_shapers,
    vibration_map,
)
from .limit_trials import LimitTrial
from .limit_tuning import TunedLimits, tune_limits
from .log_conformance import Conformance, conformance, read_log
from .loop_survey import Survey, UnstableLoopError, survey
from .margins import LoopMargins, ManyMargins, loop_margins, many_loop_margins, servo_margins
from .specification import FIGURES, Labels, Mode, Move, Requirement, Specification, Tracking
from .tuning import TunedPID, tune_pid

__all__ = [
    "FIGURES",
    "CascadedLags",
    "Conformance",
    "DescribingFunction",
    "FirstOrderLag",
    "FrequencyResponse",
    "Labels",
    "LimitTrial",
    "LoopMargins",
    "ManyMargins",
    "Mode",
    "Move",
    "NullBySize",
    "PeriodicResponse",
    "Requirement",
    "ShaperSensitivity",
    "Specification",
    "Survey",
    "Tracking",
    "TunedLimits",
    "TunedPID",
    "UnstableLoopError",
    "VibrationMap",
    "cascaded_lags",
    "conformance",
    "corner_omega",
    "describing_function",
    "fft_frequency_response",
    "first_order_lag",
    "frequency_response",
    "loop_margins",
    "many_loop_margins",
    "null_by_size",
    "null_omegas",
    "null_rise_time",
    "periodic_response",
    "place_null",
    "rate_limiter_corner_omega",
    "read_log",
    "residual_vibration",
    "rollover_db_per_decade",
    "sensitivity_of_shapers",
    "servo_margins",
    "survey",
    "tune_limits",
    "tune_pid",
    "vibration_map",
]


def __dir__() -> list[str]:
    return sorted(__all__)
