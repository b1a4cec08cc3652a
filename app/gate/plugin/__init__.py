"""The pytest plugin, part of every run: it imports nothing heavy until a test asks for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from pytest_datadir.plugin import LazyDataDir

    from jounce.app.gate.margins_regression import MarginsRegression


@pytest.fixture
def margins_regression(
    lazy_datadir: LazyDataDir, original_datadir: Path, request: pytest.FixtureRequest
) -> MarginsRegression:
    """Keep a loop's margins in a file beside the test: ``margins_regression.check(loop)``."""
    from jounce.app.gate.margins_regression import MarginsRegression

    return MarginsRegression(lazy_datadir, original_datadir, request)
