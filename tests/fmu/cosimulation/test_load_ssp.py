"""SSP files in: what they connect and set against sums done by hand, and what is refused."""

import re
import zipfile
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from handmade_fmus import INERTIA, sha256
from handmade_ssps import (
    ADDER,
    binding,
    bindings,
    component,
    connection,
    linear,
    mapping,
    parameter_set,
    ssp,
    system,
    units,
    with_units,
)

from jounce.fmu import load_ssp
from jounce.fmu.cosimulation.ssp_reading import read_ssp
from jounce.fmu.importing.description import FmuError

DT = 0.125
ENDS = (("u", "input"), ("y", "output"))
DEG = {"rad": 1, "factor": repr(pi / 180.0)}
EXPERIMENT = '<ssd:DefaultExperiment startTime="0" stopTime="1"/>'

pytestmark = pytest.mark.usefixtures("nothing_left")


def adder(name, **options):
    return replace(ADDER, name=name, step_size=DT, **options)


def chain(folder, *made, inside="", outer="", connectors=(), more=(), version="2.0", **options):
    """Write a -> b, both y = k·u + c, with connections `made` and parameter bindings."""
    top = system(
        [component("a", ENDS, inside), component("b", ENDS)],
        [*(made or (connection("a.y", "b.u"),)), *more],
        connectors,
        outer,
    )
    models = {"a": adder("a"), "b": adder("b"), **options.pop("models", {})}
    return ssp(folder, top, models, after=EXPERIMENT, version=version, **options)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_components_run_connected(tmp_path, version):
    with load_ssp(chain(tmp_path, version=version)) as whole:
        assert (whole.name, list(whole.blocks), whole.dt) == ("whole", ["a", "b"], DT)
        assert whole.connections == (("a.y", "b.u"),)
        assert repr(whole) == "<FmuSystem whole: a, b; 1 connections>"
        assert "<th style='text-align:left'>FMU</th>" in whole._repr_html_()
        run = whole.run(inputs={"a.u": lambda t: 1.0 + t})
    assert run.time.tolist() == (DT * np.arange(9)).tolist()
    np.testing.assert_array_equal(run["b.y"][1:], 1.0 + run.time[:-1])
    assert run.order == ("a", "b")


def test_one_fmu_may_be_several_components(tmp_path):
    parts = [component(n, ENDS, source="resources/a.fmu") for n in ("first", "second.stage")]
    top = system(parts, [connection("first.y", "second.stage.u")])
    with load_ssp(ssp(tmp_path, top, {"a": adder("a")}, after=EXPERIMENT)) as whole:
        assert list(whole.blocks) == ["first", "second/stage"]
        run = whole.run(inputs={"first.u": 3.0})
    np.testing.assert_array_equal(run["second/stage.y"][1:], [3.0] * 8)


def test_either_end_may_be_the_start(tmp_path):
    with load_ssp(chain(tmp_path, connection("b.u", "a.y"))) as whole:
        assert whole.connections == (("a.y", "b.u"),)


def test_a_linear_transformation(tmp_path):
    path = chain(tmp_path, connection("a.y", "b.u", linear(-2.5, 0.75)))
    with load_ssp(path) as whole:
        run = whole.run(inputs={"a.u": 4.0})
    np.testing.assert_array_equal(run["b.u"], [-9.25] * 9)


@pytest.mark.parametrize("suppressed", [False, True])
def test_units_are_converted_before_the_transformation(tmp_path, suppressed):
    models = {
        "a": with_units(adder("a"), {"y": "deg"}, {"deg": DEG}),
        "b": with_units(adder("b"), {"u": "rad"}, {"rad": {"rad": 1}}),
    }
    said = {"suppressUnitConversion": "true"} if suppressed else {}
    gain = 1.0 if suppressed else pi / 180.0
    for inside, factor, offset in (("", 1.0, 0.0), (linear(2.0, 0.5), 2.0, 0.5)):
        path = chain(tmp_path, connection("a.y", "b.u", inside, **said), models=models)
        with load_ssp(path) as whole:
            run = whole.run(inputs={"a.u": 90.0})
        np.testing.assert_allclose(run["b.u"], factor * gain * 90.0 + offset, rtol=1e-15)


def test_units_of_the_file_count_where_the_fmus_have_none(tmp_path):
    top = system(
        [
            component("a", (("u", "input"), ("y", "output", "grad"))),
            component("b", (("u", "input", "deg"), ("y", "output"))),
        ],
        [connection("a.y", "b.u")],
    )
    defined = units(grad={"rad": 1, "factor": repr(pi / 200.0)}, deg=DEG)
    path = ssp(tmp_path, top, {"a": adder("a"), "b": adder("b")}, after=defined + EXPERIMENT)
    with load_ssp(path) as whole:
        run = whole.run(inputs={"a.u": 200.0})
    np.testing.assert_allclose(run["b.u"], 180.0, rtol=1e-15)


