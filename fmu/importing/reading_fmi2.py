"""Variables and model structure of an FMI 2.0 modelDescription.xml."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from xml.etree.ElementTree import Element

from .description import FmuError, FmuVariable, Unknown
from .parsing import Attributes, each, enumeration_items, to_bool, to_float, to_int

_TYPES: dict[str, Callable[[str, str], object]] = {
    "Real": to_float,
    "Integer": to_int,
    "Boolean": to_bool,
    "String": lambda text, _: text,
    "Enumeration": to_int,
}


def read_variables_fmi2(root: Element) -> tuple[FmuVariable, ...]:
    """Return the variables, in the order of the file."""
    types = {
        element.get("name", ""): typed
        for element in each(root, "TypeDefinitions")
        for typed in element
        if typed.tag in _TYPES
    }
    found: list[FmuVariable] = []
    derivatives: list[tuple[int, str]] = []
    for i, element in enumerate(each(root, "ModelVariables")):
        variable, of = _variable(element, types)
        found.append(variable)
        if of is not None:
            derivatives.append((i, of))
    for i, text in derivatives:
        of = _by_index(text, found, f"variable {found[i].name!r}: derivative")
        found[i] = replace(found[i], derivative_of=of)
    return tuple(found)


def read_structure_fmi2(
    root: Element, variables: tuple[FmuVariable, ...]
) -> dict[str, tuple[Unknown, ...]]:
    """Return outputs, derivatives and initial unknowns; the file's indices become names."""

    def unknown(element: Element, place: str) -> Unknown:
        index = Attributes(element, place).text("index")
        on = element.get("dependencies")
        return Unknown(
            _by_index(index, variables, f"{place}: index"),
            None
            if on is None
            else tuple(_by_index(i, variables, f"{place}: dependencies") for i in on.split()),
        )

    return {
        name: tuple(
            unknown(e, f"ModelStructure/{tag}") for e in each(root, f"ModelStructure/{tag}")
        )
        for name, tag in (
            ("outputs", "Outputs"),
            ("derivatives", "Derivatives"),
            ("initial_unknowns", "InitialUnknowns"),
        )
    }


def _variable(element: Element, types: dict[str, Element]) -> tuple[FmuVariable, str | None]:
    """Return a variable, and the index of the one whose derivative it is."""
    head = Attributes(element, "ModelVariables")
    name = head.text("name")
    typed = next((child for child in element if child.tag in _TYPES), None)
    place = f"variable {name!r}"
    if typed is None:
        raise FmuError(f"{place} has no type: expected one of {', '.join(_TYPES)}")
    declared = types.get(typed.get("declaredType", ""), typed)
    own = Attributes(typed, place)
    said = Attributes(Element(typed.tag, {**declared.attrib, **typed.attrib}), place)
    start = typed.get("start")
    variable = FmuVariable(
        name,
        Attributes(element, place).reference(),
        typed.tag,
        causality=head.text("causality", "local"),
        variability=head.text("variability", "continuous"),
        initial=head.text("initial", ""),
        start=None if start is None else _TYPES[typed.tag](start, f"{place}: start"),
        min=said.number("min"),
        max=said.number("max"),
        nominal=said.number("nominal"),
        unit=said.text("unit", ""),
        relative=said.flag("relativeQuantity"),
        description=head.text("description", ""),
        items=enumeration_items(declared),
    )
    return variable, own.text("derivative", "") or None


def _by_index(text: str, variables: Sequence[FmuVariable], place: str) -> str:
    index = to_int(text, place)
    if not 1 <= index <= len(variables):
        raise FmuError(
            f"{place} = {text!r}: there are {len(variables)} variables, counted from 1; export "
            "the FMU again"
        )
    return variables[index - 1].name
