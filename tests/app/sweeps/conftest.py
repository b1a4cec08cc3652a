"""The file of an axis to be swept."""

from pathlib import Path

import pytest
from swept_axis import AXIS


@pytest.fixture
def axis(tmp_path) -> Path:
    path = tmp_path / "axis.toml"
    path.write_text(AXIS, encoding="utf-8")
    return path
