"""Blocks out as FMUs (Functional Mock-up Units), and anybody's FMUs in: FMI 2.0 and 3.0."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .compile import CompilerError
    from .cosimulate import cosimulate
    from .cosimulation_result import CosimulationResult
    from .description import FmuDescription, FmuError, FmuVariable
    from .export import FmuExport, export_fmu
    from .io_system import io_system
    from .linearize import linearize_fmu
    from .load import load_fmu
    from .loop_blocks import SampledController
    from .reading import inspect_fmu
    from .stepping import Fmu, FmuState

# Imported when they are first asked for.
_LATER = {
    "CompilerError": "compile",
    "CosimulationResult": "cosimulation_result",
    "Fmu": "stepping",
    "FmuDescription": "description",
    "FmuError": "description",
    "FmuExport": "export",
    "FmuState": "stepping",
    "FmuVariable": "description",
    "SampledController": "loop_blocks",
    "cosimulate": "cosimulate",
    "export_fmu": "export",
    "inspect_fmu": "reading",
    "io_system": "io_system",
    "linearize_fmu": "linearize",
    "load_fmu": "load",
}

__all__ = [
    "CompilerError",
    "CosimulationResult",
    "Fmu",
    "FmuDescription",
    "FmuError",
    "FmuExport",
    "FmuState",
    "FmuVariable",
    "SampledController",
    "cosimulate",
    "export_fmu",
    "inspect_fmu",
    "io_system",
    "linearize_fmu",
    "load_fmu",
]


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_LATER[name]}", __name__), name)
    globals()[name] = value
    return value