def test_the_system_has_inputs_and_outputs_of_its_own(tmp_path):
    """Of the system u in deg, of the FMU in rad; twice the result is shown, less one."""
    models = {"a": with_units(adder("a"), {"u": "rad"}, {"rad": {"rad": 1}})}
    path = chain(
        tmp_path,
        connectors=[("angle", "input", "deg"), ("shown", "output"), ("loose", "input")],
        more=[connection("angle", "a.u"), connection("b.y", "shown", linear(2.0, -1.0))],
        models=models,
    )
    with load_ssp(path) as whole:
        run = whole.run(inputs={"angle": ([0.0, 1.0], [0.0, 180.0])})
    np.testing.assert_allclose(run["a.u"][:-1], pi * run.time[:-1], rtol=1e-15)
    np.testing.assert_allclose(run["shown"], 2.0 * run["b.y"] - 1.0, rtol=1e-15)
    np.testing.assert_allclose(run["shown"][1:], 2.0 * pi * run.time[:-1] - 1.0, rtol=1e-14)
    assert run.outputs == ("shown", "a.y", "b.y")
    with load_ssp(path) as whole, pytest.raises(FmuError, match=r"'a\.u' is given twice"):
        whole.run(inputs={"angle": 1.0, "a.u": 1.0})
    with pytest.raises(ValueError, match="read-only"):
        run["shown"][0] = 1.0


def test_systems_in_the_system_are_followed_through(tmp_path):
    inner = system(
        [component("b", ENDS)],
        [connection("in", "b.u", linear(3.0)), connection("b.y", "out", linear(1.0, 1.0))],
        [("in", "input"), ("out", "output")],
        name="sub",
    )
    top = system(
        [component("a", ENDS), inner, component("c", ENDS)],
        [connection("a.y", "sub.in", linear(1.0, 2.0)), connection("c.u", "sub.out")],
    )
    models = {name: adder(name) for name in "abc"}
    with load_ssp(ssp(tmp_path, top, models, after=EXPERIMENT)) as whole:
        assert list(whole.blocks) == ["a", "sub/b", "c"]
        run = whole.run(inputs={"a.u": 5.0})
    np.testing.assert_array_equal(run["sub/b.u"], [21.0] * 9)
    np.testing.assert_array_equal(run["c.u"], [22.0] * 9)


# Parameters


def sets(path):
    """Return the parameters of a chain's FMUs."""
    with load_ssp(path) as whole:
        found = {
            f"{n}.{k}": v for n, fmu in whole.blocks.items() for k, v in fmu.parameters.items()
        }
        return found, whole.notes


def test_parameter_sets_within_and_beside_the_description(tmp_path):
    beside = parameter_set({"b.k": ("Real", 7.0), "b.c": ("Real", -1.5)}).encode()
    path = chain(
        tmp_path,
        inside=bindings(binding({"k": ("Real", 3.0), "c": ("Real", 4.0)})),
        outer=bindings(binding(None, source="resources/own%20set.ssv")),
        extra=[("resources/own set.ssv", beside)],
    )
    assert sets(path) == ({"a.k": 3.0, "a.c": 4.0, "b.k": 7.0, "b.c": -1.5}, ())


def test_the_outer_binding_and_the_later_one_count(tmp_path):
    path = chain(
        tmp_path,
        inside=bindings(binding({"k": ("Real", 3.0)}), binding({"k": ("Real", 4.0)})),
        outer=bindings(
            binding({"k": ("Real", 5.0), "c": ("Real", 6.0)}, prefix="a."),
            binding({"a.c": ("Real", 8.0), "b.k": ("Real", 9.0)}),
        ),
    )
    assert sets(path)[0] == {"a.k": 5.0, "a.c": 8.0, "b.k": 9.0, "b.c": 0.0}


def test_binary_values_are_hexadecimal(tmp_path):
    path = chain(tmp_path, inside=bindings(binding({"k": ("Binary", "00Ff")})))
    with zipfile.ZipFile(path) as archive:
        assert [value.value for value in read_ssp(archive).values] == [b"\x00\xff"]
    with pytest.raises(FmuError, match="hexadecimal digits"):
        load_ssp(chain(tmp_path, inside=bindings(binding({"k": ("Binary", "0g")}))))


