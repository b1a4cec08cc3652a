"""Reading responses from files of all kinds, and what is said of bad ones."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from jounce.analysis import MeasuredResponse, read_frf

FOLDER = Path(__file__).parents[2] / "data" / "measured"
LINES = np.arange(1.0, 13.0)
VALUES = 3.0 / (1j * LINES + 2.0) / LINES


def rows(*columns, separator=",", comma=False):
    text = "\n".join(separator.join(f"{x:.10g}" for x in row) for row in zip(*columns, strict=True))
    return text.replace(".", ",") if comma else text


GAIN, DB = abs(VALUES), 20 * np.log10(abs(VALUES))
DEG, RAD = np.degrees(np.angle(VALUES)), np.angle(VALUES)
FILES = {
    "names": "frequency_hz,re,im\n" + rows(LINES, VALUES.real, VALUES.imag),
    "decibels": "Frequency (Hz),Magnitude (dB),Phase (deg)\n" + rows(LINES, DB, DEG),
    "order": "phase_rad,abs,f_kHz\n" + rows(RAD, GAIN, LINES / 1e3),
    "german": "Frequenz [Hz];Betrag [dB];Phase [°]\n"
    + rows(LINES, DB, DEG, separator=";", comma=True),
    "omega": "% w [rad/s]\tabs\tphase [rad]\n" + rows(2 * np.pi * LINES, GAIN, RAD, separator="\t"),
    "blanks": "f[Hz] mag phase[deg]\n" + rows(LINES, GAIN, DEG, separator=" ", comma=True),
    "preamble": "Analyser 7\nPoints: 12\nStart;1\n\nFrequency (Hz);Trace 1: Gain (dB);"
    "Trace 1: Phase (deg)\n" + rows(LINES, DB, DEG + 360, separator=";"),
    "with DC": "frequency_hz,re,im\n0,9,9\n" + rows(LINES, VALUES.real, VALUES.imag),
    "other columns": "n,frequency_hz,re,im,remark\n"
    + rows(LINES, LINES, VALUES.real, VALUES.imag, LINES),
}


def read(tmp_path, text, **options):
    path = tmp_path / "frf.csv"
    path.write_text(text, encoding="utf-8")
    return read_frf(path, **({"kind": "loop"} | options))


@pytest.mark.parametrize("name", FILES)
def test_every_layout_gives_the_same_response(name, tmp_path):
    found = read(tmp_path, FILES[name])
    assert found.kind == "loop"
    assert found.frequency_hz == pytest.approx(LINES)
    assert found.response == pytest.approx(VALUES, rel=1e-6)
    assert found.sigma is None


def test_columns_without_names_are_named_by_the_caller(tmp_path):
    text = rows(LINES, DB, DEG, LINES)
    with pytest.raises(ValueError, match="give columns="):
        read(tmp_path, text)
    for columns in (("Hz", "dB", "deg", "-"), "Hz,dB,deg,-"):
        assert read(tmp_path, text, columns=columns).response == pytest.approx(VALUES)
    in_rad = read(
        tmp_path, rows(LINES, GAIN, RAD), columns=("f", "abs", "rad"), frequency_unit="rad/s"
    )
    assert in_rad.frequency_hz == pytest.approx(LINES / (2 * np.pi))


def test_error_bars_are_read_or_come_from_coherence(tmp_path):
    bars = 0.01 * LINES
    text = "frequency_hz,re,im,sigma\n" + rows(LINES, VALUES.real, VALUES.imag, bars)
    assert read(tmp_path, text).sigma == pytest.approx(bars)
    square = np.full(12, 0.9)
    text = "frequency_hz,re,im,coherence\n" + rows(LINES, VALUES.real, VALUES.imag, square)
    assert read(tmp_path, text).sigma is None
    found = read(tmp_path, text, averages=20)
    assert found.sigma == pytest.approx(abs(VALUES) * np.sqrt(0.1 / 0.9 / 20))


def test_velocity_and_acceleration_are_integrated(tmp_path):
    text = FILES["names"]
    speed = read(tmp_path, text, kind="plant", output="velocity")
    assert speed.response == pytest.approx(VALUES / (2j * np.pi * LINES))
    twice = read(tmp_path, text, kind="plant", output="acceleration")
    assert twice.response == pytest.approx(VALUES / (2j * np.pi * LINES) ** 2)
    with pytest.raises(ValueError, match="of a plant alone"):
        read(tmp_path, text, output="velocity")


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("frequency_hz,re,im\n1,2,3\n", {}, "one row of numbers"),
        ("nothing here\n", {}, "no rows of numbers"),
        (FILES["names"].replace("\n5,", "\n,"), {}, "line 6 .* is not a row of 3 numbers"),
        (FILES["names"].replace("\n5,", "\n5,1,"), {}, "has 4 numbers|not a row"),
        (FILES["names"].replace("\n5,", "\n4,"), {}, "frequency 4 Hz is there twice"),
        (FILES["names"].replace("\n5,", "\n3.5,"), {}, "falls from 4 to 3.5 Hz"),
        ("frequency_hz,re,im\n" + "\n".join(f"{n},nan,0" for n in LINES), {}, "nan.* at 1 Hz"),
        ("freq,psd_x,psd_y\n" + rows(LINES, GAIN, GAIN), {}, "power spectrum"),
        ("freq_hz,gain_x\n" + rows(LINES, GAIN), {}, "hold no complex response"),
        ("gain,phase_deg\n" + rows(GAIN, DEG), {}, "is a frequency"),
        ("f_hz,omega,re,im\n" + rows(LINES, LINES, GAIN, GAIN), {}, "are both frequency"),
        ("f_hz,abs,phase\n" + rows(LINES, GAIN, RAD), {}, "fit both degrees and rad"),
        (FILES["names"], {"frequency_unit": "rad/s"}, "is in Hz"),
        (FILES["names"], {"columns": ("Hz", "dB")}, "2 names for the 3 columns"),
        (FILES["names"], {"columns": ("Hz", "dB", "so")}, "'so' is not known"),
        (FILES["names"], {"kind": "open"}, "kind = 'open'"),
        (FILES["names"], {"dt": 0.1}, "above half the sampling frequency"),
        ("frequency_hz,re,im\n" + "1,2,3\n" * 300_000, {}, "300001 lines"),
    ],
)
def test_a_bad_file_is_told_in_one_line(text, options, words, tmp_path):
    with pytest.raises(ValueError, match=words) as told:
        read(tmp_path, text, **options)
    assert "\n" not in str(told.value)


def test_a_file_that_is_not_there_is_told(tmp_path):
    for name in ("no.csv", "no.uff", "no.mat"):
        with pytest.raises(ValueError, match="cannot be read"):
            read_frf(tmp_path / name, kind="loop")


def test_mat_files_hold_vectors_or_a_structure(tmp_path):
    content = {"Frequency": LINES, "ResponseData": VALUES.reshape(1, 1, -1), "Units": "Hz"}
    for name, stored in (("a.mat", content), ("b.mat", {"G": content})):
        savemat(tmp_path / name, stored)
        assert read_frf(tmp_path / name, kind="loop").response == pytest.approx(VALUES)
    savemat(tmp_path / "c.mat", {"w": LINES, "H": VALUES})
    found = read_frf(tmp_path / "c.mat", kind="loop")
    assert found.frequency_hz == pytest.approx(LINES / (2 * np.pi))
    savemat(tmp_path / "d.mat", {"u": LINES, "y": LINES})
    with pytest.raises(ValueError, match="estimate_frf"):
        read_frf(tmp_path / "d.mat", kind="loop")


def test_mat_files_of_version_7_3_are_read(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "new.mat"
    pair = np.zeros((12, 1), dtype=[("real", float), ("imag", float)])
    pair["real"][:, 0], pair["imag"][:, 0] = VALUES.real, VALUES.imag
    with h5py.File(path, "w", userblock_size=512) as file:
        file["G/Frequency"], file["G/ResponseData"] = LINES[:, None], pair
    assert read_frf(path, kind="plant").response == pytest.approx(VALUES)


def test_binary_universal_files_are_read(tmp_path):
    path = tmp_path / "new.uff"
    text = (FOLDER / "stage_ascii.uff").read_text(encoding="utf-8").splitlines()[2:13]
    text[6] = "         6        12         1  1.00000e+00  1.00000e+00  0.00000e+00"
    data = np.stack([VALUES.real, VALUES.imag], axis=1).astype("<f8").tobytes()
    zeros = "     0     0           0           0"
    start = f"    -1\n    58b     1     2          11{len(data):12d}{zeros}\n"
    head = start + "".join(f"{line:<80}\n" for line in text)
    path.write_bytes(head.encode() + data + b"\n    -1\n")
    pytest.importorskip("pyuff")
    found = read_frf(path, kind="plant")
    assert found.response == pytest.approx(VALUES)
    assert found.frequency_hz == pytest.approx(LINES)


def test_responses_become_python_control_data_and_come_back():
    frf = MeasuredResponse(LINES, VALUES, 0.01 * LINES, kind="plant", dt=1e-3, integrators=1)
    back = MeasuredResponse.from_frd(frf.to_frd(), kind="plant", sigma=frf.sigma, integrators=1)
    assert back.frequency_hz == pytest.approx(LINES)
    assert back.response == pytest.approx(VALUES)
    assert (back.dt, back.integrators) == (1e-3, 1)
    with pytest.raises(ValueError, match="read-only"):
        back.response[0] = 0.0
