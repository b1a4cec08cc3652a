"""Conformance of encoder logs to limits: derivatives with error bars, verdicts, CSV files."""

from .log_file import read_log
from .verdict import Conformance, Peak, conformance

__all__ = ["Conformance", "Peak", "conformance", "read_log"]
