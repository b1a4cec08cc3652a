"""Measured responses: dropped files, margins with error bars, what cannot be read."""

from base64 import b64encode
from dataclasses import replace

import numpy as np
import pytest
from explored import NOTCH, problem_of, session_of, told, value_of, written

from jounce.analysis import MeasuredResponse, loop_margins, read_frf
from jounce.app import load_scenario
from jounce.app.scenario_loop import servo_loop_of
from jounce.plant import zero_order_hold

DT = 0.25e-3


@pytest.fixture(scope="module")
def csv(tmp_path_factory):
    """Write a measured plant of 250 lines."""
    folder = tmp_path_factory.mktemp("measured")
    loop = servo_loop_of(load_scenario(written(folder)))
    held = zero_order_hold(loop.axis.system()[0, 0], DT, delay=DT)
    lines = np.linspace(1.0, 250.0, 250)
    exact = np.array([held(point) for point in np.exp(2j * np.pi * lines * DT)])
    rng = np.random.default_rng(3)
    off = 0.01 / np.sqrt(2.0) * (rng.normal(size=250) + 1j * rng.normal(size=250))
    values, path = exact * (1.0 + off), folder / "plant.csv"
    columns = np.column_stack([lines, values.real, values.imag, 0.01 * abs(exact)])
    np.savetxt(path, columns, delimiter=",", header="frequency [Hz],real,imag,sigma", comments="")
    return path


def drop(content, name="plant.csv", **said):
    """Return the message of a file that is dropped onto the page."""
    whole = {"kind_of": "plant", "output": "position", "dt": DT} | said
    return {"kind": "data", "name": name, "content": b64encode(content).decode(), **whole}


def test_margins_of_a_dropped_file_are_those_of_the_analysis(tmp_path, csv):
    session = session_of(written(tmp_path))
    shown = told(session, drop(csv.read_bytes()))
    measured = read_frf(csv, kind="plant", dt=DT)
    exact = loop_margins(measured, controller=session.state.loop.controller)
    assert shown["numbers"]["source"] == "data"
    assert value_of(shown, "phase_margin_deg") == exact.phase_margin_deg
    [row] = [r for r in shown["numbers"]["margins"] if r["name"] == "phase_margin_deg"]
    assert f"± {exact.phase_margin_deg_sigma:.2g}" in row["shown"]
    assert row["worst"] == exact.phase_margin_deg_worst
    data = shown["curves"]["data"]
    assert (data["low_db"] < data["gain_db"]).all()
    assert (data["gain_db"] < data["high_db"]).all()
    dragged = told(session, {"kind": "drag", "handle": NOTCH, "gesture": "n", "frequency": 1.2})
    controller = session.state.loop.controller
    exact = loop_margins(measured, controller=controller)
    assert value_of(dragged, "phase_margin_deg") == exact.phase_margin_deg
    of_model = told(session, {"kind": "source", "source": "model"})
    assert (
        value_of(of_model, "phase_margin_deg") == loop_margins(session.state.loop).phase_margin_deg
    )


@pytest.mark.parametrize(
    ("content", "name", "said", "says"),
    [
        (b"\x00\x01nonsense", "axis.csv", {}, "axis.csv"),
        (b"", "empty.csv", {}, "empty.csv"),
        (b"a,b\n1,2\n", "two.csv", {}, "two.csv"),
        (b"frequency [Hz],real,imag\n1,1,0\n", "one.csv", {}, "line"),
        (b"anything", "picture.png", {}, "picture.png"),
        (None, "plant.csv", {"kind_of": "loops"}, "loops"),
        (None, "plant.csv", {"dt": 1e-3}, "0.001"),
    ],
)
def test_a_wrong_file_is_told_in_one_line_and_changes_nothing(
    tmp_path, csv, content, name, said, says
):
    session = session_of(written(tmp_path))
    before = session.state
    content = csv.read_bytes() if content is None else content
    told_of = problem_of(session, drop(content, name, **said))
    assert says in told_of
    assert "/tmp" not in told_of
    assert "\n" not in told_of
    assert session.state is before


def test_a_file_that_did_not_come_whole_is_told(tmp_path):
    session = session_of(written(tmp_path))
    message = {"kind": "data", "name": "a.csv", "content": "no base64!"}
    assert "a.csv" in problem_of(session, message)


def test_the_worst_case_of_data_is_that_of_its_gain_and_delay(tmp_path):
    loop = servo_loop_of(load_scenario(written(tmp_path)))
    transfer = loop.loop_transfer()
    lines = np.geomspace(0.5, 500.0, 120)
    values = np.array([transfer(point) for point in np.exp(2j * np.pi * lines * DT)])
    measured = MeasuredResponse(lines, values, kind="loop", dt=DT, unstable_poles=0)
    session = session_of(written(tmp_path), measured=measured, name="loop")
    session.receive({"kind": "uncertain", "inertia_error": 0.1, "delay_error_s": 2e-4})
    shown = told(session, until="worst")["worst"]["margins"]
    late = np.exp(-2j * np.pi * lines * 2e-4)
    tough = [
        loop_margins(replace(measured, response=gain * values * turn)).phase_margin_deg_worst
        for gain in (1 / 0.9, 1 / 1.1)
        for turn in (1.0, late)
    ]
    assert shown["phase_margin_deg"] == pytest.approx(min(tough))
