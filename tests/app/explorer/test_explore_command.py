"""The command `jounce explore`, and what is said without the extra."""

import json
import os
import signal
import socket
import subprocess
import sys

import pytest
from explored import written

from jounce.app import explore
from jounce.app.explorer import serving


def test_without_the_extra_one_line_names_what_installs_it(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "websockets", None)
    status, out, err = run("explore", written(tmp_path), "--no-browser")
    assert (status, out, len(err)) == (2, "", 1)
    assert "websockets" in err[0]
    assert "python -m pip install 'jounce[explore]'" in err[0]


def test_in_a_notebook_without_the_extra_it_says_so_too(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(ValueError, match=r"anywidget.*pip install 'jounce\[explore\]'"):
        explore(written(tmp_path))


@pytest.mark.parametrize(
    ("text", "says"),
    [("plant = 3", "plant"), ("not toml", "not TOML"), ("", "holds no scenario")],
)
def test_a_wrong_file_is_told_before_anything_is_served(run, tmp_path, text, says):
    pytest.importorskip("websockets")
    pytest.importorskip("tomlkit")
    status, out, err = run("explore", written(tmp_path, text), "--no-browser")
    assert (status, out) == (2, "")
    assert any(says in line for line in err)


def test_a_port_that_cannot_be_is_told(run, tmp_path):
    pytest.importorskip("websockets")
    path = written(tmp_path)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        number = taken.getsockname()[1]
        for port in (number, 99999):
            status, out, err = run("explore", path, "--no-browser", "--port", port)
            assert (status, out, len(err)) == (2, "", 1)
            assert f"--port {port}" in err[0]


def test_it_prints_its_address_and_opens_the_browser(run, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)

    def serve(path, *, started, **options):
        assert path.suffix == ".toml"
        started("http://127.0.0.1:1/token/")
        assert options == {"frf": None, "kind": "plant", "port": 7, "stay": True}

    monkeypatch.setattr(serving, "serve_scenario", serve)
    status, out, _ = run("explore", written(tmp_path), "--port", "7", "--stay")
    assert status == 0
    assert out.startswith("http://127.0.0.1:1/token/")
    assert opened == ["http://127.0.0.1:1/token/"]


def test_its_address_as_json_or_nothing(run, tmp_path, monkeypatch):
    monkeypatch.setattr(serving, "serve_scenario", lambda _, *, started, **__: started("http://x/"))
    explore_there = ("explore", written(tmp_path), "--no-browser")
    assert json.loads(run(*explore_there, "--json")[1]) == {"address": "http://x/"}
    assert run(*explore_there, "--quiet") == (0, "", [])


def test_margins_are_worked_out_in_one_thread_where_nothing_else_is_asked(
    run, tmp_path, monkeypatch
):
    monkeypatch.setattr(serving, "serve_scenario", lambda *_, **__: None)
    monkeypatch.setattr(os, "environ", {**os.environ, "MKL_NUM_THREADS": "3"})
    del os.environ["OPENBLAS_NUM_THREADS"]
    assert run("explore", written(tmp_path), "--no-browser")[0] == 0
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
    assert os.environ["MKL_NUM_THREADS"] == "3"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="sends SIGINT")
def test_ctrl_c_ends_it_without_a_word(tmp_path):
    pytest.importorskip("websockets")
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from jounce.app.command_line import main; main()"  # a shell's background ignores it
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, "explore", "--no-browser", written(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as served:
        assert served.stdout.readline().startswith("http://127.0.0.1:")
        served.send_signal(signal.SIGINT)
        assert served.wait(timeout=20) == 0
        assert served.stderr.read() == ""
