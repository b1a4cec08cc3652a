"""The explorer's page, open in one browser for all tests of a module."""

import re

import pytest
from explored import session_of, written
from explorer_pages import Served, at_rest, chromium


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as context:
        yield context


@pytest.fixture
def path(tmp_path):
    return written(tmp_path)


@pytest.fixture
def served(path):
    own = Served(lambda: session_of(path))
    yield own
    own.stop()


@pytest.fixture
def page(browser, served):
    """Open the page; fail for any error or request that leaves the machine."""
    own, wrong = browser.new_page(), []
    own.on("pageerror", lambda error: wrong.append(str(error)))
    own.on(
        "request", lambda request: wrong.append(request.url) if is_foreign(request.url) else None
    )
    own.goto(served.address)
    at_rest(own)
    yield own
    own.close()
    assert wrong == []


def is_foreign(url):
    return not re.match(r"(http|ws)://127\.0\.0\.1:|data:|blob:", url)