def test_names_are_mapped_and_values_transformed(tmp_path):
    renamed = (
        ("stiffness", "a.k", linear(2.0, 1.0), {}),
        ("stiffness", "b.k", "", {}),
    )
    inner = f"<ssd:ParameterMapping>{mapping(*renamed)}</ssd:ParameterMapping>"
    beside = '<ssd:ParameterMapping source="maps/own.ssm"/>'
    values = {"stiffness": ("Real", 10.0), "a.c": ("Integer", 3)}
    for given, extra in ((inner, []), (beside, [("maps/own.ssm", mapping(*renamed).encode())])):
        path = chain(tmp_path, outer=bindings(binding(values, given)), extra=extra)
        assert sets(path)[0] == {"a.k": 21.0, "a.c": 3.0, "b.k": 10.0, "b.c": 0.0}


@pytest.mark.parametrize("suppressed", [False, True])
def test_values_have_units(tmp_path, suppressed):
    models = {"a": with_units(adder("a"), {"k": "rad"}, {"rad": {"rad": 1}})}
    said = {"suppressUnitConversion": "true"} if suppressed else {}
    entry = mapping(("angle", "a.k", linear(2.0), said))
    own = units(turn={"rad": 1, "factor": repr(2.0 * pi)}).replace("ssd:", "ssv:")
    values = binding(
        {"angle": ("Real", 0.5, "turn")},
        f"<ssd:ParameterMapping>{entry}</ssd:ParameterMapping>", own,
    )  # fmt: skip
    found = sets(chain(tmp_path, outer=bindings(values), models=models))[0]
    assert found["a.k"] == pytest.approx(1.0 if suppressed else 2.0 * pi, rel=1e-15)


def test_parameters_of_the_system_reach_what_they_are_connected_to(tmp_path):
    path = chain(
        tmp_path,
        outer=bindings(binding({"gain": ("Real", 6.0), "start": ("Real", 2.0)})),
        connectors=[("gain", "parameter"), ("start", "input")],
        more=[
            connection("gain", "a.k"), connection("gain", "b.k", linear(0.5)),
            connection("start", "a.u"),
        ],
    )  # fmt: skip
    assert sets(path)[0] == {"a.k": 6.0, "a.c": 0.0, "b.k": 3.0, "b.c": 0.0}
    with load_ssp(path, parameters={"gain": 8.0, "b.c": 1.0}) as whole:
        assert whole.blocks["b"].parameters == {"k": 4.0, "c": 1.0}
        np.testing.assert_array_equal(whole.run()["a.y"][1:], 16.0)  # with the start value of u


def test_values_that_nothing_takes_are_told(tmp_path):
    values = {"a.kk": ("Real", 1.0), "z.k": ("Real", 1.0), "b.k": ("Real", 2.0)}
    found, notes = sets(chain(tmp_path, outer=bindings(binding(values))))
    assert found["b.k"] == 2.0
    assert len(notes) == 2
    assert any("'a.kk'" in note and "not used" in note for note in notes)
    assert any("'z.k'" in note for note in notes)


# What is refused


def test_a_pinned_file_is_that_file(tmp_path):
    path = chain(tmp_path)
    load_ssp(path, sha256=sha256(path)).close()
    with pytest.raises(FmuError, match="not the file that was pinned"):
        load_ssp(path, sha256="00")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('source="resources/a.fmu"', 'source="../a.fmu"', ["component 'a'", "'../a.fmu'"]),
        ('source="resources/a.fmu"', 'source="file:///a.fmu"', ["component 'a'", "file:///"]),
        ('source="resources/a.fmu"', 'source="/etc/passwd"', ["component 'a'", "/etc/passwd"]),
        ('source="resources/a.fmu"', 'source="resources/c.fmu"', ["no 'resources/c.fmu'"]),
        ('source="resources/a.fmu"', 'source="SystemStructure.ssd"', ["component 'a'", "SystemS"]),
        ('name="a" source', 'name="a" type="application/x-ssp-package" source', ["x-ssp-package"]),
        ('name="a" source', 'name="a" implementation="ModelExchange" source', ["model exchange"]),
        ('startElement="a"', 'startElement="aa"', ["no element 'aa'", "'a'"]),
        ('startElement="a" ', "", ["no connector 'y'"]),
        ('startConnector="y"', 'startConnector="u"', ["both take one", "'a.u'", "'b.u'"]),
        ('startConnector="y"', 'startConnector="z"', ["no output 'a.z'", "'a.y'"]),
        ("ssd:Component ", "ssd:SignalDictionaryReference ", ["SignalDictionaryReference"]),
        ("ssd:System ", "ssd:Sistem ", ["no System"]),
        ("ssd:SystemStructureDescription", "ssd:Other", ["root 'Other'"]),
        ('name="b"', 'name="a"', ["two elements 'a'"]),
        ('name="a" source', 'name="a-" source', ["no element 'a'"]),
        ("<ssd:Connections>", "<ssd:Connections><bad", ["not well-formed"]),
        ("?>", "?><!DOCTYPE a>", ["DOCTYPE"]),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_a_file_with_an_error_is_refused(tmp_path, old, new, words):
    path = altered(chain(tmp_path), old, new)
    with pytest.raises(FmuError) as caught, load_ssp(path) as whole:
        whole.run()
    assert all(word in str(caught.value) for word in words), caught.value
    assert str(tmp_path / "temporary") not in str(caught.value)


