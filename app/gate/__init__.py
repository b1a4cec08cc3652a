"""The regression gate: margins and motions of a loop beside stored numbers and bounds."""

from .check import check_scenario
from .check_file import CheckError
from .comparison import Row
from .conditions import Change
from .report import GateReport

__all__ = ["Change", "CheckError", "GateReport", "Row", "check_scenario"]
