"""What takes a scenario file: surveys, checks against a baseline, reports, the command line."""

from typing import TYPE_CHECKING

from ..later import later

if TYPE_CHECKING:
    from .explorer import explore
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
    "explore": "explorer",
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
    "explore",
    "load_scenario",
    "survey_file",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
