"""Sphinx's settings of the site (`make docs`)."""

from __future__ import annotations

import re
import shutil
import sys
import tomllib
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))

from reference_pages import write_reference_pages  # noqa: E402 (found by the line above)
from see_also import see_also  # noqa: E402

project = "jounce"
author = "The jounce authors"
copyright = author
version = release = installed("jounce")

templates_path = ["_templates"]
exclude_patterns = ["**.ipynb_checkpoints"]
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx-mathjax-offline",  # no request leaves the page
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_nb",
    "sphinx_design",
]

autosummary_generate = True
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
smartquotes = False  # commands in prose are copied
nb_execution_mode = "cache"
nb_execution_cache_path = str(DOCS.parent / "out" / "executed")
nb_execution_timeout = 120
nb_execution_raise_on_error = True

html_theme = "pydata_sphinx_theme"
html_title = "jounce"
html_theme_options = {
    "navbar_end": ["theme-switcher", "navbar-icon-links"],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "header_links_before_dropdown": 7,
    "footer_start": ["copyright"],
    "footer_end": [],
    "github_url": "https://github.com/jounce-control/jounce",
}
html_context = {"default_mode": "auto"}
html_sidebars = {"gallery": [], "changelog": [], "security": []}  # that stand alone
html_static_path = ["static"]
html_css_files = ["site.css"]
html_search_scorer = str(DOCS / "search_scorer.js")

linkcheck_timeout = 20
linkcheck_workers = 8
linkcheck_anchors = False  # pages made by scripts have none to be seen

PAGES = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")  # that stand above this folder
WORDS = tomllib.loads((DOCS / "search_words.toml").read_text(encoding="utf-8"))
SOURCES = "https://github.com/jounce-control/jounce/blob/HEAD/"


def links_of_the_site(_app: object, page: str, source: list[str]) -> None:
    """Lead links that leave this folder to the site's own notebooks, else to the repository."""
    notebook = r"\[([^]]+)\]\((?:\.\./)+notebooks/(\w+)\.ipynb\)"
    source[0] = re.sub(notebook, r"{doc}`\1 </notebooks/\2>`", source[0])
    for name in PAGES:
        source[0] = re.sub(rf"\]\(((?:\.\./)*)\.\./{name}\)", rf"](\1{name.lower()})", source[0])
    if page in {Path(name).stem.lower() for name in PAGES}:
        source[0] = source[0].replace("](docs/", "](")
    if "/" not in page:
        source[0] = re.sub(r"\]\(\.\./", f"]({SOURCES}", source[0])


def words_to_find_it_by(_app: object, page: str, source: list[str]) -> None:
    """Put into the site's search what people call that which a page is about."""
    if page in WORDS:
        entries = ", ".join(f"! {words}" for words in WORDS[page])  # main ones are found first
        source[0] += f"\n```{{index}} {entries}\n```\n"


def what_else_to_read(
    _app: object, _what: str, name: str, _of: object, _: object, lines: list[str]
) -> None:
    """Lead on from each public name."""
    lines += see_also(name)


def plain_bars(
    _app: object, _what: str, _name: str, _of: object, _: object, lines: list[str]
) -> None:
    """Let |L| be a magnitude, not a substitution of reStructuredText."""
    lines[:] = [line if "``" in line else line.replace("|", "\\|") for line in lines]


def bring_pages() -> None:
    """Bring the notebooks and the pages above it below the folder that Sphinx reads."""
    link = DOCS / "notebooks"  # no copies: they are run where they stand
    if not link.exists():
        link.symlink_to(DOCS.parent / "notebooks", target_is_directory=True)
    for name in PAGES:
        shutil.copy(DOCS.parent / name, DOCS / name.lower())


def setup(app: Any) -> None:
    """Connect what is done before and while the pages are read."""
    write_reference_pages(DOCS / "reference")
    bring_pages()
    app.connect("source-read", links_of_the_site)
    app.connect("source-read", words_to_find_it_by)
    app.connect("autodoc-process-docstring", what_else_to_read, priority=900)  # behind numpydoc's
    app.connect("autodoc-process-docstring", plain_bars)
