"""What the pages of the site show happens: their Python, their commands, their files."""

import doctest
import re
import shlex
import tomllib
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [DOCS / "index.md"] + [
    page
    for part in ("tutorials", "how-to", "explanation")
    for page in sorted((DOCS / part).glob("*.md"))
]
FENCE = re.compile(r"^```(\{code-block\} )?(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.parent.name}/{page.stem}")
def test_a_page_does_what_it_shows(page, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    known: dict[str, object] = {}
    for _, language, body in FENCE.findall(page.read_text(encoding="utf-8")):
        caption = re.match(r":caption: (\S+)\n\n", body)
        if caption:
            Path(caption[1]).write_text(body[caption.end() :], encoding="utf-8")
        elif language == "pycon":
            check_python(page.name, body, known)
        elif language == "console":
            check_commands(body, run)
        elif language == "toml":
            tomllib.loads(body)
        elif language == "python":
            compile(body, page.name, "exec")
        else:
            assert language in ("text", "toctree", "bash"), language


def check_python(name, body, known):
    body = re.sub(r"\n(?=\n(?!>>>))", "\n<BLANKLINE>", body)
    test = doctest.DocTestParser().get_doctest(body, known, name, name, 0)
    told: list[str] = []
    doctest.DocTestRunner(optionflags=FLAGS).run(test, out=told.append, clear_globs=False)
    known.update(test.globs)
    assert not told, "".join(told)


def check_commands(body, run):
    """Run each line of `$ jounce …`; what stands below it is what it prints, if anything."""
    for command, shown in re.findall(r"^\$ jounce (.*)\n((?:(?!\$ ).*\n)*)", body, re.MULTILINE):
        line, _, status = command.partition("  # exit status ")
        found, out, errors = run(*shlex.split(line))
        assert found == int(status or 0), (command, out, errors)
        checker = doctest.OutputChecker()
        assert not shown or checker.check_output(shown, out, FLAGS), (command, out)


def test_every_page_is_in_a_list():
    for part in ("tutorials", "how-to", "explanation"):
        listed = (DOCS / part / "index.md").read_text(encoding="utf-8").split()
        assert {page.stem for page in (DOCS / part).glob("*.md")} - {"index"} <= set(listed), part


def test_the_search_has_words_of_every_how_to_and_of_no_page_that_is_not():
    words = tomllib.loads((DOCS / "search_words.toml").read_text(encoding="utf-8"))
    above = {"changelog", "contributing", "security"}  # which the site brings from above
    assert [page for page in words.keys() - above if not (DOCS / f"{page}.md").exists()] == []
    assert {f"how-to/{page.stem}" for page in (DOCS / "how-to").glob("*.md")} - words.keys() == {
        "how-to/index"
    }


@pytest.mark.slow
def test_every_public_name_leads_on(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    from see_also import public_names, see_also

    alone = [name for name, package in public_names().items() if not see_also(f"{package}.{name}")]
    assert alone == []
    assert ":doc:`/how-to/prove`" in "".join(see_also("jounce.shaping.certify"))
    assert "jounce.shaping.Certificate`" in "".join(see_also("jounce.shaping.certify"))
    assert see_also("jounce.shaping.Limits.velocity") == []
