"""SystemStructure.ssd of SSP 1.0: components, connectors, connections, units, experiment."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree import ElementTree

from .blocks import Block
from .units import unit_definition
from .xml_fmi2 import GENERATOR, to_bytes

Link = tuple[str, str, str, str]
"""Component and output, component and input."""

_NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructure"
_ORDER = (
    "Stepped one after another in the order {order} (Gauss-Seidel), it is exactly the sampled loop "
    "behind a zero-order hold. A host that steps all components on the values of the last "
    "communication point (Jacobi) adds one sample of delay to the loop."
)


def structure_description(
    name: str,
    blocks: Mapping[str, Block],
    links: Iterable[Link],
    start_time: float,
    duration: float,
) -> bytes:
    """Return SystemStructure.ssd.

    Parameters
    ----------
    name : str
        Of the system.
    blocks : mapping of str to Block
        By name of the component, in the order to be stepped; the FMU of each is
        resources/NAME.fmu.
    links : iterable of (str, str, str, str)
    start_time, duration : float
        Default experiment.
    """
    ElementTree.register_namespace("ssd", f"{_NAMESPACE}Description")
    ElementTree.register_namespace("ssc", f"{_NAMESPACE}Common")
    root = ElementTree.Element(
        _ssd("SystemStructureDescription"), version="1.0", name=name, generationTool=GENERATOR
    )
    order = _ORDER.format(order=", ".join(blocks))
    system = ElementTree.SubElement(root, _ssd("System"), name=name, description=order)
    elements = ElementTree.SubElement(system, _ssd("Elements"))
    for own, block in blocks.items():
        _add_component(elements, own, block)
    _add_connections(system, list(links))
    _add_units(root, blocks.values())
    ElementTree.SubElement(
        root,
        _ssd("DefaultExperiment"),
        startTime=repr(start_time),
        stopTime=repr(start_time + duration),
    )
    return to_bytes(root)


def _add_connections(system: ElementTree.Element, links: list[Link]) -> None:
    if links:
        group = ElementTree.SubElement(system, _ssd("Connections"))
        names = ("startElement", "startConnector", "endElement", "endConnector")
        for link in links:
            ElementTree.SubElement(group, _ssd("Connection"), dict(zip(names, link, strict=True)))


def _add_component(parent: ElementTree.Element, name: str, block: Block) -> None:
    component = ElementTree.SubElement(
        parent,
        _ssd("Component"),
        name=name,
        description=block.description,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{name}.fmu",
        implementation="CoSimulation",
    )
    connectors = ElementTree.SubElement(component, _ssd("Connectors"))
    for variable in block.variables:
        if variable.causality in ("input", "output"):
            connector = ElementTree.SubElement(
                connectors,
                _ssd("Connector"),
                name=variable.name,
                kind=variable.causality,
                description=variable.description,
            )
            ElementTree.SubElement(connector, _ssc("Real"), unit=variable.unit)


def _add_units(root: ElementTree.Element, blocks: Iterable[Block]) -> None:
    used = {
        variable.unit
        for block in blocks
        for variable in block.variables
        if variable.causality in ("input", "output")
    }
    group = ElementTree.SubElement(root, _ssd("Units"))
    for name in sorted(used):
        unit = unit_definition(name)
        base = {symbol: str(exponent) for symbol, exponent in unit.exponents}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        element = ElementTree.SubElement(group, _ssc("Unit"), name=name)
        ElementTree.SubElement(element, _ssc("BaseUnit"), base)


def _ssd(tag: str) -> str:
    return f"{{{_NAMESPACE}Description}}{tag}"


def _ssc(tag: str) -> str:
    return f"{{{_NAMESPACE}Common}}{tag}"
