"""The README's code runs, and its generated parts are up to date."""

import importlib.util
import re
from pathlib import Path

import pytest
import references

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def part(name):
    begin, end = f"<!-- {name}: begin -->\n", f"\n<!-- {name}: end -->"
    return TEXT.split(begin)[1].split(end)[0]


def generator():
    spec = importlib.util.spec_from_file_location("readme", ROOT / "docs" / "readme.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\(([^)#]+)\)", TEXT))))
def test_links_lead_somewhere(target):
    assert target.startswith("https://") or (ROOT / target).exists()


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`((?:[a-z]+/)+[\w.]+)`", TEXT))))
def test_paths_named_are_there(path):
    assert (ROOT / path).exists() or path.startswith("out/")
