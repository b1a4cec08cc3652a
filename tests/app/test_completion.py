"""The scripts of `jounce completion`, read by the shells that there are."""

import json
import shutil
import subprocess

import pytest
from every_command import COMMANDS, options_of

CASES = {
    "jounce su": ["survey"],
    "jounce fmu ": ["export", "inspect", "run"],
    "jounce fmu run --pl": ["--plot"],
    "jounce check --format ": ["github", "table"],
    "jounce fmu export --fmi ": ["2.0", "3.0"],
    "jounce export ": ["c"],
}
_BASH = """
COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _jounce
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def _completed(shell: str, script: str, line: str) -> list[str]:
    if shell == "bash":
        words = " ".join(f"'{word}'" for word in line.split(" "))
        told = _told(["bash", "--norc", "-c", script + _BASH.format(words=words)])
    else:
        told = _told(["fish", "--no-config", "-c", f"{script}\ncomplete -C '{line}'"])
    words = [line.split("\t")[0] for line in told.splitlines()]
    return sorted(word for word in words if word not in ("", "--help"))


def _told(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stderr == ""
    return done.stdout


@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_a_shell_completes(run, shell):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not on this machine")
    _, script, _ = run("completion", shell)
    assert {line: _completed(shell, script, line) for line in CASES} == CASES


def test_zsh_reads_bash_s_own(run):
    _, bash, _ = run("completion", "bash")
    _, zsh, _ = run("completion", "zsh")
    assert zsh.startswith("#compdef jounce\n")
    assert zsh.endswith(bash)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_and_option_is_in_it(run, shell):
    _, out, _ = run("completion", shell, "--json")
    told = json.loads(out)
    assert told["shell"] == shell
    for name in COMMANDS:
        lines = [line for line in told["script"].splitlines() if f' {name}"' in line
                 or f"' {name}'" in line]  # fmt: skip
        for option in options_of(name):
            word = option.lstrip("-") if shell == "fish" else option
            assert any(word in line for line in lines), (name, option)


def test_another_shell_is_refused(run):
    status, out, errors = run("completion", "csh")
    assert (status, out, len(errors)) == (2, "", 1)
    assert "'csh'" in errors[0]
    assert "fish" in errors[0]
