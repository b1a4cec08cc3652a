"""Draw the gallery: Thompson's figures and measured loops as pictures, and the page of them.

Run: python docs/gallery.py   (or `make readme`)
"""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = Path(__file__).parent
PAGE = FOLDER / "gallery.md"
PICTURES = FOLDER / "gallery"

INTRODUCTION = """\
# Gallery

The subjects of the figures of P. M. Thompson, "Snap, Crackle, and Pop", under the paper's numbers,
drawn by jounce (`docs/figures/paper.py`). Where the text gives values they are used; the others
are chosen so that every case shows. Each picture is a matplotlib figure:

```python
from figures.paper import FIGURES

FIGURES[3]().savefig("figure_3.png")
```

`python docs/gallery.py` draws all of them again, and writes this page from their docstrings.
"""


MEASURED_LOOPS = """\
## Measured loops

Simulated measurements, so that the truth is known (`docs/figures/measured.py`); how to read and
shape one's own: [how-to](how-to/measured.md), or the notebook
[Measure, shape, check, ship](../notebooks/12_measure_shape_check_ship.ipynb).
"""


def page() -> str:
    """Return the gallery page in Markdown."""
    from figures.measured import MEASURED
    from figures.paper import FIGURES

    of_paper = (_section(number, draw.__doc__) for number, draw in FIGURES.items())
    measured = (_measured_section(name, draw.__doc__) for name, draw in MEASURED.items())
    return "\n".join([INTRODUCTION, *of_paper, MEASURED_LOOPS, *measured])


def _measured_section(name: str, docstring: str | None) -> str:
    title, text = inspect.cleandoc(docstring or "").split("\n\n", 1)
    title = title.removeprefix("Draw ").rstrip(".")
    title = f"{title[0].upper()}{title[1:]}"
    return f"""\
### {title}

{text}

`{name}()`.

![{title}](gallery/{name}.png)
"""


def _section(number: int, docstring: str | None) -> str:
    title, text = inspect.cleandoc(docstring or "").split("\n\n", 1)
    text, source = text.split("\n\nReferences\n----------\n")
    title = title.removeprefix("Draw ").rstrip(".")
    title = f"Figure {number}. {title[0].upper()}{title[1:]}"
    source = source.rsplit(", ", 1)[1].rstrip(".")
    return f"""\
## {title}

{text}

{source}; `figure_{number}()`.

![{title}](gallery/{picture_name(number)})
"""


def picture_name(number: int) -> str:
    """Return the name of the file that holds a figure."""
    return f"figure_{number:02d}.png"


def save(figure: Figure, path: Path) -> None:
    """Save a figure as a PNG, in a palette to keep the file small; always the same bytes."""
    from PIL import Image

    from jounce.app.result_files import save_figure

    save_figure(figure, path)
    with Image.open(path) as drawn:
        small = drawn.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    small.save(path, optimize=True)


def main() -> None:
    """Draw every figure, and write the page."""
    from figures.measured import MEASURED
    from figures.paper import FIGURES

    PICTURES.mkdir(exist_ok=True)
    for number, draw in FIGURES.items():
        save(draw(), PICTURES / picture_name(number))
    for name, draw in MEASURED.items():
        save(draw(), PICTURES / f"{name}.png")
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
