"""The header of a block's firmware, and the names and groups of its fields."""

from __future__ import annotations

import re
from dataclasses import dataclass
from textwrap import wrap

from .blocks import LEAST_POSITIVE, Block, Variable

_KEYWORDS = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline
    int long register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile while asm bool catch class delete explicit export false friend mutable
    namespace new operator private protected public template this throw true try typename using
    virtual and or not xor state work NULL EPSILON ROUNDING INFINITE
    """.split()  # noqa: SIM905 (a list of them takes a page)
)
"""Of C and C++, and names of our own."""


ABOUT = (
    "Times are in seconds, other units stand in brackets. C99, without heap, library of "
    "mathematics or global variables; functions are re-entrant."
)


@dataclass(frozen=True)
class Field:
    """A variable of a block as a field of its struct; `index` is its place in the state."""

    name: str
    index: int
    variable: Variable


@dataclass(frozen=True)
class Fields:
    """The fields of a block, by what may be done with them."""

    tunable: list[Field]
    initial: list[Field]
    inputs: list[Field]
    outputs: list[Field]
    states: list[Field]

    @property
    def settable(self) -> list[Field]:
        """All that is the user's to set, at one time or another."""
        return [*self.tunable, *self.initial, *self.inputs, *self.states]

    @property
    def total(self) -> list[Field]:
        """All fields, as they stand in the struct."""
        return [*self.tunable, *self.initial, *self.inputs, *self.outputs, *self.states]


def fields_of(block: Block) -> Fields:
    """Return the fields of a block's struct; what is constant or derived is none."""
    groups: dict[str, list[Field]] = {key: [] for key in Fields.__dataclass_fields__}
    taken: set[str] = set()
    for index, variable in enumerate(block.variables):
        group = _group(variable)
        if group:
            name = _identifier(variable.name, taken)
            taken.add(name)
            groups[group].append(Field(name, index, variable))
    return Fields(**groups)


def _group(variable: Variable) -> str:
    if variable.causality == "input" or variable.initial == "calculated":
        return {"input": "inputs", "output": "outputs"}.get(variable.causality, "")
    if variable.initial != "exact" or variable.variability == "constant":
        return ""
    if variable.variability == "tunable":
        return "tunable"
    return "initial" if variable.causality == "parameter" else "states"


def _identifier(name: str, taken: set[str]) -> str:
    """Return a C identifier like a name: letters, digits and _, none twice."""
    plain = re.sub(r"\W+", "_", name.removeprefix("state."), flags=re.ASCII).strip("_") or "signal"
    if plain[0].isdigit() or plain in _KEYWORDS:
        plain = f"{plain}_" if plain in _KEYWORDS else f"n{plain}"
    candidates = [plain, *(f"{plain}_{k}" for k in range(2, len(taken) + 3))]
    return next(own for own in candidates if own not in taken)


def header(block: Block) -> str:
    """Return NAME.h: the struct with all of a block's memory, and the functions on it."""
    guard = f"{block.name.upper()}_H"
    return "\n".join(
        [
            comment(f"{block.name}.h: {block.description}.", ABOUT),
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            "#include <stdint.h>",
            "",
            *_OPENED_FOR_CPP,
            *_sample_time(block),
            *_own_memory(block),
            *_block(block),
            *_functions(block),
            "",
            *_CLOSED_FOR_CPP,
            f"#endif /* {guard} */",
            "",
        ]
    )


_OPENED_FOR_CPP = ("#ifdef __cplusplus", 'extern "C" {', "#endif", "")
_CLOSED_FOR_CPP = ("#ifdef __cplusplus", "}", "#endif", "")


def _sample_time(block: Block) -> list[str]:
    if block.sample_time is None:
        return []
    return [f"#define {block.name.upper()}_SAMPLE_TIME {block.sample_time!r} /* s */", ""]


