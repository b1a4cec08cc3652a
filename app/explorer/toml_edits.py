"""Values put into the text of a TOML file, its comments and its order kept."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from .extra import needed


def edited(text: str, told: Mapping[str, Any]) -> str:
    """Return a text of TOML with values put in, tables within tables; None takes a key away.

    What is new comes behind the last key of its table, a table of its own behind all others;
    comments that stand before the next table stay there.
    """
    tomlkit = needed("tomlkit")
    document = tomlkit.parse(text)
    _put(document, told, above=document)
    written: str = tomlkit.dumps(document)
    return written.rstrip("\n") + (text[len(text.rstrip("\n")) :] or "\n")


def _put(table: Any, told: Mapping[str, Any], *, above: Any) -> None:
    tomlkit = needed("tomlkit")
    for key, value in told.items():
        was = table.get(key)
        if value is None:
            with _tail(table):
                table.remove(key)
        elif isinstance(value, Mapping) and isinstance(was, Mapping):
            _put(was, value, above=table)
        elif _is_tables(was) and isinstance(value, list):
            with _tail(above if table is above else table):
                _put_tables(was, value)
        elif key in table:
            table[key] = _item(value)
        elif isinstance(value, Mapping) and isinstance(table, tomlkit.TOMLDocument):
            _last(table).append(_blank())
            table.add(key, _table(value))
        else:
            with _tail(table):
                _add(table, key, value)


def _add(table: Any, key: str, value: Any) -> None:
    """Put a new key into a table; a list of tables comes as tables of their own."""
    tomlkit = needed("tomlkit")
    tables = isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value)
    if not tables:
        table.add(key, _item(value))
        return
    made = tomlkit.aot()
    for one in value:
        made.append(_table(one))
    _last(table).append(_blank())
    table.add(key, made)


def _put_tables(tables: Any, values: list[Any]) -> None:
    """Make a list of tables another; those that stay keep their comments.

    A table stays where it has the same values, else where it stands at the same place.
    """
    rest: list[Any] = list(tables)
    places = list(rest)
    kept = [_taken(rest, [own.unwrap() == one for own in rest]) for one in values]
    for at, one in enumerate(values):
        if kept[at] is None and at < len(places):
            kept[at] = _taken(rest, [own is places[at] for own in rest])
            if kept[at] is not None:
                _put(kept[at], _changes(kept[at].unwrap(), one), above=kept[at])
    if len(kept) == len(places) and all(map(operator.is_, kept, places)):
        return
    while len(tables):
        del tables[0]
    for own, one in zip(kept, values, strict=True):
        if own is None and len(tables):
            _last(tables[-1]).append(_blank())
        tables.append(_table(one) if own is None else own)


def _taken(rest: list[Any], is_it: list[bool]) -> Any:
    """Take the first that is it out of a list and return it; None where none is."""
    return rest.pop(is_it.index(True)) if True in is_it else None


def _changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    gone = {key: None for key in before if key not in after}
    return gone | {key: value for key, value in after.items() if before.get(key) != value}


def _blank() -> tuple[None, Any]:
    return None, needed("tomlkit").items.Whitespace("\n")


def _is_tables(item: Any) -> bool:
    return isinstance(item, needed("tomlkit").items.AoT)


def _item(value: Any) -> Any:
    """Return a value as it stands on one line."""
    tomlkit = needed("tomlkit")
    if isinstance(value, list):
        array = tomlkit.array()
        for one in value:
            array.append(_item(one))
        return array
    if not isinstance(value, Mapping):
        return tomlkit.item(value)
    table = tomlkit.inline_table()
    for key, one in value.items():
        table.append(key, _item(one))
    return table


def _table(value: Mapping[str, Any]) -> Any:
    table = needed("tomlkit").table()
    for key, one in value.items():
        table.append(key, _item(one))
    return table


@contextmanager
def _tail(table: Any) -> Iterator[None]:
    """Hold the blank lines and comments behind a table's last key until something is put in."""
    body = _last(table)
    held: list[Any] = []
    while body and body[-1][0] is None:
        held.insert(0, body.pop())
    yield
    _last(table).extend(held)


def _last(table: Any) -> list[Any]:
    """Return the list of lines that ends where a table ends: that of its last table within."""
    items = needed("tomlkit").items
    body: list[Any] = table.body if hasattr(table, "body") else table.value.body
    keyed = [item for key, item in body if key is not None]
    if keyed and isinstance(keyed[-1], items.AoT) and len(keyed[-1]):
        return _last(keyed[-1][-1])
    if keyed and isinstance(keyed[-1], items.Table):
        return _last(keyed[-1])
    return body
