"""The README's code runs, and the generated parts of the documentation are up to date."""

import importlib.util
import re
from pathlib import Path

import references

ROOT = Path(__file__).parent.parent
PAGES = {
    path: path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    if path.stem not in ("changelog", "contributing", "security")  # which building the site leaves
}
TEXT = PAGES[ROOT / "README.md"]


def generator():
    spec = importlib.util.spec_from_file_location("readme", ROOT / "docs" / "readme.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def part(name):
    begin, end = f"<!-- {name}: begin -->\n", f"\n<!-- {name}: end -->"
    return PAGES[generator().PAGES[name]].split(begin)[1].split(end)[0]


def test_the_readme_is_short():
    assert len(TEXT.splitlines()) <= 200


def test_the_tree_is_the_one_there_is():
    assert part("tree") == generator().tree(), "run: python docs/readme.py tree"


def test_every_benchmark_has_its_table():
    measured = part("benchmarks")
    names = {path.name for path in (ROOT / "benchmarks").glob("*.py")} - {"timing.py", "peers.py"}
    assert set(re.findall(r"\(`benchmarks/(\w+\.py)`\)", measured)) == names, "run: make benchmark"
    assert measured.count("| --- |") == len(names)


def test_the_notebook_example_runs(capsys):
    [snippet] = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert len(snippet.strip().splitlines()) <= 12
    exec(compile(snippet, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "phase margin" in printed


def test_the_promised_precision_is_what_the_tests_hold():
    promised = {
        float(value) for value in re.findall(r"\| (\de-\d+) \| \de[+-]\d+ \|", part("precision"))
    }
    assert promised == {
        references.END_POSITION,
        references.BOUND,
        references.CONTINUITY,
        references.RESPONSE,
        references.MARGINS,
    }


def test_what_was_measured_is_within_what_is_promised():
    rows = re.findall(r"\| (\de-\d+) \| (\de[+-]\d+) \|", part("precision"))
    assert len(rows) >= 5
    assert all(float(measured) <= float(promised) for promised, measured in rows)


LINKS = sorted(
    {(path, target) for path in PAGES for target in re.findall(r"\]\(([^)#]+)\)", PAGES[path])}
)


def test_links_lead_somewhere():
    assert len(LINKS) > 50
    inside = [(page, target) for page, target in LINKS if not target.startswith("https://")]
    assert [str(target) for page, target in inside if not (page.parent / target).exists()] == []


NAMED = sorted(
    {name for text in PAGES.values() for name in re.findall(r"`((?:[a-z]+/)+[\w.]+)`", text)}
)


def test_paths_named_are_there():
    assert len(NAMED) > 50
    kept = [path for path in NAMED if not path.startswith("out/")]
    assert [path for path in kept if not (ROOT / path).exists()] == []
