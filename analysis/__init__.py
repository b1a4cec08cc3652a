"""Margins and surveys of servo loops, scenario files, tables, pictures and the command line."""

from .frequency import FrequencyResponse, fft_frequency_response, frequency_response
from .margins import LoopMargins, loop_margins
from .scenario import Scenario, ScenarioError, load_scenario
from .survey import Survey, UnstableLoopError, survey

__all__ = [
    "FrequencyResponse",
    "LoopMargins",
    "Scenario",
    "ScenarioError",
    "Survey",
    "UnstableLoopError",
    "fft_frequency_response",
    "frequency_response",
    "load_scenario",
    "loop_margins",
    "survey",
]
