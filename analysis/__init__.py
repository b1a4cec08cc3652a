"""Margins and surveys of servo loops, scenario files, tables, pictures and the command line."""

from .margins import LoopMargins, loop_margins
from .scenario import Scenario, ScenarioError, load_scenario
from .shapers import (
    FrequencyResponse,
    corner_omega,
    fft_frequency_response,
    frequency_response,
    null_omegas,
    rollover_db_per_decade,
)
from .survey import Survey, UnstableLoopError, survey

__all__ = [
    "FrequencyResponse",
    "LoopMargins",
    "Scenario",
    "ScenarioError",
    "Survey",
    "UnstableLoopError",
    "corner_omega",
    "fft_frequency_response",
    "frequency_response",
    "load_scenario",
    "loop_margins",
    "null_omegas",
    "rollover_db_per_decade",
    "survey",
]
