"""What an FMU is told of the run: tolerance, stop time, logging; its step where it names none."""

from dataclasses import replace

import numpy as np
import pytest
from handmade_fmus import INERTIA, Model, fmu

from jounce.fmu import linearize_fmu
from jounce.fmu.importing.description import FmuError
from jounce.fmu.importing.load import load_fmu

pytestmark = pytest.mark.usefixtures("nothing_left")
VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])
TOLD = replace(
    INERTIA,
    name="told",
    outputs=("tolerance", "stop"),
    step="",
    outputs_code="y[0] = x[0]; y[1] = x[1];",
    code=(
        (
            "{ S(c)->t = start; return",
            "{ S(c)->t = start; S(c)->x[0] = d ? tol : -1; S(c)->x[1] = e ? stop : -1; return",
        ),
    ),
)


def with_experiment(model, attributes):
    """Return a model with these attributes of its DefaultExperiment, or without one."""
    new = f"<DefaultExperiment {attributes}/>" if attributes else ""
    return replace(model, xml=(('<DefaultExperiment stepSize="0.001"/>', new),))


@VERSIONS
@pytest.mark.parametrize(
    ("attributes", "asked", "expected"),
    [
        ("", {}, [-1.0, -1.0]),
        ('tolerance="1e-5" stopTime="9"', {}, [1e-5, -1.0]),
        ('tolerance="1e-5" stopTime="9"', {"tolerance": 1e-8, "stop_time": 3}, [1e-8, 3.0]),
        ("", {"tolerance": 1e-3, "stop_time": 2.0, "start_time": 1.0}, [1e-3, 2.0]),
        ('tolerance="0"', {}, [-1.0, -1.0]),
    ],
)
def test_tolerance_and_stop_time(tmp_path, version, attributes, asked, expected):
    path = fmu(tmp_path, with_experiment(TOLD, attributes), version)
    with load_fmu(path, **asked) as block:
        assert block.outputs.tolist() == expected
        block.reset()
        assert block.outputs.tolist() == expected


@pytest.mark.parametrize(
    ("asked", "match"),
    [
        ({"tolerance": 0.0}, "tolerance = 0.0: expected a positive"),
        ({"tolerance": "fine"}, "tolerance = 'fine': expected a number"),
        ({"stop_time": 0.0}, "stop_time = 0.0: expected one after start_time = 0.0"),
        ({"stop_time": np.inf}, "stop_time = inf: expected a finite"),
        ({"start_time": 5.0, "stop_time": 4.0}, "after start_time = 5.0"),
    ],
)
def test_what_is_refused(tmp_path, asked, match):
    with pytest.raises((ValueError, TypeError), match=match):
        load_fmu(fmu(tmp_path), **asked)


@VERSIONS
@pytest.mark.parametrize(
    ("attributes", "asked", "step"),
    [
        ('stepSize="0.25" stopTime="4"', {}, 0.25),
        ('startTime="1" stopTime="5"', {}, 0.004),
        ('stopTime="4"', {"start_time": 1.0, "stop_time": 7.0}, 0.004),
        ('tolerance="1e-4"', {"start_time": 1.0, "stop_time": 7.0}, 0.006),
        ("", {}, 0.001),
        ('stopTime="-2"', {}, 0.001),
        ("", {"dt": 0.5}, 0.5),
    ],
)
def test_the_step_where_none_is_given(tmp_path, version, attributes, asked, step):
    with load_fmu(fmu(tmp_path, with_experiment(INERTIA, attributes), version), **asked) as plant:
        assert plant.dt == step
        start = plant.time
        plant.step([1.0])
        assert plant.time == start + step


def test_the_step_of_a_fixed_inner_one(tmp_path):
    model = with_experiment(INERTIA, 'stopTime="4"')
    fixed = ("<CoSimulation", '<CoSimulation fixedInternalStepSize="0.02"')
    with load_fmu(fmu(tmp_path, replace(model, xml=(*model.xml, fixed)), "3.0")) as plant:
        assert plant.dt == 0.02


def test_a_step_size_that_is_none(tmp_path):
    path = fmu(tmp_path, with_experiment(INERTIA, 'stepSize="0"'))
    with pytest.raises(FmuError, match=r"stepSize of the default experiment = 0\.0: .* a dt"):
        load_fmu(path)
    load_fmu(path, dt=0.1).close()


