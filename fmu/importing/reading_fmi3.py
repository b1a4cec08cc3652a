"""Variables and model structure of an FMI 3.0 modelDescription.xml."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from xml.etree.ElementTree import Element

from .description import FmuError, FmuVariable, Unknown
from .parsing import Attributes, each, enumeration_items, to_bool, to_bytes, to_float, to_int

_INTEGERS = [f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)]
_TYPES: dict[str, Callable[[str, str], object]] = {
    "Float32": to_float,
    "Float64": to_float,
    **dict.fromkeys(_INTEGERS, to_int),
    "Enumeration": to_int,
    "Boolean": to_bool,
    "String": lambda text, _: text,
    "Binary": to_bytes,
    "Clock": lambda text, _: text,
}
_MAX_SIZE = 1_000_000


def read_variables_fmi3(root: Element) -> tuple[FmuVariable, ...]:
    """Return the variables, in the order of the file."""
    types = {
        element.get("name", ""): element
        for element in each(root, "TypeDefinitions")
        if element.tag.endswith("Type")
    }
    elements = [e for e in each(root, "ModelVariables") if e.tag in _TYPES]
    heads = [Attributes(e, f"variable {e.get('name', '')!r}") for e in elements]
    names = {h.reference(): h.text("name") for h in heads}
    sizes = {h.reference(): e.get("start", "") for h, e in zip(heads, elements, strict=True)}
    return tuple(_variable(element, types, names, sizes) for element in elements)


def read_structure_fmi3(
    root: Element, variables: tuple[FmuVariable, ...]
) -> dict[str, tuple[Unknown, ...]]:
    """Return outputs, derivatives and initial unknowns; value references become names."""
    names = {variable.value_reference: variable.name for variable in variables}

    def unknown(element: Element) -> Unknown:
        place = f"ModelStructure/{element.tag}"
        reference = Attributes(element, place).text("valueReference")
        on = element.get("dependencies")
        return Unknown(
            _by_reference(reference, names, f"{place}: valueReference"),
            None
            if on is None
            else tuple(_by_reference(v, names, f"{place}: dependencies") for v in on.split()),
        )

    parts = list(each(root, "ModelStructure"))
    return {
        name: tuple(unknown(element) for element in parts if element.tag == tag)
        for name, tag in (
            ("outputs", "Output"),
            ("derivatives", "ContinuousStateDerivative"),
            ("initial_unknowns", "InitialUnknown"),
        )
    }


def _variable(
    element: Element,
    types: Mapping[str, Element],
    names: Mapping[int, str],
    sizes: Mapping[int, str],
) -> FmuVariable:
    name = element.get("name", "")
    place = f"variable {name!r}"
    declared = types.get(element.get("declaredType", ""), element)
    said = Attributes(element, place)
    typed = Attributes(Element(element.tag, {**declared.attrib, **element.attrib}), place)
    causality = said.text("causality", "local")
    of = element.get("derivative")
    shape = _shape(element, sizes, place)
    return FmuVariable(
        name,
        said.reference(),
        element.tag,
        causality=causality,
        variability=said.text("variability", _variability(element.tag, causality)),
        initial=said.text("initial", ""),
        start=_start(element, shape, place),
        min=typed.number("min"),
        max=typed.number("max"),
        nominal=typed.number("nominal"),
        unit=typed.text("unit", ""),
        relative=typed.flag("relativeQuantity"),
        description=said.text("description", ""),
        shape=shape,
        derivative_of="" if of is None else _by_reference(of, names, f"{place}: derivative"),
        items=enumeration_items(declared),
        aliases=tuple(
            Attributes(child, f"{place}: Alias").text("name")
            for child in element
            if child.tag == "Alias"
        ),
    )


def _variability(kind: str, causality: str) -> str:
    """Return the default of FMI 3.0."""
    if causality.lower().endswith("parameter"):
        return "fixed"
    return "continuous" if kind.startswith("Float") else "discrete"


def _start(element: Element, shape: tuple[int, ...], place: str) -> object:
    if element.tag in ("String", "Binary"):
        words = [child.get("value", "") for child in element if child.tag == "Start"]
    elif shape:
        words = element.get("start", "").split()
    else:
        words = [element.get("start", "")] if "start" in element.attrib else []
    values = tuple(_TYPES[element.tag](word, f"{place}: start") for word in words)
    if not values:
        return None
    return values if shape else values[0]


def _shape(element: Element, sizes: Mapping[int, str], place: str) -> tuple[int, ...]:
    """Return the lengths of an array: given, or the start of a structural parameter."""
    shape: list[int] = []
    total = 1
    for child in element:
        if child.tag != "Dimension":
            continue
        said = Attributes(child, f"{place}: Dimension")
        if "start" in child.attrib:
            length = said.whole("start")
        else:
            reference = said.reference()
            length = to_int(sizes.get(reference, "none"), f"{place}: length of a dimension")
        shape.append(length)
        total *= length
        if length < 0 or total > _MAX_SIZE:
            raise FmuError(f"{place}: {total} values; expected 0 to {_MAX_SIZE}")
    return tuple(shape)


def _by_reference(text: str, names: Mapping[int, str], place: str) -> str:
    reference = to_int(text, place)
    if reference not in names:
        raise FmuError(
            f"{place} = {text!r}: no variable has this value reference; export the FMU again"
        )
    return names[reference]
