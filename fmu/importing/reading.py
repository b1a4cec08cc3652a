"""`inspect_fmu`: what an FMU says of itself, without running any of it."""

from __future__ import annotations

import os
import re
import zipfile
from pathlib import Path
from xml.etree.ElementTree import Element

from .description import (
    CO_SIMULATION,
    Capabilities,
    DefaultExperiment,
    FmuDescription,
    FmuError,
    FmuUnit,
    FmuVariable,
)
from .parsing import MAX_XML_BYTES, Attributes, each, parse_xml, to_float
from .reading_fmi2 import read_structure_fmi2, read_variables_fmi2
from .reading_fmi3 import read_structure_fmi3, read_variables_fmi3
from .unpacking import entries_by_path, open_fmu, read_entry

XML = "modelDescription.xml"

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,199}", re.ASCII)
_INTERFACES = {
    "CoSimulation": "co-simulation",
    "ModelExchange": "model-exchange",
    "ScheduledExecution": "scheduled-execution",
}
_SUFFIXES = (".so", ".dll", ".dylib")
_BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def inspect_fmu(
    path: str | os.PathLike[str], *, max_unpacked_bytes: int | None = None
) -> FmuDescription:
    """Return what an FMU says of itself; no code of it is loaded, nothing is unpacked to disk.

    Parameters
    ----------
    path : path
        An .fmu file of FMI 2.0 or 3.0, for co-simulation or not, or a folder with the contents
        of one.
    max_unpacked_bytes : int, optional
        To how many bytes the file may unpack. Default: `unpacking.FREE_BYTES`, or `MAX_RATIO`
        times its own size up to `MAX_BYTES` if that is more.

    Returns
    -------
    FmuDescription
        `print` shows it in readable form.

    Raises
    ------
    OSError
        Where the file is not there or cannot be read.
    FmuError
        A ValueError, for a file that is no FMU, is damaged, is of another version of FMI,
        contradicts itself, or is built to do harm (paths that leave the archive, links,
        two entries that differ under one name, zip bombs, a DOCTYPE, a modelIdentifier that is a
        path).

    Notes
    -----
    Bounds on what is read: `unpacking.MAX_ENTRIES`, `MAX_BYTES`, `MAX_RATIO`, `FREE_BYTES`,
    `parsing.MAX_XML_BYTES`, `MAX_ELEMENTS`, `MAX_DEPTH`. A folder's `sha256` is that of the lines
    that sha256sum prints for its files (digest, two blanks, path with "/"), sorted by path.

    References
    ----------
    FMI 2.0.5 and FMI 3.0.2, sections "FMI Description Schema" and "FMU Distribution".

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from jounce.plant import Inertia
    >>> from jounce.fmu import export_fmu
    >>> with TemporaryDirectory() as folder:
    ...     written = export_fmu(Inertia(2.0), f"{folder}/plant.fmu", platforms=[])
    ...     says = inspect_fmu(written.path)
    >>> [variable.name for variable in says.of_causality("input", "output")]
    ['u', 'y', 'y_rate']
    >>> says.capabilities.can_get_and_set_state, says.platforms
    (True, ())
    """
    with open_fmu(Path(path), max_unpacked_bytes) as (archive, digest):
        return describe(archive, digest)


def describe(archive: zipfile.ZipFile, sha256: str) -> FmuDescription:
    """Return the description in a checked archive."""
    names = [name for name, entry in entries_by_path(archive).items() if not entry.is_dir()]
    if XML not in names:
        raise FmuError(
            f"no {XML} at the top of the archive: not an FMU (zip the contents of the folder, "
            "not the folder)"
        )
    root = parse_xml(read_entry(archive, XML, MAX_XML_BYTES), XML)
    version = _version(root)
    interfaces = {kind: root.find(tag) for tag, kind in _INTERFACES.items()}
    found: dict[str, Element] = {k: e for k, e in interfaces.items() if e is not None}
    if not found:
        raise FmuError(f"{XML}: neither {' nor '.join(_INTERFACES)}; export the FMU again")
    identifiers = {
        kind: _identifier(Attributes(element, XML).text("modelIdentifier"))
        for kind, element in found.items()
    }
    identifier = identifiers.get(CO_SIMULATION, next(iter(identifiers.values())))
    head = Attributes(root, XML)
    second = version.startswith("2")
    variables = read_variables_fmi2(root) if second else read_variables_fmi3(root)
    _check_variables(variables, unique_references=not second)
    structure = (read_structure_fmi2 if second else read_structure_fmi3)(root, variables)
    return FmuDescription(
        fmi_version=version,
        model_name=head.text("modelName"),
        model_identifier=identifier,
        kinds=tuple(found),
        token=head.text("guid" if second else "instantiationToken"),
        description=head.text("description", ""),
        author=head.text("author", ""),
        version=head.text("version", ""),
        generation_tool=head.text("generationTool", ""),
        variables=variables,
        units=tuple(read_unit(element) for element in each(root, "UnitDefinitions")),
        platforms=_platforms(names, identifier),
        has_sources=any(name.startswith("sources/") for name in names),
        capabilities=_capabilities(found.get(CO_SIMULATION)),
        default_experiment=_experiment(root.find("DefaultExperiment")),
        outputs=structure["outputs"],
        derivatives=structure["derivatives"],
        initial_unknowns=structure["initial_unknowns"],
        sha256=sha256,
    )


