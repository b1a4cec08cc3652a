"""What takes a scenario file: surveys, checks against a baseline, reports, the command line."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .gate import CheckError, GateReport, check_scenario
    from .scenario import Scenario, ScenarioError, load_scenario
    from .scenario_survey import ScenarioSurvey, survey_file

# Imported when they are first asked for, so that the command line starts soon.
_LATER = {
    "CheckError": "gate",
    "GateReport": "gate",
    "Scenario": "scenario",
    "ScenarioError": "scenario",
    "ScenarioSurvey": "scenario_survey",
    "check_scenario": "gate",
    "load_scenario": "scenario",
    "survey_file": "scenario_survey",
}

__all__ = [
    "CheckError",
    "GateReport",
    "Scenario",
    "ScenarioError",
    "ScenarioSurvey",
    "check_scenario",
    "load_scenario",
    "survey_file",
]


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_LATER[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
