"""The pytest plugin, part of every run: it imports nothing heavy until a test asks for it."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from jounce.app.gate.margins_regression import MarginsRegression


@pytest.fixture
def margins_regression(request: pytest.FixtureRequest) -> MarginsRegression:
    """Keep a loop's margins in a file beside the test: ``margins_regression.check(loop)``."""
    if find_spec("pytest_regressions") is None:
        pytest.fail(
            "margins_regression needs the package pytest-regressions: pip install 'jounce[pytest]'",
            pytrace=False,
        )
    from jounce.app.gate.margins_regression import MarginsRegression

    datadir, original = map(request.getfixturevalue, ("lazy_datadir", "original_datadir"))
    return MarginsRegression(datadir, original, request)
