"""The regression gate: margins and motions of a loop beside stored numbers and bounds."""

from typing import TYPE_CHECKING

from ...later import later

if TYPE_CHECKING:
    from .check import check_scenario
    from .check_file import CheckError
    from .comparison import Row
    from .conditions import Change
    from .report import GateReport
    from .sweep_check import check_sweep

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "Change": "conditions",
    "CheckError": "check_file",
    "GateReport": "report",
    "Row": "comparison",
    "check_scenario": "check",
    "check_sweep": "sweep_check",
}

__all__ = ["Change", "CheckError", "GateReport", "Row", "check_scenario", "check_sweep"]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
