"""What `inspect_fmu` reads, against FMPy's own reader, and descriptions that it refuses."""

from dataclasses import replace

import fmpy
import pytest
from handmade_fmus import INERTIA, PD, PLATFORM, TOKEN, Model, archive, description, fmu, sha256

from jounce.fmu.importing.description import FmuError, FmuUnit, Unknown
from jounce.fmu.importing.load import load_fmu
from jounce.fmu.importing.reading import inspect_fmu

VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])


def xml_only(folder, text):
    return archive(folder / "x.fmu", [("modelDescription.xml", text.encode())])


def changed(version, *changes, model=INERTIA):
    return description(replace(model, xml=tuple(changes)), version)


@VERSIONS
@pytest.mark.parametrize("model", [INERTIA, PD], ids=lambda model: model.name)
def test_it_says_what_fmpy_reads(tmp_path, version, model):
    path = fmu(tmp_path, model, version)
    ours, theirs = inspect_fmu(path), fmpy.read_model_description(str(path), validate=False)
    assert ours.fmi_version == theirs.fmiVersion == version
    assert ours.model_name == theirs.modelName
    assert ours.token == (theirs.guid or theirs.instantiationToken) == TOKEN
    assert ours.model_identifier == theirs.coSimulation.modelIdentifier
    assert ours.generation_tool == theirs.generationTool
    assert ours.kinds == ("co-simulation",)
    assert [(v.name, v.value_reference, v.type) for v in ours.variables] == [
        (v.name, v.valueReference, v.type) for v in theirs.modelVariables
    ]
    assert [(v.causality, v.variability) for v in ours.variables] == [
        (v.causality, v.variability) for v in theirs.modelVariables
    ]
    assert [v.start for v in ours.variables] == [
        None if v.start is None else float(v.start) for v in theirs.modelVariables
    ]
    assert [u.name for u in ours.outputs] == [u.variable.name for u in theirs.outputs]
    assert [u.name for u in ours.derivatives] == [u.variable.name for u in theirs.derivatives]
    assert ours.default_experiment.step_size == float(theirs.defaultExperiment.stepSize)
    can = ours.capabilities
    assert can.can_get_and_set_state == theirs.coSimulation.canGetAndSetFMUstate
    assert (
        can.can_handle_variable_step == theirs.coSimulation.canHandleVariableCommunicationStepSize
    )
    assert can.provides_directional_derivatives == bool(model.derivatives_code)
    assert ours.platforms == (PLATFORM[version],)
    assert ours.has_sources
    assert ours.sha256 == sha256(path)


@VERSIONS
def test_states_of_derivatives(tmp_path, version):
    says = inspect_fmu(fmu(tmp_path, version=version))
    assert [says.variable(u.name).derivative_of for u in says.derivatives] == ["x0", "x1"]


def test_units_types_dependencies_of_fmi2(tmp_path):
    types = (
        '<UnitDefinitions><Unit name="deg/s"><BaseUnit rad="1" s="-1" factor="0.0174"/></Unit>'
        '<Unit name="x"/></UnitDefinitions><TypeDefinitions><SimpleType name="Rate">'
        '<Real unit="deg/s" min="-3" max="INF" nominal="2"/></SimpleType></TypeDefinitions>'
    )
    text = changed(
        "2.0",
        ("<DefaultExperiment", f"{types}<DefaultExperiment"),
        ('<Real start="0.0"/>', '<Real declaredType="Rate" max="5" start="0.5"/>'),
        ('name="u"', 'name="u" description="torque &amp; more"'),
        ('<Unknown index="2"/>', '<Unknown index="2" dependencies="1 4"/>'),
        ('<Unknown index="3"/>', '<Unknown index="3" dependencies=""/>'),
    )
    says = inspect_fmu(xml_only(tmp_path, text))
    torque = says.variable("u")
    assert (torque.unit, torque.min, torque.max, torque.nominal) == ("deg/s", -3.0, 5.0, 2.0)
    assert (torque.start, torque.description) == (0.5, "torque & more")
    assert says.units == (FmuUnit("deg/s", (("s", -1), ("rad", 1)), 0.0174), FmuUnit("x"))
    assert says.outputs == (Unknown("y", ("u", "J")), Unknown("y_rate", ()))
    assert says.platforms == ()
    assert "u [deg/s] = 0.5 (-3 to 5) – torque & more" in str(says)
    assert "no binary, no sources" in str(says)


