"""documentation/index.html of an FMU."""

from __future__ import annotations

from html import escape

from .blocks import Block, Variable

_STYLE = (
    "body{font-family:sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse}td,th{border:1px solid #bbb;padding:.2em .6em;text-align:left}"
)
_COMMON = (
    "Inputs, parameters and start values that are not finite, or outside their minimum and "
    "maximum, are answered with an error and a message, and change nothing; so does a step after "
    "which a number would leave the range of a double. Snapshots can be taken, restored and "
    "serialised at any time; one of another FMU, or a damaged one, is refused."
)


def documentation(block: Block) -> bytes:
    """Return the documentation of a block as a page of its own, without links."""
    rows = "\n".join(_row(variable) for variable in block.variables)
    paragraphs = "\n".join(f"<p>{escape(note)}</p>" for note in (*block.notes, _COMMON))
    sample = "" if block.sample_time is None else f"<p>Sample time: {block.sample_time!r} s.</p>"
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{escape(block.name)}</title><style>{_STYLE}</style></head>
<body>
<h1>{escape(block.name)}</h1>
<p>{escape(block.description)}.</p>
{sample}
{paragraphs}
<table>
<tr><th>Variable</th><th>Causality</th><th>Variability</th><th>Unit</th><th>Start</th>
<th>Meaning</th></tr>
{rows}
</table>
</body>
</html>
""".encode()


def _row(variable: Variable) -> str:
    cells = (
        variable.name,
        variable.causality,
        variable.variability,
        variable.unit,
        f"{variable.start:.10g}" if variable.has_start else "",
        variable.description,
    )
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
