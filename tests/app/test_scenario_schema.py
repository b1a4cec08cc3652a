"""The JSON schema of scenario files: shipped as the models give it, right for right files."""

import json
import tomllib
from functools import cache

import pytest
from good_scenario import GOOD, LINEAR, MODES
from toml_values import inline

from jounce.app.scenario import load_scenario
from jounce.app.scenario_messages import EXAMPLES
from jounce.app.scenario_schema import scenario_schema, schema_text, shipped_schema


@pytest.fixture(scope="module")
def jsonschema():
    """Load it in the one worker that needs it: it takes seconds."""
    import jsonschema

    return jsonschema


@cache
def validator(number):
    """Return what holds content against a schema, which is itself checked below."""
    from jsonschema import Draft202012Validator

    return Draft202012Validator(scenario_schema(number))


@pytest.mark.parametrize("number", [1, 2])
def test_the_shipped_file_is_what_the_models_give(jsonschema, number):
    """`schema_text` makes it anew."""
    assert json.loads(shipped_schema(number)) == json.loads(schema_text(number))
    jsonschema.Draft202012Validator.check_schema(scenario_schema(number))


@pytest.mark.parametrize("number", [1, 2])
def test_it_knows_every_key_and_none_besides(number):
    """Those of the example of all keys."""
    schema = scenario_schema(number)
    assert set(schema["properties"]) == set(EXAMPLES[number])
    assert schema["additionalProperties"] is False
    for name in ("plant", "controller", "feedforward"):
        section = schema["$defs"][schema["properties"][name]["$ref"].rpartition("/")[2]]
        assert set(section["properties"]) == set(EXAMPLES[number][name]), name


@pytest.mark.parametrize(
    "change",
    [
        {"colour": 3},
        {"plant": {"inertia": 2}},
        {"plant": {"inertia": "2 kg m^2", "viscos": "1 N m s/rad"}},
        {"plant": {"inertia": "2 kg m^2", "sensor": "both of them"}},
        {"controller": {"filters": [{"kind": "nothc", "frequency": "2 Hz"}]}},
        {"controller": {"gains": "best"}},
        {"limits": {"axis": {"jrek": "1 deg/s^3"}}},
        {"requirements": {"load_settling": {"most": "2 s"}}},
        {"moves": []},
    ],
)
def test_it_refuses_what_loading_refuses(jsonschema, write, change):
    content = {"format": 2, **tomllib.loads(GOOD)}
    validator(2).validate(content)
    content |= change
    with pytest.raises(jsonschema.ValidationError):
        validator(2).validate(content)
    text = "\n".join(f"{key} = {inline(value)}" for key, value in content.items())
    with pytest.raises(ValueError, match=r"case\.toml: "):
        load_scenario(write(text))


@pytest.mark.parametrize("text", [GOOD, LINEAR, GOOD + MODES])
def test_files_of_format_1_are_right_by_both(text):
    content = tomllib.loads(text)
    assert not list(validator(1).iter_errors(content))
    assert not list(validator(2).iter_errors({"format": 2, **content}))


def test_the_command_prints_it(run):
    status, out, errors = run("schema")
    assert (status, out, errors) == (0, shipped_schema(2), [])
    assert run("schema", "--format", 1)[1] == shipped_schema(1)
    status, out, errors = run("schema", "--format", 3)
    assert (status, out) == (2, "")
    assert errors == ["jounce: format 3 of scenario files is not known; give 1 or 2"]
