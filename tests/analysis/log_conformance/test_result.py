"""The report as text: every number and verdict, and how far jerk can be trusted."""

import re

import numpy as np
import pytest

from jounce.analysis.log_conformance import conformance
from jounce.shaping import Limits, min_time_move

NUMBER = r"[−+]?\d[\d.]*(?:e[+-]\d+)?"


@pytest.fixture(scope="module")
def readings():
    move = min_time_move(1.5, Limits(velocity=1.0, acceleration=2.0, jerk=20.0))
    times = np.linspace(-0.2, move.duration + 0.2, 2500)
    return times, 1e-4 * np.round(move(times) / 1e-4)


def lines(report):
    return str(report).splitlines()


def joined(report):
    return " ".join(str(report).split())


def test_the_table(readings):
    limits = Limits(velocity=1.1, acceleration=(-1.8, 2.3), jerk=25.0)
    report = conformance(*readings, limits, resolution=1e-4)
    shown = {line.split("  ")[1]: line for line in lines(report) if line.startswith("  ")}
    for peak in report.peaks:
        row = shown[peak.name]
        numbers = [float(text.replace("−", "-")) for text in re.findall(NUMBER, row)]
        assert numbers[0] == pytest.approx(peak.used, rel=1e-4)
        assert -numbers[1] == pytest.approx(peak.used - peak.least, rel=0.05)
        assert numbers[2] == pytest.approx(peak.most - peak.used, rel=0.05)
        assert numbers[-1] == peak.limit
        assert row.endswith(peak.verdict)
    assert {peak.verdict for peak in report.peaks} == {"kept", "broken", "cannot tell"}


def test_the_notes(readings):
    report = conformance(*readings, Limits(velocity=1.1), resolution=1e-4)
    text = joined(report)
    assert "Conformance of 2500 readings" in text
    assert f"Noise of a reading {report.noise:.3g}, resolution 0.0001" in text
    lasting = f"an excess that lasts a time of less than {report.resolved_time:.3g}"
    assert f"{lasting} may not be seen" in text
    assert "No upper end" not in text
    assert re.search(r"Jerk is unreliable: noise alone makes ±\d+ % of the peak used", text)
    assert "tolerance" not in text
    assert "Snap" not in text
    assert max(map(len, lines(report))) <= 100


def test_further_notes(readings):
    text = joined(conformance(*readings, Limits(velocity=1.1, snap=1e3), tolerance=0.02))
    assert "kept up to 2 % above it" in text
    assert "Snap and above cannot be taken from a log: leave their limits out." in text


def test_gaps_and_pauses_are_told(readings):
    times, positions = readings
    kept = np.abs(times - 1.0) > 0.04
    text = joined(conformance(times[kept], positions[kept], Limits(1.1)))
    assert "0.0801 go by without a reading" in text or "0.081 go by without a reading" in text
    later = np.where(times > 1.0, times + 3.0, times)
    text = joined(conformance(later, positions, Limits(1.1)))
    assert "Pauses of up to 3 part the log: nothing is said of what happened meanwhile." in text
    ends = np.append(later, later[-1] + 50.0 + 0.01 * np.arange(9))
    text = joined(conformance(ends, np.append(positions, np.ones(9)), Limits(1.1)))
    assert "nor of 9 readings in parts too short" in text


def test_peaks_without_an_upper_end(readings):
    times, positions = readings
    coarse = conformance(times, 0.2 * np.round(positions / 0.2), Limits(1.1, 1.8, 25.0))
    text = joined(coarse)
    assert "No upper end can be given for acceleration, jerk: the derivative" in text
    assert "Snap" not in text
    [row] = [line for line in lines(coarse) if line.startswith("  jerk")]
    assert re.search(r" \+∞ ", row)
    assert row.endswith("cannot tell")


def test_long_numbers_stay_whole(readings):
    times, positions = readings
    limits = Limits(velocity=(-1.234567e9, 1.234567e-9), jerk=(-1.0, 2.0))
    report = conformance(times, 1e-9 * positions, limits)
    for expected in ("1.23457e+09", "1.23457e-09", "jerk −", "jerk +"):
        assert any(expected in line for line in lines(report))


def test_a_log_at_rest():
    report = conformance(np.arange(100.0), np.ones(100), Limits(1.0), resolution=0.1)
    assert "nan" not in str(report)
    assert "kept" in str(report)
