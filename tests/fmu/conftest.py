"""Fixtures for tests that load FMUs."""

import gc
import tempfile
from pathlib import Path

import compiled_once
import pytest

binaries_compiled_once = compiled_once.binaries_compiled_once


@pytest.fixture
def nothing_left(tmp_path, monkeypatch):
    """See that no temporary folder outlives a test, and that the working directory stays."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    here = Path.cwd()
    yield
    if any((tmp_path / "temporary").iterdir()):
        gc.collect()  # which takes half a second late in a run of all tests
    assert list((tmp_path / "temporary").iterdir()) == []
    assert Path.cwd() == here
