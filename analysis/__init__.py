"""Margins and surveys of servo loops, scenario files, tables, pictures and the command line."""

from .margins import LoopMargins, loop_margins
from .scenario import Scenario, ScenarioError, load_scenario
from .survey import Survey, UnstableLoopError, survey

__all__ = [
    "LoopMargins",
    "Scenario",
    "ScenarioError",
    "Survey",
    "UnstableLoopError",
    "load_scenario",
    "loop_margins",
    "survey",
]
