"""The binding of each version of FMI."""

from __future__ import annotations

from typing import Any

from . import binding_fmi2, binding_fmi3
from .description import FmuDescription


def binding_of(description: FmuDescription) -> Any:
    """Return the module that speaks the FMU's version of FMI."""
    return binding_fmi2 if description.fmi_version.startswith("2") else binding_fmi3
