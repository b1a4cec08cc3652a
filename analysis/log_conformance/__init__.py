"""Conformance of encoder logs to limits: derivatives with error bars, verdicts, CSV files."""

from typing import TYPE_CHECKING

from ...later import later

if TYPE_CHECKING:
    from .log_file import read_log
    from .result import Conformance, Peak
    from .verdict import conformance

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "Conformance": "result",
    "Peak": "result",
    "conformance": "verdict",
    "read_log": "log_file",
}

__all__ = ["Conformance", "Peak", "conformance", "read_log"]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
