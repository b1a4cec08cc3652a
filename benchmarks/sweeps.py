"""A sweep of the telescope's azimuth axis, flexible, digital and delayed, beside single surveys.

Margins and settling at points of Sobol's sequence over inertia, mode, damping and delay, by all
processors as a sweep is called; beside it in the same run, in turn, the loop that surveys one
point after the other. The processor time of the sweep in one process says what a point costs
however busy the machine is. Memory: by how much the peak of one process grows from a short sweep
to a longer one, and what the figures kept of the points between them take.

Run: python benchmarks/sweeps.py
"""

from __future__ import annotations

from multiprocessing import get_context
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from time import perf_counter, process_time

from timing import table

from jounce.app import Normal, ScenarioSweep, Uniform, survey_file, sweep

AXIS = Path(__file__).parent.parent / "examples" / "telescope_azimuth.toml"
VARIED = {
    "plant.inertia": Uniform("900 kg m^2", "1100 kg m^2"),
    "plant.modes.structure.frequency": Normal("6 Hz", "0.1 Hz"),
    "plant.modes.structure.damping": Uniform("0.5 %", "2 %"),
    "controller.delay": Uniform("1.2 samples", "1.8 samples"),
}
FIGURES = (
    *("phase_margin", "lower_gain_margin", "upper_gain_margin", "modulus_margin"),
    *("load_settling",),
)
POINTS, ALONE, ROUNDS = 2048, 3, 2
SHORT, LONG = 128, 1024  # points whose memory is compared
GOAL = 10_000


def swept(points: int, workers: int | None = None) -> ScenarioSweep:
    """Sweep the axis."""
    return sweep(
        AXIS, VARIED, figures=FIGURES, samples=points, seed=1, workers=workers, progress=False
    )


def alone(sweep_of: ScenarioSweep, first: int, count: int) -> float:
    """Return the seconds that single surveys of points of a sweep take, one after the other."""
    cases = [sweep_of.case(k).overrides for k in range(first, first + count)]
    begin = perf_counter()
    for overrides in cases:
        survey_file(AXIS, overrides=overrides)
    return perf_counter() - begin


def processor_time(points: int) -> float:
    """Return the processor time of a point in one process, without what is done but once."""
    swept(64, 1)
    spent = []
    for count in (64, 64 + points):
        begin = process_time()
        swept(count, 1)
        spent.append(process_time() - begin)
    return (spent[1] - spent[0]) / points


def peak(points: int) -> int:
    """Return the peak of memory in use, in kB, of a process that has swept so many points."""
    swept(points, 1)
    return getrusage(RUSAGE_SELF).ru_maxrss


def peaks() -> list[int]:
    """Return the peaks of a short and a long sweep, each in a process of its own."""
    found = []
    for points in (SHORT, LONG):
        with get_context("spawn").Pool(1) as pool:
            found.append(pool.apply(peak, (points,)))
    return found


def rows() -> list[tuple[str, str]]:
    """Return the table."""
    known = swept(64)
    seconds, single = 0.0, 0.0
    for turn in range(ROUNDS):
        begin = perf_counter()
        swept(POINTS)
        seconds += perf_counter() - begin
        single += alone(known, turn * ALONE, ALONE)
    each, one = seconds / (ROUNDS * POINTS), single / (ROUNDS * ALONE)
    cost, (short, long) = processor_time(LONG), peaks()
    kept = (LONG - SHORT) * 8 * (len(FIGURES) + len(VARIED)) / 1e3
    return [
        ("points each second, all processors", f"{1.0 / each:.0f}"),
        (f"{GOAL} points", f"{GOAL * each:.0f} s"),
        ("single surveys each second, one after the other", f"{1.0 / one:.2f}"),
        ("sweep beside single surveys", f"{one / each:.0f} times"),
        ("processor time of a point", f"{1e3 * cost:.1f} ms"),
        (f"memory of {LONG - SHORT} more points", f"{long - short} kB"),
        ("their figures and parameters", f"{kept:.0f} kB"),
    ]


HEADER = ("margins and settling of the telescope axis", "")

if __name__ == "__main__":
    print(table(HEADER, rows()))
