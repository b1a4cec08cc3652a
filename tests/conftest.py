"""Hypothesis profiles (short and deterministic, long by JOUNCE_TIER=slow), and example surveys."""

import gc
import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

# Read when numpy is loaded, here and in processes of tests: matrices are small, and the threads
# of OpenBLAS only spin while the other workers of xdist would compute.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

settings.register_profile("fast", derandomize=True, deadline=None, max_examples=9)
settings.register_profile("slow", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile("slow" if os.environ.get("JOUNCE_TIER") == "slow" else "fast")


EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect tests without looking for garbage, which they never are: a quarter of the time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.set_threshold(20_000, 20, 20)  # to look at all that was collected takes half a second


def survey_of(name: str):
    from jounce.app import survey_file

    return survey_file(EXAMPLES / f"{name}.toml")


@pytest.fixture(scope="session")
def telescope():
    return survey_of("telescope")


@pytest.fixture(scope="session")
def published():
    return survey_of("telescope_published_gains")


@pytest.fixture(scope="session")
def rubin():
    return survey_of("rubin_mount")


@pytest.fixture(scope="session", autouse=True)
def _every_proof_is_checked():
    """Let the checker verify each proof of a minimum time that any test makes."""
    from jounce.shaping.optimal import half_bounds
    from jounce.shaping.optimal.proof_check import holds
    from jounce.shaping.optimal.whole.planner import Plan

    def checked(make):
        def proof(*given):
            made = make(*given)
            assert holds(made), made
            return made

        return proof

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plan, "proof", property(checked(Plan.proof.fget)))
        patch.setattr(half_bounds, "_proof", checked(half_bounds._proof))
        yield


@pytest.fixture(autouse=True)
def _no_figure_left():
    """Close the figures that a test leaves with pyplot, which keeps them for ever."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
