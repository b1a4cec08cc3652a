"""What an SSP file says: components, connections without nesting, values of parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..importing.description import FmuUnit

End = tuple[str, str]
"""Component and variable; "" and a connector for one of the system as a whole."""


@dataclass(frozen=True)
class Hop:
    """One connection on the way of a value: factor·value + offset, in the unit of where it leads.

    `unit` is the name that the file gives to the unit there, empty where it gives none; with
    `literal` the value is taken as it is, whatever the units.
    """

    unit: str
    factor: float = 1.0
    offset: float = 0.0
    literal: bool = False


@dataclass(frozen=True)
class Component:
    """An FMU of the system: its entry in the archive, and the units of its connectors."""

    name: str
    entry: str
    units: Mapping[str, str]


@dataclass(frozen=True)
class Route:
    """Where the value of a variable, or of "" and an output of the system, comes from.

    The source is an output of a component, or "" and an input or parameter of the system; `unit`
    is its unit in the file.
    """

    source: End
    unit: str
    target: End
    hops: tuple[Hop, ...]


@dataclass(frozen=True)
class Value:
    """What a parameter set gives to a variable of a component, over hops."""

    target: End
    value: object
    unit: FmuUnit
    hops: tuple[Hop, ...]
    said_by: str


@dataclass(frozen=True)
class SystemStructure:
    """A SystemStructure.ssd with all that it refers to but the FMUs.

    Attributes
    ----------
    name : str
    components : tuple of Component
        In the order of the file; those of a system within it are named "system/component".
    routes : tuple of Route
    values : tuple of Value
        In the order in which they are to be taken: later ones count.
    inputs, parameters : tuple of str
        Of the system as a whole.
    named_units : mapping of str to str
        Names of the units of inputs and outputs of the system, where the file gives them.
    units : tuple of FmuUnit
    start_time, stop_time : float or None
        Default experiment.
    notes : tuple of str
    """

    name: str
    components: tuple[Component, ...]
    routes: tuple[Route, ...]
    values: tuple[Value, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    named_units: Mapping[str, str]
    units: tuple[FmuUnit, ...]
    start_time: float | None
    stop_time: float | None
    notes: tuple[str, ...]