def _own_memory(block: Block) -> list[str]:
    return [
        comment("What the block keeps for itself."),
        "typedef struct {",
        f"    double value[{max(len(block.variables), 1)}];",
        f"    double memory[{max(block.memory, 1)}];",
        "    double start, time;",
        "    int64_t ticks;",
        f"}} {block.name}_state;",
        "",
        "typedef struct {",
        f"    double work[{max(block.work, 1)}];",
        f"}} {block.name}_work;",
        "",
    ]


def _block(block: Block) -> list[str]:
    fields, name = fields_of(block), block.name
    groups = (
        ("Parameters: init sets them; they may be changed between any two steps.", fields.tunable),
        ("Taken over by start alone.", fields.initial),
        ("Inputs.", fields.inputs),
        ("Outputs.", fields.outputs),
        ("States: start takes them over, each step shows them.", fields.states),
    )
    return [
        comment("All memory of one block; any number of them may be in use."),
        "typedef struct {",
        *(line for told, group in groups if group for line in _members(told, group)),
        comment("Not to be touched.", indent=4),
        f"    {name}_state state;",
        f"    {name}_work work;",
        f"}} {name}_block;",
        "",
    ]


def _members(told: str, group: list[Field]) -> list[str]:
    lines = [comment(told, indent=4), ""]
    for field in group:
        variable = field.variable
        unit = "" if variable.unit == "1" else f" [{variable.unit}]"
        lines.append(comment(f"{variable.description}{unit}{_range(variable)}", indent=4))
        lines.append(f"    double {field.name};")
    return [*lines, ""]


def _range(variable: Variable) -> str:
    words = {LEAST_POSITIVE: ", above 0", 0.0: ", at least 0", None: ""}
    below = {-LEAST_POSITIVE: ", below 0", None: ""}
    return words[variable.minimum] + below[variable.maximum]


def _functions(block: Block) -> list[str]:
    name = block.name
    refused = (
        "Returns 0; or 1 where a field that was set is not finite or outside its range, and then "
        "nothing has changed, or where a result leaves the range of a double, and then only a "
        "start helps."
    )
    return [
        comment("Set every field to its default, and start. Returns 0."),
        f"int {name}_init({name}_block *block);",
        "",
        comment("Start anew from the fields as they are. " + refused),
        f"int {name}_start({name}_block *block);",
        "",
        comment(f"{what_a_step_does(block)} Returns as start does."),
        f"{prototype_of_step(block)};",
    ]


def what_a_step_does(block: Block) -> str:
    """Return a sentence on the function to be called again and again."""
    if runs_by_time(block):
        return "Put the motion at a time out, whatever times were asked for before."
    if block.sample_time is None:
        return "Go on by a time h > 0, on inputs that are held; h may differ from step to step."
    held = all(variable.variability == "discrete" for variable in block.outputs)
    when = "what this sample computes" if held else "the motion at the end of the sample"
    return (
        f"Run one sample on the inputs, every {block.name.upper()}_SAMPLE_TIME. Outputs are {when}."
    )


def prototype_of_step(block: Block) -> str:
    """Return the head of the function to be called again and again."""
    name = block.name
    if runs_by_time(block):
        return f"int {name}_at(double time, {name}_block *block)"
    given = "double h, " if block.sample_time is None else ""
    return f"int {name}_step({given}{name}_block *block)"


def runs_by_time(block: Block) -> bool:
    """Tell whether a block is a function of time alone."""
    return any("time" in variable.dependencies for variable in block.outputs)


def comment(*paragraphs: str, indent: int = 0) -> str:
    """Return a comment in C, whatever stands in the text."""
    safe = [
        text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?") for text in paragraphs
    ]
    edge = " " * indent
    lines: list[str] = []
    for text in safe:
        lines += ["", *wrap(text, 92 - indent)] if lines else wrap(text, 92 - indent)
    if len(lines) == 1:
        return f"{edge}/* {lines[0]} */"
    rows = [f"{edge}/* {lines[0]}", *(f"{edge} * {line}".rstrip() for line in lines[1:])]
    return "\n".join([*rows, f"{edge} */"])
