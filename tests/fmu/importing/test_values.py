"""Values of every type by name: arrays, elements, aliases, enumerations, strings, bytes."""

from dataclasses import replace

import numpy as np
import pytest
from handmade_fmus import Model, description, fmu

from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu
from jounce.fmu.importing.reading import inspect_fmu

pytestmark = pytest.mark.usefixtures("nothing_left")

VARIABLES = """
<Float64 name="u" valueReference="0" causality="input" start="1 2">
  <Dimension start="2"/><Alias name="force" description="the same"/></Float64>
<Enumeration name="gear" declaredType="Gear" valueReference="2" causality="input" start="1"/>
<Float64 name="y" valueReference="100" causality="output"><Alias name="sum"/></Float64>
<Enumeration name="engaged" declaredType="Gear" valueReference="101" causality="output"/>
<UInt64 name="n" valueReference="7" causality="structuralParameter" start="3"/>
<Float64 name="A" valueReference="200" causality="parameter" variability="tunable"
  start="11 12 13 21 22 23"><Dimension start="2"/><Dimension valueReference="7"/>
  <Alias name="matrix"/></Float64>
<Enumeration name="mode" declaredType="Gear" valueReference="206" causality="parameter"
  variability="tunable" start="2"/>
<Boolean name="flags" valueReference="207" causality="parameter" variability="tunable"
  start="true false"><Dimension start="2"/></Boolean>
<Int64 name="big" valueReference="999" causality="parameter" variability="tunable" start="0"/>
<String name="title" valueReference="1000" causality="parameter" variability="tunable">
  <Start value="none"/></String>
<String name="lines" valueReference="1001" causality="parameter" variability="tunable">
  <Dimension start="2"/><Start value="a"/><Start value="b c"/></String>
<Binary name="blob" valueReference="1002" causality="input"><Start value="00ff"/></Binary>
<Binary name="echo" valueReference="1003" causality="output"/>
<Clock name="tick" valueReference="1004" causality="input" intervalVariability="constant"/>
"""
TYPES = """
<TypeDefinitions><EnumerationType name="Gear"><Item name="park" value="1"/>
<Item name="drive slowly" value="2"/><Item name="reverse" value="-5"/></EnumerationType>
</TypeDefinitions><ModelVariables>
"""
CODE = r"""
GET(fmi3Int64, Many) SET(fmi3Int64, Many)
static fmi3Int64 big;
fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                        fmi3Int64 out[], size_t m) {
    if (v[0] == 999) { out[0] = big; return fmi3OK; }
    return fmi3GetMany(c, v, n, out, m);
}
fmi3Status fmi3SetInt64(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                        const fmi3Int64 in[], size_t m) {
    if (v[0] == 999) { big = in[0]; return fmi3OK; }
    return fmi3SetMany(c, v, n, in, m);
}
fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                         fmi3UInt64 out[], size_t m) {
    out[0] = 3;
    return fmi3OK;
}
static char text[2][99], bytes[99];
static size_t size;
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                         const fmi3String in[], size_t m) {
    for (size_t i = 0; i < m; i++) strcpy(text[i], in[i]);
    return fmi3OK;
}
fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                         fmi3String out[], size_t m) {
    for (size_t i = 0; i < m; i++) out[i] = text[i];
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                         const size_t sizes[], const fmi3Binary in[], size_t m) {
    size = sizes[0];
    memcpy(bytes, in[0], size);
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference v[], size_t n,
                         size_t sizes[], fmi3Binary out[], size_t m) {
    sizes[0] = size;
    out[0] = (fmi3Binary)bytes;
    return fmi3OK;
}
"""


def described(model, variables, types=""):
    """Return a model with these ModelVariables in its FMI 3.0 description."""
    text = description(model, "3.0")
    start, end = text.index("<ModelVariables>"), text.index("</ModelVariables>")
    changes = [(text[start:end], (types or "<ModelVariables>") + variables)]
    if model.outputs == ():
        return replace(model, xml=tuple(changes))
    structure = text[text.index("<ModelStructure>") : text.index("</ModelStructure>")]
    return replace(model, xml=(*changes, (structure, "<ModelStructure>")))


EVERYTHING = described(
    Model(
        "everything",
        inputs=("u1", "u2", "gear"),
        outputs=("y", "engaged"),
        parameters={f"p{i}": float(x) for i, x in enumerate([11, 12, 13, 21, 22, 23, 2, 1, 0])},
        step="y[0] = p[0] * u[0] + p[5] * u[1]; y[1] = u[2];",
        epilogue=CODE,
    ),
    VARIABLES,
    TYPES,
)
A = np.array([[11.0, 12.0, 13.0], [21.0, 22.0, 23.0]])


