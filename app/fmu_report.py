"""An FMU, and a run of one, as tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from numbers import Integral
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table
from rich.text import Text

from ..analysis.tables import plain_table

if TYPE_CHECKING:
    from ..fmu.cosimulation.cosimulation_result import CosimulationResult
    from ..fmu.cosimulation.ssp_plan import SspPlan
    from ..fmu.importing.description import FmuDescription, FmuVariable

_GROUPS = {
    "Inputs": ("input",),
    "Outputs": ("output",),
    "Parameters": ("parameter", "structuralParameter", "calculatedParameter"),
    "Local variables": ("local", "independent"),
}
_LONGEST = 60
_COMPONENT = ("component", "FMU", "FMI", "binaries", "parameters given")


def fmu_tables(description: FmuDescription, *, local: bool = False) -> list[Table]:
    """Return the tables of what an FMU says of itself; its local variables where asked for."""
    tables = [_summary(description)]
    for title, causalities in _GROUPS.items():
        variables = description.of_causality(*causalities)
        if variables and (local or title != "Local variables"):
            tables.append(_variables(title, variables))
    return tables


def ssp_tables(plan: SspPlan) -> list[Table | str]:
    """Return the tables of what an SSP says: components, what they are given, connections."""
    structure = plan.structure
    settings, notes = plan.settings({})
    parts = plain_table(f"{structure.name}: SSP of {len(plan.descriptions)} FMUs", *_COMPONENT)
    for name, description in plan.descriptions.items():
        given = ", ".join(f"{key} = {_shown(value)}" for key, value in settings[name].items())
        binaries = ", ".join(description.platforms) or "none"
        cells = (name, description.model_name, description.fmi_version, binaries, given)
        parts.add_row(*map(Text, cells))
    links = plain_table("Connections", "from", "to", "gain", "offset")
    rows = plan.links()
    for source, target, gain, offset in rows:
        links.add_row(Text(source), Text(target), f"{gain:.9g}", f"{offset:.9g}")
    for column in (*parts.columns[1:], links.columns[1]):
        column.justify = "left"
    return [parts, *([links] if rows else []), *notes, f"sha256 {plan.sha256}"]


def run_table(result: CosimulationResult, names: Iterable[str], units: Mapping[str, str]) -> Table:
    """Return where each signal of a run starts, ends and lies between."""
    time = result.time
    title = f"From {time[0]:.6g} s to {time[-1]:.6g} s in {len(time) - 1} steps"
    table = plain_table(title, "", "start", "end", "least", "greatest", "unit")
    for name in names:
        values = result[name]
        peak = np.abs(values.astype(float)).max()
        numbers = (values[0], values[-1], values.min(), values.max())
        table.add_row(Text(name), *(_cleaned(v, peak) for v in numbers), Text(units.get(name, "")))
    return table


def _summary(description: FmuDescription) -> Table:
    can, experiment = description.capabilities, description.default_experiment
    abilities = {
        "get and set its state": can.can_get_and_set_state,
        "serialise its state": can.can_serialize_state,
        "directional derivatives": can.provides_directional_derivatives,
        "steps of any length": can.can_handle_variable_step,
    }
    needs = {
        "the tool that made it": can.needs_execution_tool,
        "a process for each instance": can.only_one_instance_per_process,
    }
    times = {
        "start": experiment.start_time,
        "stop": experiment.stop_time,
        "step": experiment.step_size,
        "inner step": can.fixed_internal_step,
    }
    suggested = [f"{k} {v:.6g} s" for k, v in times.items() if v is not None]
    if experiment.tolerance is not None:
        suggested.append(f"tolerance {experiment.tolerance:.3g}")
    rows = {
        "description": description.description,
        "kind": _kind(description),
        "author": description.author,
        "version": description.version,
        "made by": description.generation_tool,
        "model identifier": description.model_identifier,
        "binaries": ", ".join(description.platforms) or "none",
        "sources": "yes" if description.has_sources else "no",
        "can": ", ".join(text for text, holds in abilities.items() if holds) or "step",
        "needs": ", ".join(text for text, holds in needs.items() if holds),
        "experiment": ", ".join(suggested),
        "variables": str(len(description.variables)),
        "sha256": description.sha256,
    }
    table = plain_table(f"{description.model_name}: FMI {description.fmi_version}", "", "")
    table.columns[1].justify, table.show_header = "left", False
    for key, value in rows.items():
        if value:
            table.add_row(key, Text(value))
    return table


def _kind(description: FmuDescription) -> str:
    from ..fmu.importing.description import CO_SIMULATION

    kinds = ", ".join(description.kinds)
    if CO_SIMULATION in description.kinds:
        return kinds
    return f"{kinds} only: to be run here, it must be exported for co-simulation"


def _variables(title: str, variables: Iterable[FmuVariable]) -> Table:
    table = plain_table(title, "", "start", "min", "max", "unit", "varies", "type", "description")
    for column in table.columns[4:]:
        column.justify = "left"
    for variable in variables:
        shape = "×".join(map(str, variable.shape))
        cells = (
            variable.name + (f"[{shape}]" if shape else ""),
            _shown(variable.start),
            _shown(variable.min),
            _shown(variable.max),
            variable.unit,
            variable.variability,
            variable.type,
            "; ".join(filter(None, (variable.description, *_remarks(variable)))),
        )
        table.add_row(*map(Text, cells))
    return table


def _remarks(variable: FmuVariable) -> Iterator[str]:
    """Yield what may be given to the variable, or for its name, in other words."""
    if variable.items:
        yield ", ".join(f"{value} = {name}" for name, value in variable.items)
    if variable.aliases:
        yield f"also {', '.join(variable.aliases)}"


def _cleaned(value: float, peak: float) -> str:
    """Return a number for reading, rounding errors beside its peak left out."""
    if isinstance(value, Integral):
        return str(value)
    return "0" if isfinite(peak) and abs(value) <= 1e-12 * peak else f"{value:.9g}"


def _shown(value: object) -> str:
    if value is None:
        return ""
    text = f"{value:.9g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 2]} …"
