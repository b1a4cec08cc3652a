"""The survey of a real loop, told as that of a scenario file."""

from dataclasses import fields, replace

from real_loops import LABELS, real_survey

from jounce.app import load_scenario
from jounce.app.scenario_survey import ScenarioSurvey


def scenario_survey(path, found=None):
    """Return a survey as if it were the scenario's of a file."""
    found = found or real_survey()
    scenario = replace(load_scenario(path), title=LABELS.title, position_unit="arcsec")
    own = {field.name: getattr(found, field.name) for field in fields(found)}
    return ScenarioSurvey(**own, scenario=scenario)
