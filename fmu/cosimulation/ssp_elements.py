"""SystemStructure.ssd as a tree of systems and components with their connectors."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from urllib.parse import unquote
from xml.etree.ElementTree import Element

from ..importing.description import FmuError, FmuUnit
from ..importing.parsing import MAX_XML_BYTES, Attributes, parse_xml, to_float
from ..importing.reading import read_unit
from ..importing.unpacking import read_entry
from .ssp_structure import Component, Hop

SSD = "SystemStructure.ssd"

_FMU = "application/x-fmu-sharedlibrary"


@dataclass(frozen=True)
class Part:
    """A component, or a system with the parts in it; kinds and units of connectors by name."""

    path: str
    node: Element
    kinds: Mapping[str, str]
    units: Mapping[str, str]
    parts: Mapping[str, Part] | None = None

    def walk(self) -> Iterator[Part]:
        """Yield what is in it, innermost parts first, and itself."""
        for part in (self.parts or {}).values():
            yield from part.walk()
        yield self


def read_part(node: Element, path: str) -> Part:
    """Return the tree below an element System."""
    connectors = [Attributes(c, f"{SSD}: {path or 'the system'}") for c in children(
        node, "Connectors", "Connector")]  # fmt: skip
    kinds = {said.text("name"): said.text("kind") for said in connectors}
    units = {
        element.get("name", ""): typed.get("unit", "")
        for element in children(node, "Connectors", "Connector")
        for typed in element
        if typed.get("unit")
    }
    if node.tag == "Component":
        return Part(path, node, kinds, units)
    parts: dict[str, Part] = {}
    for element in node.findall("Elements/*"):
        name = Attributes(element, f"{SSD}: element {element.tag}").text("name")
        if element.tag not in ("Component", "System"):
            raise FmuError(
                f"{SSD}: {name!r} is a {element.tag}, which is not supported: expected FMUs and "
                "systems of FMUs; export the system without it"
            )
        if name in parts:
            raise FmuError(f"{SSD}: two elements {name!r}; export the system again")
        # a block of `cosimulate` has no dot in its name
        parts[name] = read_part(element, "/".join(filter(None, (path, name.replace(".", "/")))))
    return Part(path, node, kinds, units, parts)


def component_of(part: Part, archive: zipfile.ZipFile) -> Component:
    """Return a component; FmuError where it is no FMU for co-simulation in the archive."""
    said = Attributes(part.node, f"{SSD}: component {part.path!r}")
    place, kind = f"component {part.path!r}", said.text("type", _FMU)
    if kind != _FMU:
        raise FmuError(f"{place} is {kind}: expected an FMU, {_FMU}; put its FMUs here themselves")
    if said.text("implementation", "any") == "ModelExchange":
        raise FmuError(f"{place} is for model exchange: export it for co-simulation")
    return Component(part.path, entry_of(archive, said.text("source"), place), part.units)


def entry_of(archive: zipfile.ZipFile, source: str, place: str) -> str:
    """Return the entry of an archive that a relative URI names."""
    path = PurePosixPath(unquote(source))
    if ":" in source or "#" in source or path.is_absolute() or ".." in path.parts:
        raise FmuError(
            f"{place}: source {source!r}; expected a file within the archive, such as "
            "'resources/plant.fmu'"
        )
    if str(path) not in archive.namelist():
        raise FmuError(f"{place}: no {str(path)!r} in the archive; export the system again")
    return str(path)


def xml_of(archive: zipfile.ZipFile, name: str, root: str) -> Element:
    """Return the root of an XML file of the archive, its tags without their prefixes."""
    if name not in archive.namelist():
        raise FmuError(
            f"no {name} at the top of the archive: not an SSP (zip the contents of the folder, "
            "not the folder)"
        )
    tree = parse_xml(read_entry(archive, name, MAX_XML_BYTES), name)
    for element in tree.iter():
        element.tag = element.tag.rpartition(":")[2]
    if tree.tag != root:
        raise FmuError(f"{name}: root {tree.tag!r}; expected {root}")
    return tree


def children(node: Element, group: str, tag: str) -> list[Element]:
    """Return the elements of one tag in a group below a node."""
    return node.findall(f"{group}/{tag}")


def units_in(node: Element) -> tuple[FmuUnit, ...]:
    """Return the units that a file defines."""
    return tuple(read_unit(element) for element in children(node, "Units", "Unit"))


def hop_of(node: Element, unit: str, place: str) -> Hop:
    """Return the conversion of a connection or of an entry of a mapping."""
    factor, offset = 1.0, 0.0
    for element in node:
        if element.tag == "LinearTransformation":
            factor = to_float(element.get("factor", "1"), f"{place}: factor")
            offset = to_float(element.get("offset", "0"), f"{place}: offset")
        elif element.tag.endswith("Transformation"):
            raise FmuError(
                f"{place} has a {element.tag}, which is not supported: expected a "
                "LinearTransformation; export the system without it"
            )
    literal = Attributes(node, place).flag("suppressUnitConversion")
    return Hop(unit, factor, offset, literal)
