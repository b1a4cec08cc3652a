"""What cannot be used of files, responses and records is one line, without a warning before it."""

import numpy as np
import pytest

from jounce.analysis import (
    MeasuredResponse,
    estimate_frf,
    loop_margins,
    multisine,
    read_frf,
    repeated_margins,
)

LINES = np.arange(1.0, 31.0)
G = 100 / (2j * np.pi * LINES * (2j * np.pi * LINES + 30))
N = 400
W = np.random.default_rng(0).normal(size=N)
Y = np.cumsum(W) * 0.01


def rows(*extra):
    numbers = np.column_stack([LINES, G.real, G.imag])
    cells = [[f"{value:.6g}" for value in row] + list(extra) for row in numbers]
    return [",".join(row) for row in cells]


def with_row(text):
    return ["frequency_hz,re,im", *rows()[:9], text, *rows()[9:]]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (with_row("9.5,nan,1"), "at 9.5 Hz: expected finite numbers; leave the line out"),
        (with_row("9.5,inf,1"), "at 9.5 Hz: expected finite numbers; leave the line out"),
        (with_row("9.5,,1"), "'9.5,,1' is not a row of 3 numbers"),
        (with_row("9,1,1"), "frequency 9 Hz is there twice"),
        (with_row("3.5,1,1"), "frequency falls from 9 to 3.5 Hz"),
        (["frequency_hz,re,im", *rows()[::-1]], "frequency falls from 30 to 29 Hz.*sort the lines"),
        (["frequency_hz,re,im", rows()[0]], "one row of numbers"),
        (["frequency_hz,re,im", *(f"{hz},0,0" for hz in LINES)], "response is 0 on every line"),
        (["freq_hz,mag_db,phase_deg", *(f"{hz},9999,0" for hz in LINES)], "expected finite"),
        (
            ["freq_hz,mag_abs,phase_deg", *(f"{hz},-0.5,0" for hz in LINES)],
            "expected magnitudes, 0",
        ),
        (["freq_hz,mag_abs,mag_db,phase_deg", *(f"{hz},1,0,0" for hz in LINES)], "are both gain"),
        (["frequency_hz,re,im,coherence", *rows("98")], "divide percentages by 100"),
        (["frequency_hz,re,im,coherence", *rows("nan")], "expected coherences from 0 to 1"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_line(tmp_path, lines, told):
    path = tmp_path / "axis.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(ValueError, match=told) as error:
        read_frf(path, kind="loop", averages=20)
    assert "\n" not in str(error.value)


def test_a_million_lines_are_refused_before_they_are_read(tmp_path):
    path = tmp_path / "axis.csv"
    path.write_text("frequency_hz,re,im\n" + "1,2,3\n" * 1_000_000, encoding="utf-8")
    with pytest.raises(ValueError, match="1000001 lines: expected 200000 at the most"):
        read_frf(path, kind="loop")


@pytest.mark.parametrize(
    ("kind", "value", "told"),
    [("sensitivity", 0.0, "S = 0 at 5 Hz"), ("complementary", 1.0, "T = 1 at 5 Hz")],
)
def test_a_loop_that_is_infinite_on_a_line_is_told(kind, value, told):
    values = 0.5 * G / abs(G)
    values[4] = value
    with pytest.raises(ValueError, match=told):
        loop_margins(MeasuredResponse(LINES, values, kind=kind))


@pytest.mark.parametrize(
    ("records", "options", "told"),
    [
        ((W, W, Y[:-5]), {}, "records of unequal length, in samples: excitation 400, u 400, y 395"),
        (([], [], []), {}, r"excitation of shape \(1, 0\): expected a record, or"),
        ((W[:9], W[:9], Y[:9]), {}, "records of 9 samples: expected 16 or more"),
        ((W.reshape(2, 2, 100),) * 3, {}, "one in each row"),
        ((W, W, Y), {"period": 500}, "expected a whole number from 4 to 400"),
        ((W, W, Y), {"dwells": [(100.0, 0.0, 9.0)]}, "within the records, 0 to 0.4 s"),
        ((W, W, np.zeros(N)), {}, "y is constant"),
    ],
)
def test_records_that_do_not_fit_are_told(records, options, told):
    with pytest.raises(ValueError, match=told):
        estimate_frf(*records, 1e-3, **options)


def test_measurements_have_names():
    with pytest.raises(TypeError, match="measured is a list: expected responses by name"):
        repeated_margins([MeasuredResponse(LINES, G, kind="loop")])


def universal(form, data):
    """Return a universal file of ten lines, 1 to 10 Hz, in ascii or binary."""
    channels = "          y         1   1          u         1   1"
    header = ["id", *["NONE"] * 4, f"    4         0    0         0{channels}"]
    header += ["         6        10         1  1.00000e+00  1.00000e+00  0.00000e+00"]
    header += ["        18    0    0    0 NONE                 NONE"] * 4
    size = f"          11{len(data):12d}     0     0           0           0"
    kind = f"    58b     1     2{size}" if form == "binary" else "    58"
    return "\n".join(["    -1", *(f"{line:<80}" for line in (kind, *header)), ""]).encode() + data


ASCII = "".join(f"{value.real:20.11e}{value.imag:20.11e}\n" for value in G[:10]).encode()
BINARY = np.ascontiguousarray(G[:10]).astype("<c16").tobytes()
END = b"\n    -1\n"


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (universal("ascii", ASCII[:200]), "5 of 10 values"),
        (universal("ascii", ASCII[:205] + END), "not as its header says"),
        (universal("ascii", b" " * 17 + b"nan" + ASCII[20:] + END), "at 1 Hz: expected finite"),
        (universal("binary", BINARY[:40]), "holds no whole dataset 58"),
        (universal("binary", b"")[:180] + b"\n" * 9 + END, "no binary universal file"),
        (b"", "holds no whole dataset 58"),
    ],
    ids=["cut", "short", "nan", "binary cut", "binary header", "empty"],
)
def test_a_universal_file_that_cannot_be_used_is_one_line(tmp_path, content, told):
    pytest.importorskip("pyuff")
    path = tmp_path / "axis.uff"
    for form, data in (("ascii", ASCII), ("binary", BINARY)):
        path.write_bytes(universal(form, data) + END)
        assert read_frf(path, kind="plant").response == pytest.approx(G[:10], rel=1e-9)
    path.write_bytes(content)
    with pytest.raises(ValueError, match=told) as error:
        read_frf(path, kind="plant")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "kind", "told"),
    [
        ({"weight": 2.0}, TypeError, "weight = 2.0: expected a function"),
        ({"weight": lambda f: 0.0 * f}, ValueError, "not all 0"),
        ({"weight": lambda f: np.nan * f}, ValueError, "finite amplitudes"),
        ({"weight": lambda f: f[:3]}, ValueError, "weight of 199 frequencies gives"),
        ({"band_hz": 200.0}, TypeError, "band_hz = 200.0: expected the lowest and highest"),
    ],
)
def test_a_multisine_that_cannot_be_is_told(options, kind, told):
    with pytest.raises(kind, match=told):
        multisine(1e-3, 1000, **{"band_hz": (2.0, 200.0), "torque": 1.0} | options)
