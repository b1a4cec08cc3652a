"""What stands beside the C of a block's firmware: an example, a Makefile, a README."""

from __future__ import annotations

from textwrap import wrap

from .blocks import Block
from .c_header import ABOUT, Field, Fields, comment, fields_of, runs_by_time, what_a_step_does
from .footprint import Footprint
from .sources import number

WARNINGS = "-Wall -Wextra -Wpedantic -Wconversion -Wshadow"

_NOT_MEASURED = "Code and stack were not measured: there was no C compiler for it at the export."


def main_file(block: Block) -> str:
    """Return main.c, which runs the block over its default experiment and prints its outputs."""
    name, fields = block.name, fields_of(block)
    steps = max(round((block.stop_time - block.start_time) / block.step), 1)
    given = [f"    block.{own.name} = 1.0;" for own in _driven(fields)]
    shown = [own.name for own in (*fields.outputs, *fields.states)]
    printed = ", ".join(f"block.{own}" for own in shown)
    lines = [
        comment(f"An example: runs {name} and prints {', '.join(shown)}, a line a step."),
        f'#include "{name}.h"',
        "",
        "#include <stdio.h>",
        "",
        "int main(void) {",
        f"    static {name}_block block;",
        "    int k;",
        f"    if ({name}_init(&block)) {{",
        "        return 1;",
        "    }",
        *given,
        f"    for (k = 0; k < {steps}; k++) {{",
        f"        if ({_example_call(block)}) {{",
        "            return 1;",
        "        }",
        f'        printf("{" ".join("%.17g" for _ in shown)}\\n", {printed});',
        "    }",
        "    return 0;",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _driven(fields: Fields) -> list[Field]:
    """Return what an example sets: the first input, unless it is a loop's disturbance."""
    return [own for own in fields.inputs[:1] if own.variable.name != "d"]


def _example_call(block: Block) -> str:
    name, step = block.name, number(block.step)
    if runs_by_time(block):
        return f"{name}_at({number(block.start_time)} + (double)(k + 1) * {step}, &block)"
    return f"{name}_step({'' if block.sample_time else f'{step}, '}&block)"


def makefile(block: Block, core: list[str]) -> str:
    """Return the Makefile; `core` are the files of the core."""
    sources = " ".join(
        [f"{block.name}.c", *(f"core/{file}" for file in core if file.endswith(".c"))]
    )
    headers = " ".join(
        [f"{block.name}.h", *(f"core/{file}" for file in core if file.endswith(".h"))]
    )
    return f"""# make: build/example, which prints what the block puts out.
CFLAGS ?= -O2
STRICT = -std=c99 -ffp-contract=off {WARNINGS} -Icore
SOURCES = {sources}
HEADERS = {headers}

build/example: main.c $(SOURCES) $(HEADERS)
	mkdir -p build
	$(CC) $(STRICT) $(CFLAGS) -o $@ main.c $(SOURCES)

clean:
	rm -rf build

.PHONY: clean
"""


def readme(block: Block, core: list[str], taken: Footprint | None) -> str:
    """Return README.md: how to build, what to call and when, what it takes."""
    name = block.name
    parts = [
        f"# {name}",
        _wrapped(f"{block.description}. {ABOUT.replace('in brackets', 'in the table')}"),
        "## Build",
        *(_wrapped(text) for text in _building(name, core)),
        "## Use",
        _use(block),
        _wrapped(
            f"{what_a_step_does(block)} Functions return 0, or 1 where a field is not finite or "
            f"outside its range; `{name}.h` tells the rest.{_started(block)}"
        ),
        _fields_table(block),
        "## What it takes",
        *_taken(block, taken),
    ]
    return "\n\n".join(parts) + "\n"


def _building(name: str, core: list[str]) -> list[str]:
    of_core = ", ".join(f"`core/{file}`" for file in core if file.endswith(".c"))
    together = f"`{name}.c`{f' and {of_core}' if of_core else ''}"
    return [
        "`make` compiles the example `main.c` with the host's compiler and leaves `build/example`, "
        "which prints the outputs, a line a step.",
        f"In a firmware compile {together} with `-std=c99 -ffp-contract=off -Icore`. The files of "
        "`core/` are the same for every block, so that several blocks share them. With that "
        "option numbers are those of jounce in Python to the last bit, wherever doubles are those "
        "of IEEE 754.",
    ]


def _fields_table(block: Block) -> str:
    rows = [
        f"| `{own.name}` | {_cell(own.variable.unit)} | {_cell(own.variable.description)} |"
        for own in fields_of(block).total
    ]
    return "\n".join(["| field | unit | |", "|---|---|---|", *rows])


def _use(block: Block) -> str:
    name, fields = block.name, fields_of(block)
    if runs_by_time(block):
        when, call = "whenever its motion is wanted", f"{name}_at(0.5, &block);"
    elif block.sample_time is None:
        when, call = "every h seconds", f"{name}_step(h, &block);"
    else:
        when, call = f"every {block.sample_time!r} s", f"{name}_step(&block);"
    lines = [
        "```c",
        f"static {name}_block block; /* all memory of one block */",
        f"{name}_init(&block);       /* once: defaults */",
        f"/* {when}: */",
        *(f"block.{own.name} = 1.0;" for own in _driven(fields)),
        call,
        *(f"x = block.{own.name};" for own in [*fields.outputs, *fields.states][:1]),
        "```",
    ]
    return "\n".join(lines)


def _started(block: Block) -> str:
    fields = fields_of(block)
    names = [f"`{field.name}`" for field in (*fields.initial, *fields.states)]
    if not names:
        return ""
    listed = ", ".join(names[:6]) + (", …" if len(names) > 6 else "")
    return f" To start elsewhere, set {listed} and call `{block.name}_start`."


def _taken(block: Block, taken: Footprint | None) -> list[str]:
    numbers = 3 + sum(max(n, 1) for n in (len(block.variables), block.memory, block.work))
    room = 8 * (numbers + len(fields_of(block).total))
    memory = f"- memory of one block: {room} bytes (`sizeof({block.name}_block)`)"
    if taken is None:
        return [memory, _NOT_MEASURED]
    measured = [
        memory,
        f"- code: {taken.code} bytes, constants: {taken.constants} bytes",
        f"- stack: at most {taken.stack} bytes, along the deepest chain of calls",
    ]
    told = (
        f"Code and stack for {taken.processor}, beside the compiler's own functions (arithmetic "
        "with doubles where the processor has none)."
    )
    return ["\n".join(measured), _wrapped(told)]


def _wrapped(text: str) -> str:
    return "\n".join(wrap(text, 96, break_on_hyphens=False))


def _cell(text: str) -> str:
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("`", "\\`").replace("<", "&lt;")
