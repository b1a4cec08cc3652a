"""A command line that does not fit is refused in one line, with exit status 2."""

import json

import pytest
from every_command import COMMANDS, options_of

GOOD = "examples/telescope.toml"
FRF = ("frf", "x.csv", "--kind", "loop")
DECEL = ("--velocity", "1 m/s", "--jerk", "1 m/s^3", "--decel", "1 m/s^2")

REFUSED = {
    ("survey", GOOD, "--pdf"): ["--pdf without --output", "name the folder"],
    ("survey",): ["scenario"],
    ("survey", GOOD, "--output"): ["--output", "expected one argument"],
    ("survey", GOOD, "--out", "x"): ["unknown option --out", "--output?"],
    ("survey", GOOD, "-x"): ["-x"],
    ("export", "c", GOOD, "--block", "shaper"): ["--output", "jounce export c --help"],
    ("export", "c", GOOD, "--output", "x"): ["--block"],
    ("export", "c", GOOD, "--output", "x", "--block", "no"): ["'no'", "'shaper'", "'servo'"],
    ("plan", "--acc", "1 m/s^2"): ["--acc:", "--acceleration?"],
    ("plan", "1 m", "--velo=1 m/s"): ["--velo:", "--velocity?"],
    ("plan", "1 m", "--dec", "1 m/s^2"): ["--dec:", "--deceleration?"],
    ("plan", "1 m", "--jrek", "1 m/s^3"): ["--jrek:", "--jerk?"],
    ("plan", "1 m", "--zzz", "1"): ["unknown option --zzz; see jounce plan --help"],
    ("plan", "1 m", "--", "--velocity", "1 m/s"): ["--velocity behind --", "before --"],
    ("plan", "1 m", "--order", "x"): ["--order", "'x'", "from 1 to 14", "pop"],
    ("plan", "1 m", "--order", "2.5"): ["--order", "'2.5'", "from 1 to 14"],
    ("plan", "1 m", "--acceleration", "-1 m/s^2, 2 m/s^2", *DECEL): [
        "--acceleration '-1 m/s^2, 2 m/s^2'", "--deceleration",
    ],
    ("schema", "--format", "x"): ["--format 'x'", "expected 1 or 2"],
    ("schema", "--format", "7"): ["format 7", "give 1 or 2"],
    (*FRF, "--averages", "two"): ["--averages 'two'", "whole number from 1 on", "20"],
    (*FRF, "--averages", "2.5"): ["--averages '2.5'", "whole number from 1 on"],
    (*FRF, "--averages", "0"): ["--averages '0'", "whole number from 1 on"],
    (*FRF, "--integrators", "-1"): ["--integrators '-1'", "whole number from 0 on"],
    (*FRF, "--unstable-poles", "1e0"): ["--unstable-poles '1e0'", "from 0 on"],
    (*FRF, "--dt", "two"): ["--dt", "'two'", "duration"],
    (*FRF, "--dt", "-1"): ["--dt '-1'", "positive duration"],
    ("fmu", "run", GOOD, "--tolerance", "small"): ["--tolerance 'small'", "positive number"],
    ("fmu", "run", GOOD, "--tolerance", "nan"): ["--tolerance 'nan'", "positive number"],
    ("check",): ["scenario"],
    ("survey", GOOD, "b.toml"): ["b.toml", "jounce survey --help"],
    ("survey", GOOD, "--json=3"): ["--json", "'3'"],
    ("fmu", "run", GOOD, "--set", "--json"): ["--set", "expected one argument"],
    ("explore", GOOD, "--port", "a"): ["--port", "'a'", "whole number"],
    ("survey", GOOD, "--output", ""): ["--output", "''", "path of a file or folder"],
    ("survey", GOOD, "--output", GOOD): [GOOD, "Not a directory"],
    ("plan", "1 m", "--limit", "=2"): ["--limit '=2'", "unknown derivative", "from 1 to 14"],
    ("check", GOOD, "--sweep", "none.toml"): ["none.toml", "No such file", "a sweep file"],
    ("sweep", GOOD, GOOD, "--output", "x", "--workers", "two"): ["--workers", "'two'"],
    ("fmu", "inspect", GOOD): [GOOD, "zip archive", "give the path of one"],
    ("nonsense",): ["'nonsense'", "jounce --help"],
    ("--versoin",): ["--versoin", "--version?"],
}  # fmt: skip


@pytest.mark.parametrize("words", REFUSED, ids=" ".join)
def test_one_line_says_what_is_wrong(run, words):
    status, out, errors = run(*words)
    assert (status, out, len(errors)) == (2, "", 1)
    assert errors[0].startswith("jounce: ")
    assert not any(part in errors[0] for part in ("Value error", "--csv", "Traceback"))
    for part in REFUSED[words]:
        assert part in errors[0]


BOUND = "--acceleration", "1 mm/s^2"


@pytest.mark.parametrize(
    "words",
    [
        ("-2mm", *BOUND),
        (*BOUND, "-2mm"),
        (*BOUND, "--", "-2mm"),
        ("--acceleration=1 mm/s^2", "-2e0mm"),
        ("--from", "-1mm", *BOUND, "--to", "-3e0mm"),
        ("-q", "--from=-1 mm", "--to=-3 mm", *BOUND),
    ],
    ids=" ".join,
)
def test_values_may_begin_with_a_dash_and_stand_anywhere(run, words):
    """T = 2√(2/1) s."""
    status, out, _ = run("plan", "--json", *words)
    assert status == 0
    told = json.loads(out)
    assert told["duration_s"] == pytest.approx(8.0**0.5, rel=1e-12)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_into_80_columns_and_names_all(run, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "80")
    status, out, errors = run(*name.split(), "--help")
    assert (status, errors) == (0, [])
    assert out.startswith(f"Usage: jounce {name} [OPTIONS]")
    assert max(map(len, out.splitlines())) <= 80
    assert all(option in out for option in options_of(name))


@pytest.mark.parametrize("words", [(), ("fmu",), ("export",)], ids=str)
def test_no_command_prints_the_help_alone(run, words):
    status, out, errors = run(*words)
    assert (status, errors) == (2, [])
    assert "Usage" in out


@pytest.mark.parametrize("word", ["--help", "--version"])
def test_what_is_asked_for_is_no_error(run, word):
    status, out, errors = run(word)
    assert (status, errors) == (0, [])
    assert out
