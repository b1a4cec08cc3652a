"""What a key of a scenario file accepts: how it is read, and what an editor is told of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from pydantic import PlainValidator, ValidationInfo, WrapValidator

from .units import Kind, Motion, UnitError, show

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import CoreSchema

    from .scenario_context import Context

Schema = Mapping[str, Any]
"""A JSON schema."""


@dataclass(frozen=True)
class Key:
    """A key that is read by a function, which raises ValueError for a value that is not right."""

    read: Callable[..., Any]
    schema: Schema

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return pydantic's own form of the check."""
        return PlainValidator(self.read).__get_pydantic_core_schema__(source, handler)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return what an editor is told."""
        del core, handler
        return dict(self.schema)


@dataclass(frozen=True)
class Quantity:
    """A key that takes a quantity with its unit.

    Parameters
    ----------
    angle, length : tuple of Kind
        What is accepted of an angular axis, and of a linear one; values are in the first's unit.
    scale : float
        What a value in that unit is multiplied by: 0.01 for a percentage kept as a fraction.
    words : tuple of str
        What is taken in place of a quantity.
    several : bool
        Whether it takes a list of quantities.
    """

    angle: tuple[Kind, ...]
    length: tuple[Kind, ...]
    scale: float = 1.0
    words: tuple[str, ...] = ()
    several: bool = False

    def kinds(self, motion: Motion) -> tuple[Kind, ...]:
        """Return what is accepted of one kind of axis."""
        return self.angle if motion == "angle" else self.length

    def read(self, value: object, info: ValidationInfo) -> Any:
        """Return the value, or a tuple of them."""
        if not self.several:
            return self._one(value, info)
        if not isinstance(value, list) or not value:
            example = self.angle[0].example
            raise ValueError(
                f"{show(value)} is not a list of quantities; write one such as [{example!r}]"
            )
        return tuple(self._one(each, info) for each in value)

    def _one(self, value: object, info: ValidationInfo) -> float | str:
        if isinstance(value, str) and value in self.words:
            return value
        try:
            return self.scale * cast("Context", info.context).quantity(value, self.kinds)
        except UnitError as error:
            raise UnitError(" or ".join((str(error), *map(repr, self.words)))) from None

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return pydantic's own form of the check."""
        return PlainValidator(self.read).__get_pydantic_core_schema__(source, handler)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return what an editor is told: text, with examples."""
        del core, handler
        one = quantity_schema(*self.angle, *self.length, words=self.words)
        return {"type": "array", "items": one, "minItems": 1} if self.several else one


def quantity_schema(*kinds: Kind, words: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return the JSON schema of a quantity of one of several kinds."""
    names = dict.fromkeys(kind.name for kind in kinds)
    examples = dict.fromkeys((*words, *(kind.example for kind in kinds)))
    said = " or ".join((*names, *map(repr, words)))
    return {"type": "string", "description": said, "examples": list(examples)}


@dataclass(frozen=True)
class OrWord:
    """A key that takes a word or else a table, whose own check comes behind."""

    words: tuple[str, ...]
    table: str

    def read(self, value: object, table_of: Callable[[Any], Any]) -> Any:
        """Return the word, or what the table gives; a table without a kind is of the first."""
        if isinstance(value, str) and value in self.words:
            return value
        if not isinstance(value, dict):
            raise ValueError(
                f"{show(value)} is not known; write {', '.join(map(repr, self.words))} or a table "
                f"{self.table}"
            )
        return table_of(value)

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return pydantic's own form of the check."""
        return WrapValidator(self.read).__get_pydantic_core_schema__(source, handler)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return what an editor is told."""
        return {"anyOf": [{"enum": list(self.words)}, handler(core)]}


def number(name: str, *, positive: bool = False) -> Key:
    """Return a key that takes a number without unit."""
    wanted = "a positive number" if positive else "a number"

    def read(value: object) -> float:
        real = isinstance(value, int | float) and not isinstance(value, bool)
        if not real or not abs(float(cast(float, value))) < 1e300 or (positive and value <= 0):  # type: ignore[operator]
            raise ValueError(
                f"{show(value)} is not {wanted}; write one without quotation marks such as "
                f"{name} = 1.5"
            )
        return float(cast(float, value))

    schema: dict[str, Any] = {"type": "number"}
    return Key(read, schema | {"exclusiveMinimum": 0} if positive else schema)


def choice(*accepted: str | bool | int) -> Key:
    """Return a key that takes one of several words or whole numbers, or true and false."""
    shown = ", ".join(map(show, accepted))

    def read(value: object) -> Any:
        if not any(type(value) is type(each) and value == each for each in accepted):
            raise ValueError(f"{show(value)} is not known; write one of {shown}")
        return value

    return Key(read, {"enum": list(accepted)})


def numbers(name: str) -> Key:
    """Return a key that takes a list of numbers without unit."""
    one = number(name)

    def read(value: object) -> tuple[float, ...]:
        if not isinstance(value, list) or not value:
            raise ValueError(f"{show(value)} is not a list of numbers; write {name} = [1.0, 0.5]")
        return tuple(one.read(each) for each in value)

    return Key(read, {"type": "array", "items": one.schema, "minItems": 1})


def roots(name: str) -> Key:
    """Return a key that takes zeros or poles: numbers, and [real, imaginary] for a pair."""
    one = number(name)

    def read(value: object) -> tuple[complex, ...]:
        if not isinstance(value, list):
            raise ValueError(
                f"{show(value)} is not a list of numbers, a pair of complex ones as [real, "
                f"imaginary]; write {name} = [-1.0, [-2.0, 5.0]]"
            )
        found: list[complex] = []
        for each in value:
            if not isinstance(each, list):
                found.append(complex(one.read(each)))
            elif len(each) == 2:
                root = complex(one.read(each[0]), one.read(each[1]))
                found += [root, root.conjugate()]
            else:
                raise ValueError(f"{show(each)} is not a pair; write [real, imaginary]")
        return tuple(found)

    item = {"anyOf": [one.schema, {"type": "array", "items": one.schema}]}
    return Key(read, {"type": "array", "items": item})


def square(name: str) -> Key:
    """Return a key that takes a square matrix, a list of its rows, as one row after another."""
    row = numbers(name)

    def read(value: object) -> tuple[float, ...]:
        rows = [row.read(each) for each in value] if isinstance(value, list) else []
        if not rows or any(len(each) != len(rows) for each in rows):
            raise ValueError(
                f"{show(value)} is not a square matrix; write its rows, {name} = [[0.0, 1.0], "
                "[0.0, -0.5]]"
            )
        return tuple(entry for each in rows for entry in each)

    return Key(read, {"type": "array", "items": row.schema, "minItems": 1})