@pytest.fixture
def path(tmp_path):
    return fmu(tmp_path, EVERYTHING, "3.0")


def test_what_the_description_says(path):
    says = inspect_fmu(path)
    assert says.variable("mode").items == (("park", 1), ("drive slowly", 2), ("reverse", -5))
    assert says.variable("u").aliases == ("force",)
    assert says.variable("force") is says.variable("force[2]") is says.variable("u")
    assert says.element("matrix[2, 1]") == (says.variable("A"), 3)
    assert says.variable("A").shape == (2, 3)
    assert says.variable("blob").start == b"\x00\xff"
    assert says.variable("lines").start == ("a", "b c")
    text = str(says)
    assert "Enumeration (park = 1, drive slowly = 2, reverse = -5)" in text
    assert "(also force)" in text


@pytest.mark.parametrize(
    "name", ["A[0,1]", "A[3,1]", "A[1]", "A[1,2,1]", "A[x,1]", "A[]", "A[-1,1]"]
)
def test_elements_that_an_array_does_not_have(path, name):
    with pytest.raises(FmuError, match=r"the array has 2×3 values, counted from 1"):
        inspect_fmu(path).variable(name)


def test_names_that_nothing_has(path):
    for name in ("A[1,1", "y[1]", "Anna", ""):
        with pytest.raises(FmuError, match="has no variable"):
            inspect_fmu(path).variable(name)
    with load_fmu(path) as block, pytest.raises(FmuError, match=r"no input 'u\[3\]'"):
        block.step({"u[3]": 1.0})


def test_arrays_by_shape_and_by_element(path):
    with load_fmu(path) as block:
        np.testing.assert_array_equal(block.get("A"), A)
        np.testing.assert_array_equal(block.get("matrix"), A)
        assert [block.get(n) for n in ("A[1,3]", "A[2,1]", "matrix[2, 3]")] == [13.0, 21.0, 23.0]
        block.set("A", 10.0 * A)
        np.testing.assert_array_equal(block.get("A"), 10.0 * A)
        block.set("A", list(range(6)))
        np.testing.assert_array_equal(block.get("A"), [[0, 1, 2], [3, 4, 5]])
        block.set("A[2,1]", -3)
        block.set("matrix[1,2]", np.float32(0.5))
        np.testing.assert_array_equal(block.get("A"), [[0, 0.5, 2], [-3, 4, 5]])
        assert block.get("flags").tolist() == [True, False]
        assert block.get("flags").dtype == bool
        assert block.get("flags[1]") is True
        block.set("flags[2]", True)
        assert block.get("flags").tolist() == [True, True]
        for wrong in (A.T, A[0], 1.0, [[1, 2, 3]]):
            with pytest.raises(
                FmuError, match=r"expected \(2, 3\), or all its 6 values in one row"
            ):
                block.set("A", wrong)
        with pytest.raises(TypeError, match=r"an array of shape \(2, 3\), each a number"):
            block.set("A", [[1, 2, 3], [1, 2, "3"]])


def test_arrays_among_the_parameters(path):
    given = {"A[2,3]": 5.0, "matrix[1,1]": 2.0, "flags": [0, 1]}
    with load_fmu(path, parameters=given) as block:
        np.testing.assert_array_equal(block.get("A"), [[2, 12, 13], [21, 22, 5]])
        assert block.parameters["flags"].tolist() == [False, True]
        block.reset({"A": A + 1, "A[1,1]": 0.0})
        np.testing.assert_array_equal(block.get("A"), [[0, 13, 14], [22, 23, 24]])
    with load_fmu(path, parameters={"u": [3.0, 4.0], "force[1]": 5.0}) as block:
        assert block.inputs.tolist() == [5.0, 4.0, 1.0]


def test_inputs_by_every_name(path):
    with load_fmu(path) as block:
        assert block.input_names == ("u[1]", "u[2]", "gear")
        assert block.output_names == ("y", "engaged")
        assert block.inputs.tolist() == [1.0, 2.0, 1.0]
        assert block.step({"u": [1.0, 0.0]})[0] == 11.0
        assert block.step({"force[2]": 2.0})[0] == 11.0 + 2 * 23.0
        assert block.step({"force": np.zeros(2), "u[1]": 3.0, "gear": "reverse"}).tolist() == [
            33.0,
            -5.0,
        ]
        assert block.step([1.0, 1.0, "drive slowly"]).tolist() == [34.0, 2.0]
        assert block.step({"gear": 1}).tolist() == [34.0, 1.0]
        with pytest.raises(FmuError, match=r"gear has no item 'revers': did you mean 'reverse'"):
            block.step({"gear": "revers"})
        for none in (7, 1.5, 0):
            with pytest.raises(FmuError, match=r"gear = .*: expected one of 'park' \(1\), 'drive"):
                block.step({"gear": none})
        assert block.step().tolist() == [34.0, 1.0]
        with pytest.raises(FmuError, match=r"u of shape \(3,\): expected \(2,\)"):
            block.step({"u": [1.0, 2.0, 3.0]})