def test_arrays_types_and_defaults_of_fmi3(tmp_path):
    extra = (
        '<Float64 name="w" valueReference="7" causality="input" start="1 2 3 4 5 6">'
        '<Dimension start="2"/><Dimension valueReference="8"/></Float64>'
        '<UInt64 name="n" valueReference="8" causality="structuralParameter" start="3"/>'
        '<Boolean name="b" valueReference="9" start="true"/>'
        '<String name="s" valueReference="10"><Start value="a b"/></String>'
        '<Float64 name="p" valueReference="11" causality="parameter" start="INF"/>'
        '<Clock name="c" valueReference="12" causality="input" intervalVariability="constant"/>'
        "</ModelVariables>"
    )
    text = changed("3.0", ("</ModelVariables>", extra))
    says = inspect_fmu(xml_only(tmp_path, text))
    w = says.variable("w")
    assert (w.shape, w.start) == ((2, 3), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    assert w.labels == ("w[1,1]", "w[1,2]", "w[1,3]", "w[2,1]", "w[2,2]", "w[2,3]")
    assert [says.variable(n).start for n in "nbsp"] == [3, True, "a b", float("inf")]
    assert [says.variable(n).variability for n in "wnbsp"] == [
        "continuous", "fixed", "discrete", "discrete", "fixed",
    ]  # fmt: skip


def test_aliases_may_share_a_reference_in_fmi2_only(tmp_path):
    two = inspect_fmu(
        xml_only(tmp_path, changed("2.0", ('valueReference="101"', 'valueReference="100"')))
    )
    assert two.variable("y").value_reference == two.variable("y_rate").value_reference
    text = changed(
        "3.0", ('name="y_rate" valueReference="101"', 'name="y_rate" valueReference="100"')
    )
    with pytest.raises(FmuError, match="share the value reference 100"):
        inspect_fmu(xml_only(tmp_path, text))


REFUSED = [
        (('modelIdentifier="plant"', 'modelIdentifier="../../../x/outside"'), "C identifier"),
        (('modelIdentifier="plant"', 'modelIdentifier="a b"'), "C identifier"),
        (('modelIdentifier="plant"', 'modelIdentifier=""'), "C identifier"),
        (('modelIdentifier="plant"', 'modelIdentifier="plänt"'), "C identifier"),
        (('modelIdentifier="plant"', ""), "no modelIdentifier"),
        (("fmiVersion=", "x="), "expected 2.0 or 3.0"),
        (("fmiModelDescription", "modelDescription"), "expected fmiModelDescription"),
        (("<CoSimulation", "<Something"), "neither CoSimulation nor"),
        (('modelName="plant"', ""), "no modelName"),
        ((f'"{TOKEN}"', '"&boom;"'), "not well-formed"),
        (('name="y_rate"', 'name="y"'), "two variables 'y'"),
        (('name="y_rate"', ""), "no name|not well-formed"),
        (('valueReference="100"', 'valueReference="-1"'), "expected 0 to"),
        (('valueReference="100"', 'valueReference="4294967296"'), "expected 0 to"),
        (('valueReference="100"', 'valueReference="1e2"'), "expected a whole number"),
        (('start="2.0"', 'start="two"'), "expected a number"),
        (('stepSize="0.001"', 'stepSize="fast"'), "expected a number"),
        (('canHandleVariableCommunicationStepSize="true"',
          'canHandleVariableCommunicationStepSize="yes"'), "expected true or false"),
        (('<?xml version="1.0" encoding="UTF-8"?>', '<?xml version="1.0" encoding="EBCDIC"?>'),
         "not well-formed"),
        (("</fmiModelDescription>", ""), "not well-formed"),
        (("<fmiModelDescription", "<fmiModelDescription>" * 200 + "<fmiModelDescription"),
         "nested deeper"),
    ]  # fmt: skip


@VERSIONS
@pytest.mark.parametrize(
    ("change", "match"),
    REFUSED,
    ids=[f"{i} {case[-1]}" for i, case in enumerate(REFUSED)],
)  # fmt: skip
def test_descriptions_that_are_refused(tmp_path, version, change, match):
    for read in (inspect_fmu, load_fmu):
        with pytest.raises(FmuError, match=match):
            read(xml_only(tmp_path, changed(version, change)))


OUTPUT = '<Float64 name="y" valueReference="100" causality="output" variability="continuous"'
REFUSED_STRUCTURES = [
        (('<Unknown index="2"/>', '<Unknown index="0"/>'), "2.0", "there are 8 variables"),
        (('<Unknown index="2"/>', '<Unknown index="9"/>'), "2.0", "there are 8 variables"),
        (('<Unknown index="2"/>', "<Unknown/>"), "2.0", "no index"),
        (('derivative="5"', 'derivative="99"'), "2.0", "there are 8 variables"),
        (('<Real start="0.0"/>', "<Complex/>"), "2.0", "has no type"),
        (('<Output valueReference="100"/>', '<Output valueReference="99"/>'), "3.0", "no variable"),
        (('derivative="300"', 'derivative="99"'), "3.0", "no variable has this"),
        (('start="2.0"/>', 'start="2.0"><Dimension start="-4"/></Float64>'), "3.0", "expected 0"),
        (('start="2.0"/>', 'start="2.0"><Dimension start="99999999"/></Float64>'), "3.0",
         "expected 0 to"),
        (('start="2.0"/>', 'start="2.0"><Dimension valueReference="77"/></Float64>'), "3.0",
         "expected a whole number"),
        ((f"{OUTPUT}/>", f"{OUTPUT}><Alias/></Float64>"), "3.0", "Alias: no name"),
        ((f"{OUTPUT}/>", f'{OUTPUT}><Alias name="J"/></Float64>'), "3.0", "two variables 'J'"),
        ((f"{OUTPUT}/>", f'{OUTPUT}><Alias name="y"/></Float64>'), "3.0", "two variables 'y'"),
        ((f"{OUTPUT}/>", f'{OUTPUT}/><Binary name="b" valueReference="7"><Start value="0g"/>'
          "</Binary>"), "3.0", "expected hexadecimal digits"),
        (("<ModelVariables>", '<TypeDefinitions><EnumerationType name="E"><Item name="a"/>'
          '</EnumerationType></TypeDefinitions><ModelVariables><Enumeration name="e" '
          'declaredType="E" valueReference="8"/>'), "3.0", "Item of a type: no value"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "version", "match"),
    REFUSED_STRUCTURES,
    ids=[f"{i} {case[-1]}" for i, case in enumerate(REFUSED_STRUCTURES)],
)  # fmt: skip
def test_structures_that_are_refused(tmp_path, change, version, match):
    with pytest.raises(FmuError, match=match):
        inspect_fmu(xml_only(tmp_path, changed(version, change)))


@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>',
        '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE x SYSTEM "http://example.org/x.dtd">',
        "<!DOCTYPE fmiModelDescription>",
    ],
    ids=["bomb", "file", "remote", "plain"],
)
def test_any_doctype_is_refused(tmp_path, doctype):
    text = changed("2.0", ("<fmiModelDescription", f"{doctype}<fmiModelDescription"))
    with pytest.raises(FmuError, match="DOCTYPE"):
        inspect_fmu(xml_only(tmp_path, text))


