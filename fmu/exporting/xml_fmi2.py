"""modelDescription.xml of FMI 2.0."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree import ElementTree

from .blocks import Block, Variable
from .units import unit_definition

GENERATOR = "jounce"

LOG_CATEGORIES = {
    "logEvents": "Initialisation and reset",
    "logStatusError": "What is refused, and why",
}


def model_description_fmi2(block: Block, token: str, sources: Iterable[str]) -> bytes:
    """Return modelDescription.xml of FMI 2.0 for a block.

    Parameters
    ----------
    block : Block
    token : str
        The GUID.
    sources : iterable of str
        C files to compile.
    """
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=block.name,
        guid=token,
        description=block.description,
        license="BSD-3-Clause",
        generationTool=GENERATOR,
        variableNamingConvention="flat",
        numberOfEventIndicators="0",
    )
    interface = ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=block.name,
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative=str(block.partials).lower(),
    )
    files = ElementTree.SubElement(interface, "SourceFiles")
    for name in sources:
        ElementTree.SubElement(files, "File", name=name)
    add_units(root, block)
    add_experiment(root, block)
    variables = ElementTree.SubElement(root, "ModelVariables")
    for variable in block.variables:
        _add_variable(variables, block, variable)
    _add_structure(root, block)
    return to_bytes(root)


def add_units(root: ElementTree.Element, block: Block) -> None:
    """Add unit definitions with base units, and log categories."""
    definitions = ElementTree.SubElement(root, "UnitDefinitions")
    for name in sorted({variable.unit for variable in block.variables} | {"s"}):
        unit = unit_definition(name)
        base = {symbol: str(exponent) for symbol, exponent in unit.exponents}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        element = ElementTree.SubElement(definitions, "Unit", name=name)
        ElementTree.SubElement(element, "BaseUnit", base)
    categories = ElementTree.SubElement(root, "LogCategories")
    for name, told in LOG_CATEGORIES.items():
        ElementTree.SubElement(categories, "Category", name=name, description=told)


def add_experiment(root: ElementTree.Element, block: Block) -> None:
    """Add the default experiment."""
    ElementTree.SubElement(
        root,
        "DefaultExperiment",
        startTime=repr(block.start_time),
        stopTime=repr(block.stop_time),
        stepSize=repr(block.step),
    )


def common_attributes(variable: Variable, reference: int) -> dict[str, str]:
    """Return the attributes that every variable has in both versions."""
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.initial is not None:
        attributes["initial"] = variable.initial
    return attributes


def value_attributes(variable: Variable, reference: Mapping[str, int]) -> dict[str, str]:
    """Return the attributes of a variable's value."""
    attributes = {"unit": variable.unit}
    for name, bound in (("min", variable.minimum), ("max", variable.maximum)):
        if bound is not None:
            attributes[name] = repr(bound)
    if variable.has_start:
        attributes["start"] = repr(variable.start)
    if variable.derivative_of is not None:
        attributes["derivative"] = str(reference[variable.derivative_of])
    return attributes


def unknown_attributes(
    dependencies: Mapping[str, str], reference: Mapping[str, int]
) -> dict[str, str]:
    """Return the dependencies of an unknown in the order of their references."""
    found = sorted((reference[name], kind) for name, kind in dependencies.items())
    return {
        "dependencies": " ".join(str(index) for index, _ in found),
        "dependenciesKind": " ".join(kind for _, kind in found),
    }


def to_bytes(root: ElementTree.Element) -> bytes:
    """Return a document, indented, in UTF-8."""
    ElementTree.indent(root)
    body: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return body + b"\n"


def _add_variable(parent: ElementTree.Element, block: Block, variable: Variable) -> None:
    reference = block.reference
    element = ElementTree.SubElement(
        parent, "ScalarVariable", common_attributes(variable, reference[variable.name])
    )
    ElementTree.SubElement(element, "Real", value_attributes(variable, reference))


def _add_structure(root: ElementTree.Element, block: Block) -> None:
    structure = ElementTree.SubElement(root, "ModelStructure")
    for name, unknowns, during in (
        ("Outputs", block.outputs, "dependencies"),
        ("Derivatives", block.derivatives, "dependencies"),
        ("InitialUnknowns", block.initial_unknowns, "initial_dependencies"),
    ):
        if not unknowns:
            continue
        group = ElementTree.SubElement(structure, name)
        for variable in unknowns:
            known = {k: v for k, v in getattr(variable, during).items() if k != "time"}
            ElementTree.SubElement(
                group,
                "Unknown",
                {"index": str(block.reference[variable.name])}
                | unknown_attributes(known, block.reference),
            )
