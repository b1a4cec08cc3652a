"""What is shown of an FMU: items of enumerations, aliases, its experiment, whether it can run."""

from dataclasses import replace

from rich.console import Console

from jounce.app.fmu_report import fmu_tables
from jounce.fmu.importing.description import (
    Capabilities,
    DefaultExperiment,
    FmuDescription,
    FmuVariable,
)

SAYS = FmuDescription(
    "3.0",
    "drive",
    "drive",
    ("co-simulation",),
    "{}",
    variables=(
        FmuVariable("mode", 1, "Enumeration", "input", start=2, items=(("off", 1), ("on", 2))),
        FmuVariable("phi", 2, "Float64", "output", description="angle", aliases=("q", "angle_2")),
        FmuVariable("blob", 3, "Binary", "parameter", start=b"\0a", shape=(2,)),
    ),
    capabilities=Capabilities(fixed_internal_step=0.002),
    default_experiment=DefaultExperiment(stop_time=3.0, tolerance=1e-5),
)


def shown(description):
    console = Console(width=200)
    with console.capture() as captured:
        console.print(*fmu_tables(description))
    return captured.get()


def test_other_words_for_values_and_names():
    text = shown(SAYS)
    assert "1 = off, 2 = on" in text
    assert "angle; also q, angle_2" in text
    assert r"b'\x00a'" in text
    assert "stop 3 s, inner step 0.002 s, tolerance 1e-05" in text
    assert "must be exported" not in text


def test_one_that_cannot_be_run_says_so():
    text = shown(replace(SAYS, kinds=("model-exchange",)))
    assert "model-exchange only: to be run here, it must be exported for co-simulation" in text
