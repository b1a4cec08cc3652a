"""Margins and surveys of servo loops, scenario files, tables, pictures and the command line."""

from importlib import import_module
from typing import TYPE_CHECKING

from .conformance import Conformance, conformance, read_log
from .gate import CheckError, GateReport, check_scenario
from .margins import LoopMargins, ManyMargins, loop_margins, many_loop_margins, servo_margins
from .scenario import Scenario, ScenarioError, load_scenario
from .shapers import (
    CascadedLags,
    DescribingFunction,
    FirstOrderLag,
    FrequencyResponse,
    NullBySize,
    PeriodicResponse,
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
    vibration_map,
)
from .survey import Survey, UnstableLoopError, survey

if TYPE_CHECKING:
    from . import plots

__all__ = [
    "CascadedLags",
    "CheckError",
    "Conformance",
    "DescribingFunction",
    "FirstOrderLag",
    "FrequencyResponse",
    "GateReport",
    "LoopMargins",
    "ManyMargins",
    "NullBySize",
    "PeriodicResponse",
    "Scenario",
    "ScenarioError",
    "Survey",
    "UnstableLoopError",
    "VibrationMap",
    "cascaded_lags",
    "check_scenario",
    "conformance",
    "corner_omega",
    "describing_function",
    "fft_frequency_response",
    "first_order_lag",
    "frequency_response",
    "load_scenario",
    "loop_margins",
    "many_loop_margins",
    "null_by_size",
    "null_omegas",
    "null_rise_time",
    "periodic_response",
    "place_null",
    "plots",
    "rate_limiter_corner_omega",
    "read_log",
    "residual_vibration",
    "rollover_db_per_decade",
    "servo_margins",
    "survey",
    "vibration_map",
]


def __getattr__(name: str) -> object:
    if name != "plots":  # imported when it is first asked for
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(".plots", __name__)


def __dir__() -> list[str]:
    return sorted(__all__)
