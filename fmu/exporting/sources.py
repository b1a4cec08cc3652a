"""The C sources of a block: generated constants, one core, the wrapper of one version of FMI."""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from ... import core
from .blocks import MAX_DOUBLE, Block

MAIN = "model.c"
"""The only file to compile: it includes all others, so that no name leaves it but FMI's own."""

_FOLDERS = (Path(__file__).parent / "c", Path(core.__file__).parent)
"""Of what is an FMU's own, and of the core that Python calls, too."""

_HEADERS = {
    "2.0": ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    "3.0": ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
_WRAPPERS = {"2.0": "fmi2.c", "3.0": "fmi3.c"}
_PLAIN = re.compile(r"[A-Za-z0-9_{}()\[\]., -]")
INCLUDED = re.compile(r'^#include "(\w+\.[ch])"', re.MULTILINE)
"""What a C file includes of ours."""


def sources_of(block: Block, fmi_version: str, token: str) -> dict[str, bytes]:
    """Return all C files of a block's FMU by name, `MAIN` among them.

    Parameters
    ----------
    block : Block
    fmi_version : "2.0" or "3.0"
    token : str
        GUID or instantiation token that the binary accepts.

    Raises
    ------
    ModuleNotFoundError
        Without the package fmpy, which brings the headers of FMI.
    """
    wrapper = _WRAPPERS[fmi_version]
    parts = ["block.h", "numeric.h", f"{block.core}.c", "instance.c", "platform.c", wrapper]
    main = "\n".join(f'#include "{part}"' for part in parts)
    files = {
        MAIN: f"/* The whole FMU: compile this file alone. */\n\n{main}\n".encode(),
        "model.h": _model(block, token).encode(),
    }
    for part in parts:
        if part not in files and part not in _HEADERS[fmi_version]:
            files[part] = source_of(part)
            parts += INCLUDED.findall(files[part].decode())
    headers = _header_folder()
    for header in _HEADERS[fmi_version]:
        files[header] = (headers / header).read_bytes()
    return files


def is_of_core(name: str) -> bool:
    """Tell whether a C file is one of the core, which Python calls, too."""
    return not (_FOLDERS[0] / name).exists()


def source_of(name: str) -> bytes:
    """Return a C file of an FMU or of the core."""
    return next(folder / name for folder in _FOLDERS if (folder / name).exists()).read_bytes()


def licences(fmi_version: str) -> dict[str, str]:
    """Return the licence of the sources and that of FMI's headers, by file name."""
    header = (_header_folder() / _HEADERS[fmi_version][0]).read_text(encoding="utf-8")
    begin = header.index("Copyright (C)")
    notice = header[begin : header.index("*/", begin)]
    return {
        "license.txt": source_of("LICENSE.txt").decode(),
        "fmi_headers.txt": "The headers sources/fmi*.h, from the FMI project:\n\n"
        + "\n".join(line.strip() for line in notice.splitlines()),
    }


def _header_folder() -> Path:
    spec = find_spec("fmpy")
    if spec is None or not spec.submodule_search_locations:
        raise ModuleNotFoundError(
            "the package fmpy, which brings the headers of FMI, is not installed: pip install fmpy",
            name="fmpy",
        )
    return Path(spec.submodule_search_locations[0]) / "c-code"


def constants_of(block: Block) -> dict[str, str]:
    """Return the macros of a block's C file, name to text."""
    return {
        "N_VARIABLES": str(len(block.variables)),
        "N_MEMORY": str(block.memory),
        "N_WORK": str(block.work),
        **{v.macro: str(k) for k, v in enumerate(block.variables) if v.macro},
        **block.constants,
    }


def tables_of(block: Block) -> list[str]:
    """Return the arrays of a block's C file."""
    return [_table(name, values) for name, values in block.tables.items()]


def _model(block: Block, token: str) -> str:
    own = {"TOKEN": _text(token), **({"HAS_PARTIALS": "1"} if block.partials else {})}
    lines = [f"/* {block.name}: generated. */", ""]
    lines += [f"#define {name} {value}" for name, value in (own | constants_of(block)).items()]
    lines += ["", "static const Variable variables[] = {"]
    for variable in block.variables:
        low = -MAX_DOUBLE if variable.minimum is None else variable.minimum
        high = MAX_DOUBLE if variable.maximum is None else variable.maximum
        start = variable.start if variable.has_start else 0.0
        numbers = ", ".join(number(x) for x in (start, low, high))
        lines.append(f"    {{{variable.flags}, {numbers}, {_text(variable.name)}}},")
    lines.append("};")
    for table in tables_of(block):
        lines += ["", table]
    return "\n".join(lines) + "\n"


def number(x: float) -> str:
    """Return a double as C writes it, all of its digits."""
    return repr(float(x))


def _table(name: str, values: Sequence[object]) -> str:
    sizes, inner = "", list[object]([values])
    while isinstance(inner[0], Sequence):
        inner = list(inner[0])
        sizes += f"[{len(inner)}]"
    return f"static const double {name}{sizes} = {_nested(values)};"


def _nested(values: object) -> str:
    if not isinstance(values, Sequence):
        return repr(values)
    gap = ",\n    " if isinstance(values[0], Sequence) or len(values) > 8 else ", "
    return "{" + gap.join(_nested(value) for value in values) + "}"


def _text(text: str) -> str:
    """Return a string as C writes it, with nothing in it that C or a trigraph would change."""
    plain = [chr(b) if _PLAIN.fullmatch(chr(b)) else f"\\{b:03o}" for b in text.encode()]
    return '"' + "".join(plain) + '"'
