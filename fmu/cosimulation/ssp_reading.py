"""An SSP file read without running any of it: connections followed through systems in systems."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

from ..importing.description import FmuError, FmuUnit, candidates
from ..importing.parsing import Attributes, to_bool, to_float, to_int
from .conversion import unit_of
from .ssp_elements import (
    SSD,
    Part,
    children,
    component_of,
    entry_of,
    hop_of,
    read_part,
    units_in,
    xml_of,
)
from .ssp_structure import Component, End, Hop, Route, SystemStructure, Value

_OUT = ("output", "calculatedParameter")
_IN = ("input", "parameter")
_FLOATS = ("Real", "Float64", "Float32")
_TEXTS = ("String", "Enumeration")

Edges = Mapping[End, tuple[End, Hop]]


def read_ssp(archive: zipfile.ZipFile) -> SystemStructure:
    """Return what an SSP says of its system.

    Raises
    ------
    FmuError
        For a file that is no SSP, contradicts itself, or holds what is not supported: components
        that are no FMUs for co-simulation, signal dictionaries, mappings of values other than
        linear ones, sources outside the archive.

    References
    ----------
    System Structure and Parameterization 1.0, Modelica Association, 2019.
    """
    root = xml_of(archive, SSD, "SystemStructureDescription")
    node = root.find("System")
    if node is None:
        raise FmuError(f"{SSD}: no System; export the system again")
    system = read_part(node, "")
    parts = [part for part in system.walk() if part is not system]
    found = {part.path: component_of(part, archive) for part in parts if part.parts is None}
    if not found:
        raise FmuError(f"{SSD}: no components; expected at least one FMU")
    if len({part.path for part in parts}) < len(parts):
        raise FmuError(f"{SSD}: two elements of one name, '.' taken as '/'; rename one")
    edges = dict(_edges(system))
    units = units_in(root)
    reader = _Bindings(archive, edges, frozenset(found), units)
    values, notes = reader.read(system)
    experiment = root.find("DefaultExperiment")
    said = Attributes(Element("none") if experiment is None else experiment, "DefaultExperiment")
    return SystemStructure(
        name=node.get("name") or root.get("name") or "system",
        components=tuple(found.values()),
        routes=tuple(_routes(system, edges, found)),
        values=tuple(values),
        inputs=tuple(name for name, kind in system.kinds.items() if kind == "input"),
        parameters=tuple(name for name, kind in system.kinds.items() if kind == "parameter"),
        named_units=system.units,
        units=units,
        start_time=said.number("startTime"),
        stop_time=said.number("stopTime"),
        notes=tuple(notes),
    )


def _edges(system: Part) -> Iterator[tuple[End, tuple[End, Hop]]]:
    """Yield what is connected: the end that is fed, the end that feeds it, what lies between."""
    fed: set[End] = set()
    for part in system.walk():
        for node in children(part.node, "Connections", "Connection"):
            (source, _), (target, unit), place = _directed(part, node)
            if target in fed:
                raise FmuError(f"{place}: '{_told(target)}' has two sources; expected one")
            fed.add(target)
            yield target, (source, hop_of(node, unit, place))


def _directed(part: Part, node: Element) -> tuple[tuple[End, str], tuple[End, str], str]:
    """Return source and target of a connection, each with its unit; the file may name either first.

    A connector of the system itself is seen from inside: its input is a source.
    """
    said = Attributes(node, f"{SSD}: Connection")
    ends, gives = list[tuple[End, str]](), list[bool | None]()
    for end in ("start", "end"):
        element, connector = said.text(f"{end}Element", ""), said.text(f"{end}Connector")
        parts = part.parts or {}
        if element and element not in parts:
            raise FmuError(f"{SSD}: Connection: no element {element!r}{candidates(element, parts)}")
        one = parts[element] if element else part
        kind = one.kinds.get(connector, "inout")
        if not element and connector not in part.kinds:
            raise FmuError(
                f"{SSD}: Connection: the system has no connector {connector!r}"
                f"{candidates(connector, part.kinds)}"
            )
        if kind == "calculatedParameter":
            raise FmuError(
                f"{SSD}: {_told((one.path, connector))!r} is a calculated parameter, whose "
                "connection is not supported: make it an output"
            )
        gives.append((kind in (_OUT if element else _IN)) if kind in _OUT + _IN else None)
        ends.append(((one.path, connector), one.units.get(connector, "")))
    place = f"{SSD}: connection of {_told(ends[0][0])!r} and {_told(ends[1][0])!r}"
    start = gives[0] if gives[0] is not None else not gives[1]
    if gives[1] is not None and gives[1] == start:
        both = "give a value" if start else "take one"
        raise FmuError(f"{place}: both {both}; expected an output and an input")
    first, last = ends if start else ends[::-1]
    return first, last, place


def _routes(system: Part, edges: Edges, components: Mapping[str, Component]) -> Iterator[Route]:
    """Yield, for all that is fed in the end, where its value comes from."""
    units = {(p.path, c): unit for p in system.walk() for c, unit in p.units.items()}
    for target in edges:
        if target[0] not in components and target[0]:
            continue
        source, hops = target, list[Hop]()
        while source in edges:
            source, hop = edges[source]
            hops.insert(0, hop)
            if len(hops) > len(edges):
                raise FmuError(f"{SSD}: the connections to '{_told(target)}' go round in a circle")
        if source[0] in components or not source[0]:
            yield Route(source, units.get(source, ""), target, tuple(hops))


def _told(end: End) -> str:
    return f"{end[0]}.{end[1]}" if end[0] else end[1]


@dataclass(frozen=True)
class _Bindings:
    """Reads parameter sets and what they mean for the components."""

    archive: zipfile.ZipFile
    edges: Edges
    components: frozenset[str]
    units: tuple[FmuUnit, ...]

    def read(self, system: Part) -> tuple[list[Value], list[str]]:
        """Return values, those that count last, and notes on names that nothing has."""
        values, notes = list[Value](), list[str]()
        for part in system.walk():
            for node in children(part.node, "ParameterBindings", "ParameterBinding"):
                place = f"parameters of {part.path or 'the system'}"
                mapped = self._mapping(node, place)
                for name, value, unit, said_by in self._set(node, place):
                    for target, hop in mapped.get(name, [(name, Hop(""))]):
                        ends = list(self._resolved(part, target, hop))
                        values += [Value(end, value, unit, hops, said_by) for end, hops in ends]
                        if not ends:
                            notes.append(
                                f"{said_by}: no {target!r} in the system; its value is not used"
                            )
        return values, notes

    def _set(self, node: Element, place: str) -> Iterator[tuple[str, object, FmuUnit, str]]:
        """Yield name, value and unit of each parameter of a binding."""
        found, where = self._document(node, "ParameterValues", "ParameterSet", place)
        units = (*units_in(found), *self.units)
        prefix = node.get("prefix", "")
        for element in children(found, "Parameters", "Parameter"):
            name = prefix + Attributes(element, where).text("name")
            said_by = f"{where}: parameter {name!r}"
            typed = next((child for child in element if child.tag != "Annotations"), None)
            if typed is None:
                raise FmuError(f"{said_by} has no value; export the system again")
            unit = unit_of(typed.get("unit", ""), units)
            yield name, _value(typed, said_by), unit, said_by

    def _mapping(self, node: Element, place: str) -> dict[str, list[tuple[str, Hop]]]:
        """Return targets by source; names that are not mapped stand for themselves."""
        inner = node.find("ParameterMapping")
        if inner is None:
            return {}
        found, where = self._document(inner, "", "ParameterMapping", place)
        mapped: dict[str, list[tuple[str, Hop]]] = {}
        for element in found.findall("MappingEntry"):
            said = Attributes(element, f"{where}: MappingEntry")
            name = said.text("source")
            hop = hop_of(element, "", f"{where}: mapping of {name!r}")
            mapped.setdefault(name, []).append((said.text("target"), hop))
        return mapped

    def _document(self, node: Element, group: str, root: str, place: str) -> tuple[Element, str]:
        """Return what a node holds within, or names as its source, and where it stands."""
        source = node.get("source", "")
        if node.get("sourceBase", "SSD") != "SSD":
            raise FmuError(
                f"{place}: source {source!r} inside the component, which is not supported; put it "
                "into the archive's resources"
            )
        if source:
            entry = entry_of(self.archive, source, place)
            return xml_of(self.archive, entry, root), entry
        found = node.find(f"{group}/{root}" if group else root)
        if found is None:
            raise FmuError(f"{place}: neither a source nor a {root}; export the system again")
        return found, place

    def _resolved(self, part: Part, name: str, hop: Hop) -> Iterator[tuple[End, tuple[Hop, ...]]]:
        """Yield the variables of components that a name of a part stands for."""
        here = replace(hop, unit=part.units.get(name, ""))
        if part.parts is None:
            yield (part.path, name), (here,)
        elif name in part.kinds:
            yield from self._fed_by((part.path, name), (here,))
        else:
            inner = [own for own in part.parts if name.startswith(f"{own}.")]
            if inner:
                own = max(inner, key=len)
                yield from self._resolved(part.parts[own], name[len(own) + 1 :], hop)

    def _fed_by(self, end: End, hops: tuple[Hop, ...]) -> Iterator[tuple[End, tuple[Hop, ...]]]:
        if len(hops) > len(self.edges) + 1:
            raise FmuError(f"{SSD}: the connections of '{_told(end)}' go round in a circle")
        for target, (source, hop) in self.edges.items():
            if source == end:
                if target[0] in self.components:
                    yield target, (*hops, hop)
                else:
                    yield from self._fed_by(target, (*hops, hop))


def _value(typed: Element, place: str) -> object:
    text = Attributes(typed, place).text("value")
    if typed.tag in _FLOATS:
        return to_float(text, place)
    if typed.tag in _TEXTS:
        return text
    if typed.tag == "Binary":
        return _bytes(text, place)
    if typed.tag == "Boolean":
        return to_bool(text, place)
    if typed.tag == "Integer" or "Int" in typed.tag:
        return to_int(text, place)
    raise FmuError(f"{place} is of type {typed.tag}, which is not supported: leave it out")


def _bytes(text: str, place: str) -> bytes:
    try:
        return bytes.fromhex(text)
    except ValueError:
        raise FmuError(f"{place} = {text!r}: expected hexadecimal digits, two a byte") from None