def _version(root: Element) -> str:
    if root.tag != "fmiModelDescription":
        raise FmuError(f"{XML}: root {root.tag!r}; expected fmiModelDescription")
    version = root.get("fmiVersion", "")
    if not re.match(r"(2\.0|3\.\d+)(?!\d)", version):
        raise FmuError(
            f"{XML}: fmiVersion = {version!r}; expected 2.0 or 3.0: export {_named(root, version)} "
            "as one for co-simulation in FMI 2.0 or 3.0"
        )
    return version


def _named(root: Element, version: str) -> str:
    """Return which FMU of another version of FMI this is; in FMI 1.0 `Implementation` tells."""
    if not version.startswith("1."):
        return "the FMU"
    kind = "model exchange" if root.find("Implementation") is None else "co-simulation"
    tool = root.get("generationTool")
    return f"this FMI 1.0 FMU for {kind} again{f', from {tool},' if tool else ''}"


def _identifier(text: str) -> str:
    if not _IDENTIFIER.fullmatch(text):
        raise FmuError(
            f"modelIdentifier = {text!r}: expected a C identifier, for it names the library that "
            "is loaded; do not trust this file"
        )
    return text


def _check_variables(variables: tuple[FmuVariable, ...], *, unique_references: bool) -> None:
    names: set[str] = set()
    references: dict[int, str] = {}
    for variable in variables:
        for name in (variable.name, *variable.aliases):
            if name in names:
                raise FmuError(f"two variables {name!r}: export the FMU again")
            names.add(name)
        other = references.setdefault(variable.value_reference, variable.name)
        if unique_references and other != variable.name:
            raise FmuError(
                f"{other!r} and {variable.name!r} share the value reference "
                f"{variable.value_reference}, which FMI 3.0 forbids: export the FMU again"
            )


def _platforms(names: list[str], identifier: str) -> tuple[str, ...]:
    libraries = {f"{identifier}{suffix}" for suffix in _SUFFIXES}
    parts = [name.split("/") for name in names]
    return tuple(
        sorted({p[1] for p in parts if len(p) == 3 and p[0] == "binaries" and p[2] in libraries})
    )


def _capabilities(element: Element | None) -> Capabilities:
    """Return the capabilities of a co-simulation interface; FMI 2.0 and 3.0 spell some apart."""
    if element is None:
        return Capabilities()
    said = Attributes(element, "CoSimulation")
    return Capabilities(
        can_get_and_set_state=said.flag("canGetAndSetFMUstate")
        or said.flag("canGetAndSetFMUState"),
        can_serialize_state=said.flag("canSerializeFMUstate") or said.flag("canSerializeFMUState"),
        provides_directional_derivatives=said.flag("providesDirectionalDerivative")
        or said.flag("providesDirectionalDerivatives"),
        can_handle_variable_step=said.flag("canHandleVariableCommunicationStepSize"),
        can_interpolate_inputs=said.flag("canInterpolateInputs"),
        fixed_internal_step=said.number("fixedInternalStepSize"),
        has_event_mode=said.flag("hasEventMode"),
        needs_execution_tool=said.flag("needsExecutionTool"),
        only_one_instance_per_process=said.flag("canBeInstantiatedOnlyOncePerProcess"),
    )


def _experiment(element: Element | None) -> DefaultExperiment:
    if element is None:
        return DefaultExperiment()
    said = Attributes(element, "DefaultExperiment")
    return DefaultExperiment(
        start_time=said.number("startTime"),
        stop_time=said.number("stopTime"),
        tolerance=said.number("tolerance"),
        step_size=said.number("stepSize"),
    )


def read_unit(element: Element) -> FmuUnit:
    """Return the unit that an element Unit defines."""
    name = Attributes(element, "UnitDefinitions").text("name")
    base = element.find("BaseUnit")
    if base is None:
        return FmuUnit(name)
    said = Attributes(base, f"unit {name!r}")
    exponents = [(symbol, said.whole(symbol, 0)) for symbol in _BASE_UNITS]
    return FmuUnit(
        name,
        tuple((symbol, power) for symbol, power in exponents if power),
        to_float(said.text("factor", "1"), f"unit {name!r}: factor"),
        to_float(said.text("offset", "0"), f"unit {name!r}: offset"),
    )