def test_enumerations_by_name(path):
    with load_fmu(path, parameters={"mode": "reverse"}) as block:
        assert block.get("mode") == -5
        block.set("mode", "park")
        assert block.get("mode") == 1
        block.set("mode", 2)
        assert block.get("mode") == 2
        with pytest.raises(FmuError, match="mode has no item 'Park': did you mean 'park'"):
            block.set("mode", "Park")
        with pytest.raises(FmuError, match=r"mode = 3: expected one of 'park' \(1\), 'drive slo"):
            block.set("mode", 3)


def test_integers_are_exact(path):
    with load_fmu(path, parameters={"big": 2**63 - 1}) as block:
        assert block.get("big") == 2**63 - 1
        block.set("big", np.int64(2**53 + 1))
        assert block.get("big") == 2**53 + 1
        block.set("big", 3.0)
        assert (block.get("big"), type(block.get("big"))) == (3, int)
        with pytest.raises(
            FmuError, match=r"big = 9223372036854775808: expected whole num.* -9223372036854"
        ):
            block.set("big", 2**63)
        for odd in (0.5, np.inf, np.nan):
            with pytest.raises(FmuError, match="expected a whole number"):
                block.set("big", odd)


def test_texts(path):
    with load_fmu(path, parameters={"title": "Grüße"}) as block:
        assert block.get("title") == "Grüße"
        block.set("lines", ["x", "y z"])
        assert block.get("lines").tolist() == ["x", "y z"]
        assert block.get("lines[2]") == "y z"
        for wrong in (1.0, b"x", "a\0b", None):
            with pytest.raises(TypeError, match=r"title = .*: expected a string"):
                block.set("title", wrong)


def test_binaries(path):
    with load_fmu(path, parameters={"blob": b"\0\1\0"}) as block:
        assert block.get("blob") == block.get("echo") == b"\0\1\0"
        block.set("blob", bytearray(b"abc\0"))
        assert block.get("echo") == b"abc\0"
        block.set("blob", b"")
        assert block.get("echo") == b""
        with pytest.raises(FmuError, match=r"input 'blob' is of type Binary.* give it to `set`"):
            block.step({"blob": b"a"})
        with pytest.raises(TypeError, match="blob = 'abc': expected bytes"):
            block.set("blob", "abc")


def test_a_clock_disturbs_nothing(path):
    with load_fmu(path) as block:
        assert "tick" not in block.input_names
        for use in (lambda: block.get("tick"), lambda: block.set("tick", True)):
            with pytest.raises(FmuError, match="'tick' is of type Clock"):
                use()


def test_what_is_no_number(path):
    with load_fmu(path) as block:
        for odd in (None, 1j, np.timedelta64(3, "s"), np.datetime64(3, "s"), [1.0], {}, "1"):
            with pytest.raises(TypeError, match=r"A\[1,1\]|A = "):
                block.set("A[1,1]", odd)
        for odd in (np.ma.array(A, mask=A > 12), A.astype(complex), A.astype("m8[s]")):
            with pytest.raises(TypeError, match=r"A = .*expected an array of shape"):
                block.set("A", odd)


def test_enumerations_of_fmi2(tmp_path):
    model = Model(
        "switch",
        parameters={"mode": 1.0},
        types={"mode": "Int32"},
        step="y[0] = p[0] * u[0];",
        xml=(
            ('<Integer start="1"/>', '<Enumeration declaredType="Mode" start="1"/>'),
            (
                "<ModelVariables>",
                '<TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="off" value="0"/>'
                '<Item name="on" value="7"/></Enumeration></SimpleType></TypeDefinitions>'
                "<ModelVariables>",
            ),
        ),
    )
    with load_fmu(fmu(tmp_path, model), parameters={"mode": "on"}) as block:
        assert block.description.variable("mode").items == (("off", 0), ("on", 7))
        assert block.get("mode") == 7
        assert block.step([2.0]).tolist() == [14.0]
        block.set("mode", "off")
        assert block.step([2.0]).tolist() == [0.0]
