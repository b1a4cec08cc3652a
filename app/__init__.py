"""What takes a scenario file: surveys, checks against a baseline, reports, the command line."""

from typing import TYPE_CHECKING

from ..later import later

if TYPE_CHECKING:
    from .explorer import explore
    from .gate import CheckError, GateReport, check_scenario
    from .scenario import Scenario, ScenarioError, load_scenario
    from .scenario_survey import ScenarioSurvey, survey_file
    from .sweeps.parameters import LogUniform, Normal, Uniform
    from .sweeps.result import ScenarioSweep
    from .sweeps.run import sweep

# Imported when they are first asked for, so that the command line starts soon.
_LATER = {
    "CheckError": "gate",
    "GateReport": "gate",
    "LogUniform": "sweeps.parameters",
    "Normal": "sweeps.parameters",
    "Scenario": "scenario",
    "ScenarioError": "scenario",
    "ScenarioSurvey": "scenario_survey",
    "ScenarioSweep": "sweeps.result",
    "Uniform": "sweeps.parameters",
    "check_scenario": "gate",
    "explore": "explorer",
    "load_scenario": "scenario",
    "survey_file": "scenario_survey",
    "sweep": "sweeps.run",
}

__all__ = [
    "CheckError",
    "GateReport",
    "LogUniform",
    "Normal",
    "Scenario",
    "ScenarioError",
    "ScenarioSurvey",
    "ScenarioSweep",
    "Uniform",
    "check_scenario",
    "explore",
    "load_scenario",
    "survey_file",
    "sweep",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
