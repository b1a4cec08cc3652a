"""The explorer's page in headless Chromium, driven by playwright; skipped by name without them."""

import asyncio
import os
import shutil
import threading
from contextlib import contextmanager

import numpy as np
import pytest
from explored import NOTCH

from jounce.analysis import loop_margins
from jounce.app import load_scenario
from jounce.app.explorer.server import Server
from jounce.app.scenario_loop import servo_loop_of

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
CHROMIUM = shutil.which("chromium")
REQUIRED = os.environ.get("JOUNCE_BROWSER") == "required"
WAIT_MS = 30_000
HANDLE = f'[data-handle="{NOTCH}"]'


def missing():
    """Return what keeps tests from a browser, or nothing."""
    if CHROMIUM is None:
        return "no chromium on the path"
    try:
        import playwright  # noqa: F401
        import tomlkit  # noqa: F401
        import websockets  # noqa: F401
    except ImportError as error:
        return f"{error.name} is not installed"
    return ""


def needs_browser(*, whole=False):
    """Skip a module's tests without a browser; fail instead where one is required.

    Parameters
    ----------
    whole : bool
        Whether they are more than the fast tier has time for.
    """
    why = missing()
    if whole and not (REQUIRED or os.environ.get("JOUNCE_TIER") == "slow"):
        why = why or "`make test-browser` has all of it"
    if why and not REQUIRED:
        pytest.skip(f"the explorer in a browser: {why}", allow_module_level=True)
    assert not why, f"JOUNCE_BROWSER=required: {why}"


class Served:
    """A server in a thread of its own, which can be stopped and started again.

    Parameters
    ----------
    session : callable
        Makes a session for a page.
    """

    def __init__(self, session):
        self.server = Server(session, stay=True)
        self.address = ""
        self._session = session
        self.start()

    def start(self, port=0):
        """Serve from now on."""
        up = threading.Event()

        def started(address):
            self.address = address
            up.set()

        def run():
            self.loop = asyncio.new_event_loop()
            self.loop.run_until_complete(self.server.run(port, started))
            self.loop.close()

        self.thread = threading.Thread(target=run, daemon=True)
        self.thread.start()
        assert up.wait(20.0)

    def stop(self):
        """Be gone."""
        self.loop.call_soon_threadsafe(self.server.end)
        self.thread.join(20.0)
        assert not self.thread.is_alive()

    def again(self):
        """Come back under the same address."""
        port = int(self.address.split(":")[2].split("/")[0])
        token = self.server._token
        self.server = Server(self._session, stay=True)
        self.server._token = token
        self.start(port)


@contextmanager
def chromium(folder):
    """Run Chromium; give playwright's browser context, with a profile of its own."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        context = driver.chromium.launch_persistent_context(
            str(folder),
            executable_path=CHROMIUM,
            args=FLAGS,
            viewport={"width": 1280, "height": 900},
            accept_downloads=True,
        )
        context.set_default_timeout(WAIT_MS)
        try:
            yield context
        finally:
            context.close()


def at_rest(page):
    """Wait until all that was asked is shown."""
    page.wait_for_selector('#explorer[data-idle="true"]', state="attached")


def shown(page, name="phase_margin_deg"):
    """Return a margin on the page, to all digits; nan where there is none."""
    value = page.get_attribute(f'tr[data-margin="{name}"] td.now', "data-value")
    return float(value) if value else float("nan")


def margins(path, **values):
    return loop_margins(servo_loop_of(load_scenario(path, overrides=values)))


def field(page, key):
    return page.input_value(f'input[data-key="{key}"]')


def drag(page, by, up=0.0):
    """Drag the notch across and up by pixels."""
    box = page.locator(f"{HANDLE} .dot").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for share in np.linspace(0.2, 1.0, 5):
        page.mouse.move(x + share * by, y - share * up)
    page.mouse.up()
    at_rest(page)