TALK = {
    "2.0": (
        (
            "    defaults(&i->s);\n    return i;",
            "    defaults(&i->s);\n    for (int k = 0; logging && k < 30; k++)\n"
            '        call->logger(call->componentEnvironment, name, fmi2OK, "logAll", "chat");\n'
            "    return i;",
        ),
    ),
    "3.0": (
        (
            "    defaults(&i->s);\n    return i;",
            "    defaults(&i->s);\n    for (int k = 0; logging && k < 30; k++)\n"
            '        log(env, fmi3OK, "logAll", "chat");\n    return i;',
        ),
    ),
}


@VERSIONS
def test_logging_on_request(tmp_path, version):
    path = fmu(tmp_path, replace(INERTIA, name="talker", code=TALK[version]), version)
    with load_fmu(path) as plant:
        assert plant.messages == ()
    with load_fmu(path, log=True) as plant:
        assert plant.messages == ("chat",) * 30


def test_an_answer_that_is_not_linear_names_the_solver(tmp_path):
    rough = Model(
        "rough", states=1, step="x[0] += h * (u[0] + 1e-3 * u[0] * u[0] * u[0]); y[0] = x[0];"
    )
    match = r"is not linear: .*solver inside .* load_fmu\(…, tolerance="
    with load_fmu(fmu(tmp_path, rough)) as plant, pytest.raises(FmuError, match=match):
        linearize_fmu(plant, horizon=20, amplitude=5.0)


SAYS = """call->logger({environment}, name, fmi2Warning, "warning", {message});"""
ARGUMENTS = {
    "numbers and text": ('"%g and %s", 0.1, "x"', "0.1 and x"),
    "many kinds": (
        '"%d %5.2f|%-4s|%c %u %x %%", -3, 2.0, "ab", (int)\'z\', 7u, 255u',
        "-3  2.00|ab  |z 7 ff %",
    ),
    "long ones": ('"%ld %lld %zu", -5L, 6LL, (size_t)7', "-5 6 7"),
    "none": ('"plain"', "plain"),
    "a lone sign": ('"50 % slower than 10 %"', "50 % slower than 10 %"),
    "one that writes": ('"%s%n", "x", (int *)0', "%s%n"),
    "more than there is room for": ('"%4096d%s", 1, "x"', " " * 4095),
    "sizes as arguments": ('"%*d|%-*s|%.*f", 5, 42, 4, "ab", 2, 3.14159', "42|ab  |3.14"),
    "part of a text": ('"%5.3s|%.2s|%Lg", "abcdef", "xyz", (long double)2.5', "abc|xy|2.5"),
    "no text": ('"%s", (char *)0', "(null)"),
    "text that is nowhere": ('"%s sure", (char *)8', "%s sure"),
    "a width without end": ('"%2147483647d", 1', "%2147483647d"),
    "a precision without end": ('"%.*f", 2147483647, 1.0', "%.*f"),
    "wide text": ('"%ls", (void *)L"wide"', "%ls"),
    "lengths that C does not know": ('"%hg %Ls %lllld %1$d", 1.0', "%hg %Ls %lllld %1$d"),
}


def saying(*messages, environment="call->componentEnvironment"):
    """Return a model of FMI 2.0 that says these when it is instantiated."""
    said = "".join(SAYS.format(environment=environment, message=each) for each in messages)
    start = "    defaults(&i->s);\n    return i;"
    code = ((start, f"    defaults(&i->s);\n    {said}\n    return i;"),)
    return replace(INERTIA, name="talker", code=code)


@pytest.mark.parametrize("isolated", [False, True])
def test_messages_have_their_arguments_filled_in(tmp_path, isolated):
    said, told = zip(*ARGUMENTS.values(), strict=True)
    with load_fmu(fmu(tmp_path, saying(*said)), isolated=isolated) as plant:
        assert dict(zip(ARGUMENTS, plant.messages, strict=True)) == {
            name: text.strip() for name, text in zip(ARGUMENTS, told, strict=True)
        }


@pytest.mark.parametrize("environment", ["0", "i"])
def test_an_fmu_that_loses_its_environment_is_heard(tmp_path, environment):
    path = fmu(tmp_path, saying('"%g", 2.5', environment=environment))
    with load_fmu(fmu(tmp_path, INERTIA)) as other, load_fmu(path) as plant:
        assert (plant.messages, other.messages) == (("2.5",), ())