def test_no_description_at_all(tmp_path):
    inner = [("plant/modelDescription.xml", description(INERTIA, "2.0").encode())]
    with pytest.raises(FmuError, match="not the folder"):
        inspect_fmu(archive(tmp_path / "x.fmu", inner))


def test_text_of_other_encodings(tmp_path):
    text = changed("2.0", ('generationTool="by hand"', 'generationTool="wärmepumpe"'))
    for name in ("UTF-16", "ISO-8859-1"):
        data = text.replace('encoding="UTF-8"', f'encoding="{name}"').encode(name)
        says = inspect_fmu(archive(tmp_path / "x.fmu", [("modelDescription.xml", data)]))
        assert says.generation_tool == "wärmepumpe"


@pytest.mark.parametrize(
    ("tag", "kind"), [("Implementation", "co-simulation"), ("Other", "model exchange")]
)
def test_fmi1_is_told_apart(tmp_path, tag, kind):
    text = changed(
        "2.0",
        ('fmiVersion="2.0"', 'fmiVersion="1.0"'),
        ("<ModelVariables>", f"<{tag}/><ModelVariables>"),
    )
    match = (
        rf"'1\.0'; expected 2\.0 or 3\.0: export this FMI 1\.0 FMU for {kind} again, from by hand, "
        "as one for co-simulation in FMI 2.0 or 3.0"
    )
    for read in (inspect_fmu, load_fmu):
        with pytest.raises(FmuError, match=match):
            read(xml_only(tmp_path, text))


def test_unknown_names_are_answered_with_near_ones(tmp_path):
    says = inspect_fmu(fmu(tmp_path, binary=False))
    with pytest.raises(FmuError, match="did you mean 'y_rate'"):
        says.variable("y_rates")
    with pytest.raises(FmuError, match="expected one of u, y, y_rate"):
        says.variable("zzz")


def test_readable_text_of_many_variables(tmp_path):
    model = Model("many", inputs=tuple(f"u{i}" for i in range(100)))
    text = str(inspect_fmu(fmu(tmp_path, model, binary=False)))
    assert "inputs: 100" in text
    assert "… and 40 more" in text
