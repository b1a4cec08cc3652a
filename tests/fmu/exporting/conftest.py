"""Fixtures for tests that export."""

import pytest

from jounce.fmu.exporting import export_c as writing


@pytest.fixture
def unmeasured(monkeypatch):
    """Leave out what is measured of a firmware, which takes a second."""
    monkeypatch.setattr(writing, "measure", lambda *_: None)
