"""Firmware of a block: compiled strictly, and driven from Python."""

import ctypes
import subprocess

import numpy as np
from fmus import SLOW, pointer

from jounce.fmu import export_c

STRICT = "-std=c99 -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -Icore"


def library(where, driver, optimised="-O2" if SLOW else "-O0"):
    """Return a library made of a folder's sources and a driver."""
    (where / "build").mkdir(exist_ok=True)
    (where / "build/driver.c").write_text(driver, encoding="ascii")
    sources = [path for path in where.rglob("*.c") if path.name != "main.c"]
    command = ["cc", *STRICT.split(), "-I.", optimised, "-fPIC", "-shared", "-o", "build/driver.so"]
    subprocess.run([*command, *sources], cwd=where, check=True)
    return ctypes.CDLL(str(where / "build/driver.so"))


def driver(name, inputs, outputs):
    """Return C that runs samples on rows of inputs and gives rows of outputs."""
    given = "".join(f"block.{own} = in[{k} * n + i];" for k, own in enumerate(inputs))
    taken = "".join(f"out[{k} * n + i] = block.{own};" for k, own in enumerate(outputs))
    return f"""#include "{name}.h"
int drive(int n, const double *in, double *out);
int drive(int n, const double *in, double *out) {{
    static {name}_block block;
    int i, refused = {name}_init(&block);
    for (i = 0; i < n; i++) {{
        {given}
        refused += {name}_step(&block);
        {taken}
    }}
    return refused;
}}
"""


def driven(source, where, inputs, outputs):
    """Return rows of outputs of a sampled block; `inputs` are rows by name."""
    made = export_c(source, where, name="block_x").folder
    rows = np.array(list(inputs.values()))
    out = np.empty((len(outputs), rows.shape[1]))
    code = driver("block_x", inputs, outputs)
    assert library(made, code).drive(rows.shape[1], pointer(rows), pointer(out)) == 0
    return out
