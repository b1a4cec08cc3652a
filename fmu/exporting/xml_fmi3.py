"""modelDescription.xml and buildDescription.xml of FMI 3.0."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree

from .blocks import Block
from .xml_fmi2 import (
    GENERATOR,
    add_experiment,
    add_units,
    common_attributes,
    to_bytes,
    unknown_attributes,
    value_attributes,
)


def model_description_fmi3(block: Block, token: str) -> bytes:
    """Return modelDescription.xml of FMI 3.0 for a block.

    Parameters
    ----------
    block : Block
    token : str
        The instantiation token.
    """
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=block.name,
        instantiationToken=token,
        description=block.description,
        license="BSD-3-Clause",
        generationTool=GENERATOR,
        variableNamingConvention="flat",
    )
    interface = {
        "modelIdentifier": block.name,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": str(block.partials).lower(),
        "providesAdjointDerivatives": str(block.partials).lower(),
        "canHandleVariableCommunicationStepSize": "true",
    }
    if block.sample_time is not None:
        interface["fixedInternalStepSize"] = repr(block.sample_time)
    ElementTree.SubElement(root, "CoSimulation", interface)
    add_units(root, block)
    add_experiment(root, block)
    variables = ElementTree.SubElement(root, "ModelVariables")
    ElementTree.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference="0",
        description="Simulation time",
        causality="independent",
        variability="continuous",
        unit="s",
    )
    for variable in block.variables:
        ElementTree.SubElement(
            variables,
            "Float64",
            common_attributes(variable, block.reference[variable.name])
            | value_attributes(variable, block.reference),
        )
    _add_structure(root, block)
    return to_bytes(root)


def _add_structure(root: ElementTree.Element, block: Block) -> None:
    structure = ElementTree.SubElement(root, "ModelStructure")
    reference = block.reference | {"time": 0}
    for name, unknowns, during in (
        ("Output", block.outputs, "dependencies"),
        ("ContinuousStateDerivative", block.derivatives, "dependencies"),
        ("InitialUnknown", block.initial_unknowns, "initial_dependencies"),
    ):
        for variable in unknowns:
            ElementTree.SubElement(
                structure,
                name,
                {"valueReference": str(reference[variable.name])}
                | unknown_attributes(getattr(variable, during), reference),
            )


def build_description(block: Block, sources: Iterable[str]) -> bytes:
    """Return buildDescription.xml: how the sources are compiled."""
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ElementTree.SubElement(root, "BuildConfiguration", modelIdentifier=block.name)
    files = ElementTree.SubElement(
        configuration,
        "SourceFileSet",
        language="C99",
        compilerOptions="-ffp-contract=off",
    )
    for name in sources:
        ElementTree.SubElement(files, "SourceFile", name=name)
    return to_bytes(root)
