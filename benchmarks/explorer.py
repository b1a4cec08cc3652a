"""From a handle dragged in the explorer to its numbers on the screen, in headless Chromium.

Two modes, a move, a notch that is dragged 200 times, 60 a second; margins of the model, or of 1,400
measured lines. Late is how long after the last change its numbers are there: nothing queues.

Run: python benchmarks/explorer.py   (needs the `explore` extra, playwright and Chromium)
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from timing import table

from jounce.app.scenario import load_scenario
from jounce.app.scenario_loop import servo_loop_of
from jounce.plant import zero_order_hold

MOVES, PACE_MS = 200, 16
LINES = 1400
SCENARIO = """
format = 2
title = "two modes"
position_unit = "mrad"
[plant]
inertia = "2 kg m^2"
viscous = "3 N m s/rad"
torque_limit = "300 N m"
modes = [
    { frequency = "61 Hz", damping = "0.6 %", motor_shape = 0.5, load_shape = -0.5 },
    { frequency = "140 Hz", damping = "1 %", motor_shape = 0.3, load_shape = 0.3 },
]
[controller]
gains = { kp = "2000 N m/rad", ki = "2e4 N m/(rad s)", kr = "60 N m s/rad" }
derivative_filter = "1 ms"
sample_time = "0.25 ms"
delay = "0.25 ms"
filters = [{ kind = "notch", frequency = "72 Hz", zero_damping = "5 %", pole_damping = "50 %" }]
[limits.axis]
velocity = "1 rad/s"
acceleration = "20 rad/s^2"
jerk = "1000 rad/s^3"
[[moves]]
name = "turn"
distance = "100 mrad"
settle_to = "0.05 mrad"
"""
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
HANDLE = '[data-handle="controller.filters[0]"]'


def measured(scenario: Path) -> Path:
    """Write the response of the scenario's plant with 2 % of noise; return the file."""
    loop = servo_loop_of(load_scenario(scenario))
    dt = loop.controller.sample_time
    held = zero_order_hold(loop.axis.system()[0, 0], dt, delay=loop.controller.delay)
    lines = np.linspace(1.0, 700.0, LINES)
    exact = np.array([held(point) for point in np.exp(2j * np.pi * lines * dt)])
    rng = np.random.default_rng(1)
    off = 0.02 / np.sqrt(2.0) * (rng.normal(size=LINES) + 1j * rng.normal(size=LINES))
    values, sigma = exact * (1.0 + off), 0.02 * abs(exact)
    path = scenario.with_name("plant.csv")
    columns = np.column_stack([lines, values.real, values.imag, sigma])
    head = "frequency [Hz],real,imag,sigma"
    np.savetxt(path, columns, delimiter=",", header=head, comments="")
    return path


@contextmanager
def served(*arguments: object) -> Iterator[str]:
    """Run `jounce explore` and give its address."""
    command = [sys.executable, "-c", "from jounce.app.command_line import main; main()"]
    process = subprocess.Popen(
        [*command, "explore", *map(str, arguments), "--no-browser"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait()


def dragged(page: Any, address: str) -> tuple[list[float], float]:
    """Return from each change to its numbers, and how late the last ones are, in ms."""
    page.goto(address)
    page.wait_for_selector('[data-idle="true"]')
    box = page.locator(HANDLE + " .hit").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate("document.getElementById('explorer').jounce.wire.latencies.length = 0")
    for step in range(MOVES):
        page.mouse.move(x + 60.0 * np.sin(step / 15.0), y + 20.0 * np.cos(step / 20.0))
        page.wait_for_timeout(PACE_MS)
    page.mouse.up()
    page.wait_for_selector('[data-idle="true"]')
    found = page.evaluate("document.getElementById('explorer').jounce.wire.latencies")
    return found, found[-1]


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: what margins are of, median, 95th percentile, lateness."""
    from playwright.sync_api import sync_playwright

    found = []
    with TemporaryDirectory() as folder, sync_playwright() as driver:
        scenario = Path(folder) / "two_modes.toml"
        scenario.write_text(SCENARIO, encoding="utf-8")
        data = measured(scenario)
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for name, options in (("the model", ()), ("1,400 measured lines", ("--frf", data))):
            with served(scenario, *options) as address:
                taken, late = dragged(browser.new_page(), address)
            times = f"{median(taken):.0f} ms", f"{quantiles(taken, n=20)[-1]:.0f} ms"
            found.append((name, *times, f"{late:.0f} ms", f"{len(taken)} of {MOVES}"))
        browser.close()
    return found


HEADER = ("margins of", "median", "95th percentile", "late", "shown")

if __name__ == "__main__":
    print(table(HEADER, rows()))
