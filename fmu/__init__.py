"""Blocks out as FMUs (Functional Mock-up Units) and C, anybody's FMUs in: FMI 2.0 and 3.0."""

from typing import TYPE_CHECKING

from ..later import later

if TYPE_CHECKING:
    from .cosimulation.cosimulate import cosimulate
    from .cosimulation.cosimulation_result import CosimulationResult
    from .cosimulation.fmu_system import FmuSystem
    from .cosimulation.load_ssp import load_ssp
    from .exporting.compile import CompilerError
    from .exporting.digital_controller import DigitalController
    from .exporting.export import FmuExport, export_fmu
    from .exporting.export_c import CExport, export_c
    from .exporting.loop_blocks import SampledController
    from .exporting.sampled_shaper import SampledShaper
    from .exporting.servo_block import SampledLoop
    from .exporting.ssp import SspExport, export_ssp, export_ssp_of
    from .importing.description import FmuDescription, FmuError, FmuTerminated, FmuVariable
    from .importing.io_system import io_system
    from .importing.linearize import linearize_fmu
    from .importing.load import load_fmu
    from .importing.reading import inspect_fmu
    from .importing.snapshot import FmuState
    from .importing.stepping import Fmu

# Imported when they are first asked for.
_LATER = {
    "CExport": "exporting.export_c",
    "export_c": "exporting.export_c",
    "SspExport": "exporting.ssp",
    "export_ssp": "exporting.ssp",
    "export_ssp_of": "exporting.ssp",
    "CompilerError": "exporting.compile",
    "DigitalController": "exporting.digital_controller",
    "CosimulationResult": "cosimulation.cosimulation_result",
    "Fmu": "importing.stepping",
    "FmuDescription": "importing.description",
    "FmuError": "importing.description",
    "FmuExport": "exporting.export",
    "FmuState": "importing.snapshot",
    "FmuSystem": "cosimulation.fmu_system",
    "FmuTerminated": "importing.description",
    "FmuVariable": "importing.description",
    "SampledController": "exporting.loop_blocks",
    "SampledLoop": "exporting.servo_block",
    "SampledShaper": "exporting.sampled_shaper",
    "cosimulate": "cosimulation.cosimulate",
    "export_fmu": "exporting.export",
    "inspect_fmu": "importing.reading",
    "io_system": "importing.io_system",
    "linearize_fmu": "importing.linearize",
    "load_fmu": "importing.load",
    "load_ssp": "cosimulation.load_ssp",
}

__all__ = [
    "CExport",
    "CompilerError",
    "CosimulationResult",
    "DigitalController",
    "Fmu",
    "FmuDescription",
    "FmuError",
    "FmuExport",
    "FmuState",
    "FmuSystem",
    "FmuTerminated",
    "FmuVariable",
    "SampledController",
    "SampledLoop",
    "SampledShaper",
    "SspExport",
    "cosimulate",
    "export_c",
    "export_fmu",
    "export_ssp",
    "export_ssp_of",
    "inspect_fmu",
    "io_system",
    "linearize_fmu",
    "load_fmu",
    "load_ssp",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
