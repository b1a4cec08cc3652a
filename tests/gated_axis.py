"""A scenario to store numbers of, and to change."""

from pathlib import Path

from jounce.app.gate import GateReport, check_scenario

AXIS = """
title = "Axis"
[plant]
inertia = "1 kg m^2"
[controller]
gains = {kp = "28 N m/rad", ki = "38 N m/(rad s)", kr = "5.4 N m s/rad"}
[limits.axis]
acceleration = "0.2 deg/s^2"
[[moves]]
name = "go"
distance = "60 arcsec"
settle_to = "50 mas"
"""
MODE = '[[modes]]\nname = "tower"\nfrequency = "1.3 Hz"\ndamping = "2 %"\n'


def store(scenario: Path, **options) -> GateReport:
    """Store the scenario's numbers beside it."""
    report = check_scenario(scenario, update=True, **options)
    assert report.passed
    report.measured.write(scenario.with_name("axis.baseline.json"))
    return report


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")


def verdicts(report: GateReport) -> dict[str, str]:
    return {row.name: row.verdict for row in report.rows}
