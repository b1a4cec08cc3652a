"""The JSON schema of scenario files, made of the models that read them, for editors."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from .scenario_formats import FORMATS

_INNER = ("title", "default", "discriminator")
"""Keywords that tell of the models: names of classes, defaults in SI units, pydantic's own."""


def scenario_schema(number: int = 2) -> dict[str, Any]:
    """Return the JSON schema of scenario files.

    Parameters
    ----------
    number : 1 or 2, optional
        The format of the files.

    Raises
    ------
    ValueError
        For another number.
    """
    if number not in FORMATS:
        raise ValueError(_unknown(number))
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"Scenario of jounce, format {number}",
        **_told(FORMATS[number].model_json_schema(by_alias=True)),
    }


def _told(schema: Any) -> Any:
    """Return a schema without what tells of the models; keys of files stay, whatever they are."""
    if isinstance(schema, list):
        return [_told(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        key: {name: _told(each) for name, each in value.items()}
        if key in ("properties", "$defs")
        else _told(value)
        for key, value in schema.items()
        if key not in _INNER
    }


def schema_text(number: int = 2) -> str:
    """Return the schema as text, as `jounce schema` prints it."""
    return json.dumps(scenario_schema(number), indent=1, ensure_ascii=False) + "\n"


def shipped_schema(number: int = 2) -> str:
    """Return the text of the schema that is shipped, which `schema_text` made.

    Raises
    ------
    ValueError
        For another number than 1 or 2.
    """
    if number not in FORMATS:
        raise ValueError(_unknown(number))
    name = f"scenario_{number}.schema.json"
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _unknown(number: int) -> str:
    return f"format {number!r} of scenario files is not known; give 1 or 2"
