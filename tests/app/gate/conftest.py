"""A scenario in a file of its own."""

from pathlib import Path

import pytest
from gated_axis import AXIS


@pytest.fixture
def axis(tmp_path) -> Path:
    """Return a scenario file."""
    path = tmp_path / "axis.toml"
    path.write_text(AXIS, encoding="utf-8")
    return path
