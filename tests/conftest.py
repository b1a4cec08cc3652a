"""Hypothesis profiles: a short deterministic tier, and a long one by JOUNCE_TIER=slow."""

import os
import sys

import pytest
from hypothesis import settings

settings.register_profile("fast", derandomize=True, deadline=None, max_examples=25)
settings.register_profile("slow", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile("slow" if os.environ.get("JOUNCE_TIER") == "slow" else "fast")


@pytest.fixture(autouse=True)
def _no_figure_left():
    """Close the figures that a test leaves with pyplot, which keeps them for ever."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
