"""XML from strangers as a tree: no DOCTYPE, no entities, bounded depth and size."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from .description import FmuError

MAX_XML_BYTES = 2**26
"""Bytes of a modelDescription.xml."""
MAX_ELEMENTS = 1_000_000
"""Elements of a modelDescription.xml."""
MAX_DEPTH = 100
"""Depth to which elements may be nested."""

_TRUTH = {"true": True, "1": True, "false": False, "0": False}


def parse_xml(text: bytes, name: str) -> Element:
    """Return the root of an XML text.

    Raises
    ------
    FmuError
        For text that is not well-formed, a document type (which alone could define entities),
        or more elements or deeper ones than an FMU needs. The message begins with `name`.
    """
    builder = TreeBuilder()
    depth = count = 0

    def refuse(*_: object) -> NoReturn:
        raise FmuError(
            f"{name} has a DOCTYPE: FMI knows none, and entities can fill the memory or read other "
            "files; do not trust this file"
        )

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth += 1
        count += 1
        if depth > MAX_DEPTH or count > MAX_ELEMENTS:
            raise FmuError(
                f"{name}: more than {MAX_ELEMENTS} elements, or nested deeper than {MAX_DEPTH}; "
                "export the FMU with fewer variables"
            )
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text, True)
        return builder.close()
    except FmuError:
        raise
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise FmuError(f"{name} is not well-formed XML: {error}; export the FMU again") from None


class Attributes:
    """The attributes of one element, each asked for as the type that it must have.

    `place` begins every error.
    """

    def __init__(self, element: Element, place: str) -> None:
        self._values = element.attrib
        self._place = place

    def text(self, name: str, default: str | None = None) -> str:
        """Return an attribute as it stands; without a default it must be there."""
        value = self._values.get(name, default)
        if value is None:
            raise FmuError(f"{self._place}: no {name}; export the FMU again")
        return value

    def number(self, name: str) -> float | None:
        """Return an attribute as a float, or None where there is none."""
        text = self._values.get(name)
        return None if text is None else to_float(text, f"{self._place}: {name}")

    def whole(self, name: str, default: int | None = None) -> int:
        """Return an attribute as an int; without a default it must be there."""
        text = self._values.get(name)
        if text is None and default is not None:
            return default
        return to_int(self.text(name), f"{self._place}: {name}")

    def reference(self) -> int:
        """Return the valueReference, a whole number of 32 bits."""
        value = self.whole("valueReference")
        if not 0 <= value < 2**32:
            raise FmuError(
                f"{self._place}: valueReference = {value}: expected 0 to 2³² − 1; export the FMU "
                "again"
            )
        return value

    def flag(self, name: str) -> bool:
        """Return an attribute as a bool, False where there is none."""
        return to_bool(self._values.get(name, "false"), f"{self._place}: {name}")


def to_float(text: str, place: str) -> float:
    """Return the number that XML text gives; FmuError, begun by `place`, where it gives none."""
    try:
        return float(text)
    except ValueError:
        raise FmuError(f"{place} = {text!r}: expected a number; export the FMU again") from None


def to_int(text: str, place: str) -> int:
    """Return the whole number that XML text gives, as `to_float` does."""
    try:
        return int(text)
    except ValueError:
        raise FmuError(
            f"{place} = {text[:40]!r}: expected a whole number; export the FMU again"
        ) from None


def to_bool(text: str, place: str) -> bool:
    """Return the truth value that XML text gives, as `to_float` does."""
    value = _TRUTH.get(text.strip())
    if value is None:
        raise FmuError(f"{place} = {text!r}: expected true or false; export the FMU again")
    return value


def to_bytes(text: str, place: str) -> bytes:
    """Return the bytes that XML text gives in hexadecimal digits, as `to_float` does."""
    try:
        return bytes.fromhex(text)
    except ValueError:
        raise FmuError(
            f"{place} = {text[:40]!r}: expected hexadecimal digits; export the FMU again"
        ) from None


def each(root: Element, path: str) -> Iterator[Element]:
    """Yield the children of a child of the root: those of `path`, whatever their tags."""
    parent = root.find(path)
    if parent is not None:
        yield from parent


def enumeration_items(declared: Element) -> tuple[tuple[str, int], ...]:
    """Return name and value of each item of an enumeration's type."""
    items = [Attributes(child, "Item of a type") for child in declared if child.tag == "Item"]
    return tuple((item.text("name"), item.whole("value")) for item in items)
