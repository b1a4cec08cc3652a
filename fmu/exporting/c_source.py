"""The C file of a block's firmware, and the files of the core that it calls."""

from __future__ import annotations

import re

from .blocks import MAX_DOUBLE, Block
from .c_header import Field, comment, fields_of, prototype_of_step, runs_by_time
from .sources import INCLUDED, constants_of, is_of_core, number, source_of, tables_of

_FOLLOWED = re.compile(r'^#include "[\w.]+"\n+', re.MULTILINE)


def core_files(block: Block) -> dict[str, bytes]:
    """Return the files of the core that a block needs, by name."""
    return {name: text for name, text in _parts(block).items() if is_of_core(name)}


def source(block: Block) -> str:
    """Return NAME.c: constants, the block's own C, and the functions that the header names."""
    name = block.name
    own = [text.decode() for file, text in reversed(_parts(block).items()) if not is_of_core(file)]
    headers = [file for file in ("numeric.h", "jounce.h") if file in core_files(block)]
    return "\n".join(
        [
            comment(f"{name}.c: {block.description}."),
            f'#include "{name}.h"',
            "",
            "#include <stddef.h>",
            "",
            *(f'#include "{file}"' for file in headers),
            "",
            *_moving(block),
            "#define N_SOME(n) ((n) > 0 ? (n) : 1)",
            *(f"#define {key} {value}" for key, value in constants_of(block).items()),
            "",
            *(line for text in tables_of(block) for line in (text, "")),
            f"typedef {name}_state State;",
            f"typedef {name}_work Cache;",
            "",
            *(_FOLLOWED.sub("", text) for text in own if not _only_includes(text)),
            *_functions(block),
        ]
    )


def _parts(block: Block) -> dict[str, bytes]:
    """Return all files that a block's own one includes, it first."""
    files: dict[str, bytes] = {}
    wanted = [f"{block.core}.c", "numeric.h"]
    for part in wanted:
        if part not in files:
            files[part] = source_of(part)
            wanted += INCLUDED.findall(files[part].decode())
    return files


def _only_includes(text: str) -> bool:
    without = re.sub(r"/\*.*?\*/", "", _FOLLOWED.sub("", text), flags=re.DOTALL)
    return not without.strip()


def _moving(block: Block) -> list[str]:
    """Return functions between fields and state; macros that come later cannot change them."""
    fields, name = fields_of(block), block.name
    taken, first = [*fields.tunable, *fields.inputs], [*fields.initial, *fields.states]
    return [
        *_function(
            "static int within(double x, double least, double most)",
            ["return x >= least && x <= most;"],
        ),
        *_function(
            f"static int accepted(const {name}_block *block)", [_all_within(fields.settable)]
        ),
        *_function(f"static void take({name}_block *block)", _copied(taken, to_state=True)),
        *_function(f"static void take_start({name}_block *block)", _copied(first, to_state=True)),
        *_function(
            f"static void put({name}_block *block)",
            _copied([*fields.outputs, *fields.states], to_state=False),
        ),
        *_function(
            f"static void set_defaults({name}_block *block)",
            [f"block->{field.name} = {number(field.variable.start)};" for field in fields.settable],
        ),
        *_function(
            f"static int all_finite(const {name}_block *block)",
            ["return " + " &&\n           ".join(_finite(fields.outputs + fields.states)) + ";"],
        ),
    ]


def _function(head: str, body: list[str]) -> list[str]:
    return [f"{head} {{", *(f"    {line}" for line in body or ["(void)block;"]), "}", ""]


def _all_within(fields: list[Field]) -> str:
    tests = []
    for field in fields:
        variable = field.variable
        low = -MAX_DOUBLE if variable.minimum is None else variable.minimum
        high = MAX_DOUBLE if variable.maximum is None else variable.maximum
        tests.append(f"within(block->{field.name}, {number(low)}, {number(high)})")
    return "return " + " &&\n           ".join(tests or ["block != NULL"]) + ";"


def _finite(fields: list[Field]) -> list[str]:
    return [f"is_finite(block->{field.name})" for field in fields] or ["block != NULL"]


def _copied(fields: list[Field], *, to_state: bool) -> list[str]:
    pairs = [(f"block->{field.name}", f"block->state.value[{field.index}]") for field in fields]
    return [f"{b} = {a};" if to_state else f"{a} = {b};" for a, b in pairs]


def _functions(block: Block) -> list[str]:
    name = block.name
    start = [
        "int i;",
        "if (!accepted(block)) {",
        "    return 1;",
        "}",
        "for (i = 0; i < N_SOME(N_VARIABLES); i++) {",
        "    block->state.value[i] = 0.0;",
        "}",
        "for (i = 0; i < N_SOME(N_MEMORY); i++) {",
        "    block->state.memory[i] = 0.0;",
        "}",
        "for (i = 0; i < N_SOME(N_WORK); i++) {",
        "    block->work.work[i] = 0.0;",
        "}",
        "block->state.start = block->state.time = 0.0;",
        "block->state.ticks = 0;",
        "take(block);",
        "take_start(block);",
        "core_initialize(&block->state);",
        "core_outputs(&block->state, 0);",
        "put(block);",
        "return !all_finite(block);",
    ]
    return [
        *_function(
            f"int {name}_init({name}_block *block)",
            ["set_defaults(block);", f"return {name}_start(block);"],
        ),
        *_function(f"int {name}_start({name}_block *block)", start),
        *_step(block),
    ]


def _step(block: Block) -> list[str]:
    by_time, sampled = runs_by_time(block), block.sample_time is not None
    time = "time" if by_time else "tick_time(s, s->ticks)" if sampled else "s->time"
    length = "SAMPLE_TIME" if sampled else "h"
    known = {"is_finite(time)": by_time, "h > 0.0 && is_finite(h)": not by_time and not sampled}
    accepted = " && ".join(["accepted(block)", *(test for test, holds in known.items() if holds)])
    return _function(
        prototype_of_step(block),
        [
            "State *s = &block->state;",
            f"double t = {time};" if not by_time else "double t = time, h = 0.0;",
            f"if (!({accepted})) {{",
            "    return 1;",
            "}",
            "take(block);",
            f"if (core_step(s, &block->work, t, {length}) != NULL) {{",
            "    return 1;",
            "}",
            f"s->time = t + {length};",
            "core_outputs(s, 1);",
            "put(block);",
            "return !all_finite(block);",
        ],
    )
