"""Margins and surveys of servo loops, scenario files, tables, pictures and the command line."""

from .gate import CheckError, GateReport, check_scenario
from .margins import LoopMargins, loop_margins
from .scenario import Scenario, ScenarioError, load_scenario
from .shapers import (
    CascadedLags,
    FrequencyResponse,
    NullBySize,
    VibrationMap,
    cascaded_lags,
    corner_omega,
    fft_frequency_response,
    frequency_response,
    null_by_size,
    null_omegas,
    null_rise_time,
    place_null,
    residual_vibration,
    rollover_db_per_decade,
    vibration_map,
)
from .survey import Survey, UnstableLoopError, survey

__all__ = [
    "CascadedLags",
    "CheckError",
    "FrequencyResponse",
    "GateReport",
    "LoopMargins",
    "NullBySize",
    "Scenario",
    "ScenarioError",
    "Survey",
    "UnstableLoopError",
    "VibrationMap",
    "cascaded_lags",
    "check_scenario",
    "corner_omega",
    "fft_frequency_response",
    "frequency_response",
    "load_scenario",
    "loop_margins",
    "null_by_size",
    "null_omegas",
    "null_rise_time",
    "place_null",
    "residual_vibration",
    "rollover_db_per_decade",
    "survey",
    "vibration_map",
]