def altered(path, old, new):
    """Return an archive the first entry of which has a text replaced, its other tags closed."""
    changed = path.with_name("changed.ssp")
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(changed, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "SystemStructure.ssd":
                text = data.decode()
                assert old in text
                text = text.replace(old, new)
                if old.startswith("ssd:"):
                    text = text.replace(f"/{old.strip()}>", f"/{new.strip()}>")
                data = text.encode()
            target.writestr(name, data)
    return changed


def test_what_is_not_supported_is_named(tmp_path):
    boolean = '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>'
    cases = [
        ({"made": [connection("a.y", "b.u", f"{boolean}</ssc:BooleanMappingTransformation>")]},
         "BooleanMappingTransformation"),
        ({"made": [connection("a.y", "b.u"), connection("b.y", "b.u")]}, "'b.u' has two sources"),
        ({"outer": bindings(binding(None, source="http://x/p.ssv"))}, "'http://x/p.ssv'"),
        ({"outer": bindings(binding(None, source="p.ssv"))}, "no 'p.ssv'"),
        ({"outer": bindings(binding(None, source="p.ssv", sourceBase="component"))},
         "inside the component"),
        ({"outer": bindings(binding({"a.k": ("Real", "x")}))}, "'x': expected a number"),
        ({"outer": bindings(binding({"a.k": ("Binary", "00")}))}, "type Binary"),
        ({"outer": bindings(binding({"a.k": ("Real", "-2e6")}))}, "component 'a': .*too small"),
    ]  # fmt: skip
    for options, words in cases:
        made = options.pop("made", ())
        with pytest.raises(FmuError, match=words):
            load_ssp(chain(tmp_path, *made, **options))


def test_units_that_cannot_be_converted_are_refused(tmp_path):
    models = {
        "a": with_units(adder("a"), {"y": "m"}),
        "b": with_units(adder("b"), {"u": "N"}),
    }
    with pytest.raises(FmuError, match=r"connection a\.y -> b\.u: m cannot be converted to N"):
        load_ssp(chain(tmp_path, models=models))
    connectors = [component("a", (("y", "output", "mm"),)), component("b", ENDS)]
    top = system(connectors, [connection("a.y", "b.u")])
    with pytest.raises(FmuError, match=r"'a\.y' is in mm in the SSP, in m in its FMU"):
        load_ssp(ssp(tmp_path, top, models))


def test_inputs_parameters_and_times_that_are_refused(tmp_path):
    path = chain(tmp_path)
    for parameters, words in (
        ({"c.k": 1.0}, "parameter 'c.k'"),
        ({"k": 1.0}, "parameter 'k'"),
        ({"a.z": 1.0}, "component 'a': a has no variable 'z'"),
    ):
        with pytest.raises(FmuError, match=re.escape(words)):
            load_ssp(path, parameters=parameters)
    with load_ssp(path) as whole:
        for inputs, words in (
            ({"b.u": 1.0}, "input 'b.u' is connected within whole"),
            ({"a.uu": 1.0}, "no input 'a.uu': did you mean 'a.u'"),
        ):
            with pytest.raises(FmuError, match=re.escape(words)):
                whole.run(inputs=inputs)
        with pytest.raises(FmuError, match=r"0\.3 is 2\.4 steps"):
            whole.run(0.3)
    unsaid = ssp(tmp_path, system([component("plant", ())]), {"plant": replace(INERTIA)})
    with load_ssp(unsaid) as whole, pytest.raises(FmuError, match="whole suggests no stop time"):
        whole.run()


def test_an_archive_that_is_no_ssp(tmp_path):
    path = tmp_path / "empty.ssp"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("a/SystemStructure.ssd", "")
    with pytest.raises(FmuError, match=r"no SystemStructure\.ssd at the top"):
        load_ssp(path)
    path.write_text("no archive")
    with pytest.raises(FmuError, match="zip archive"):
        load_ssp(path)
    with pytest.raises(FileNotFoundError):
        load_ssp(tmp_path / "none.ssp")
