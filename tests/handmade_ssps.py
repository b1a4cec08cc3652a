"""Small SSPs written by hand, of FMUs written by hand, and FMUs of which variables have units."""

from dataclasses import replace
from pathlib import Path
from xml.sax.saxutils import quoteattr

from handmade_fmus import FIRST, Model, archive, fmu, variables

ADDER = Model(
    "adder",
    inputs=("u",),
    outputs=("y",),
    parameters={"k": 1.0, "c": 0.0},
    step="y[0] = p[0] * u[0] + p[1];",
    outputs_code="y[0] = p[0] * u[0] + p[1];",
)
"""y = k·u + c, within its step."""

SPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
    )
)


def with_units(model, units, definitions=None):
    """Return a model some of whose variables have units; definitions are attributes by name."""
    defined = "".join(
        f"<Unit name={quoteattr(name)}><BaseUnit {attributes(base)}/></Unit>"
        for name, base in (definitions or {}).items()
    )
    pairs = [("<ModelVariables>", f"<UnitDefinitions>{defined}</UnitDefinitions><ModelVariables>")]
    for name, reference, causality, start in variables(model):
        if name in units:
            given = "" if start is None else f' start="{start!r}"'
            variability = "tunable" if causality == "parameter" else "continuous"
            head = f'valueReference="{reference}" causality="{causality}" variability='
            old = f'{head}"{variability}"><Real{given}'
            pairs.append((old, f"{old} unit={quoteattr(units[name])}"))
    assert FIRST["input"] == 0
    return replace(model, xml=(*model.xml, *pairs))


def attributes(values):
    """Return attributes as XML has them."""
    return " ".join(f"{name}={quoteattr(str(value))}" for name, value in values.items())


def component(name, connectors, inside="", **said):
    """Return an element Component; connectors are (name, kind) or (name, kind, unit)."""
    said = {"name": name, "source": f"resources/{name}.fmu", **said}
    return f"<ssd:Component {attributes(said)}>{listed(connectors)}{inside}</ssd:Component>"


def listed(connectors):
    """Return an element Connectors."""
    made = "".join(
        f"<ssd:Connector {attributes({'name': name, 'kind': kind})}>"
        f"<ssc:Real {attributes({'unit': unit[0]} if unit else {})}/></ssd:Connector>"
        for name, kind, *unit in connectors
    )
    return f"<ssd:Connectors>{made}</ssd:Connectors>" if made else ""


def connection(start, end, inside="", **said):
    """Return an element Connection between "element.connector", or connectors of the system."""
    for role, text in (("start", start), ("end", end)):
        element, _, connector = text.rpartition(".")
        said |= {f"{role}Element": element} if element else {}
        said |= {f"{role}Connector": connector}
    return f"<ssd:Connection {attributes(said)}>{inside}</ssd:Connection>"


def system(elements, connections=(), connectors=(), inside="", name="whole"):
    """Return an element System."""
    linked = f"<ssd:Connections>{''.join(connections)}</ssd:Connections>" if connections else ""
    return (
        f"<ssd:System {attributes({'name': name})}>{listed(connectors)}{inside}"
        f"<ssd:Elements>{''.join(elements)}</ssd:Elements>{linked}</ssd:System>"
    )


def bindings(*made):
    """Return an element ParameterBindings."""
    return f"<ssd:ParameterBindings>{''.join(made)}</ssd:ParameterBindings>"


def binding(values, mapping="", units="", **said):
    """Return an element ParameterBinding with values inline, by name: (type, value, unit)."""
    inline = parameter_set(values, units) if values is not None else ""
    inline = f"<ssd:ParameterValues>{inline}</ssd:ParameterValues>" if inline else ""
    return f"<ssd:ParameterBinding {attributes(said)}>{inline}{mapping}</ssd:ParameterBinding>"


def parameter_set(values, units=""):
    """Return an element ParameterSet."""
    made = "".join(
        f"<ssv:Parameter {attributes({'name': name})}>"
        f"<ssv:{kind} {attributes({'value': value} | ({'unit': unit[0]} if unit else {}))}/>"
        "</ssv:Parameter>"
        for name, (kind, value, *unit) in values.items()
    )
    return (
        f'<ssv:ParameterSet version="1.0" name="set" {SPACES}>'
        f"<ssv:Parameters>{made}</ssv:Parameters>{units}</ssv:ParameterSet>"
    )


def mapping(*entries):
    """Return an element ParameterMapping of (source, target, inside, attributes)."""
    made = "".join(
        f"<ssm:MappingEntry {attributes({'source': source, 'target': target} | said)}>"
        f"{inside}</ssm:MappingEntry>"
        for source, target, inside, said in entries
    )
    return f'<ssm:ParameterMapping version="1.0" {SPACES}>{made}</ssm:ParameterMapping>'


def linear(factor=1.0, offset=0.0):
    """Return an element LinearTransformation."""
    return f"<ssc:LinearTransformation {attributes({'factor': factor, 'offset': offset})}/>"


def units(**definitions):
    """Return an element Units."""
    made = "".join(
        f"<ssc:Unit name={quoteattr(name)}><ssc:BaseUnit {attributes(base)}/></ssc:Unit>"
        for name, base in definitions.items()
    )
    return f"<ssd:Units>{made}</ssd:Units>"


def ssp(folder, top, models, *, after="", extra=(), name="system.ssp", version="2.0"):
    """Write an SSP of a top-level system into a folder, and return its path."""
    text = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription version="1.0" '
        f'name="made" {SPACES}>{top}{after}</ssd:SystemStructureDescription>'
    )
    entries = [("SystemStructure.ssd", text.encode())]
    for own, model in models.items():
        made = fmu(folder, model, version, name=f"{own}.part")
        entries.append((f"resources/{own}.fmu", Path(made).read_bytes()))
        Path(made).unlink()
    return archive(Path(folder) / name, [*entries, *extra])
