"""Conformance of encoder logs to limits: derivatives with error bars, verdicts, CSV files."""

from .log_file import read_log
from .result import Conformance, Peak
from .verdict import conformance

__all__ = ["Conformance", "Peak", "conformance", "read_log"]
