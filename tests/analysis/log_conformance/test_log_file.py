"""Logs in CSV files of many makes, and what is wrong in them told by line."""

import numpy as np
import pytest

from jounce.analysis.log_conformance import read_log

TIMES, POSITIONS = [0.0, 0.1, 0.2], [1.5, -1.75, 2e-3]


@pytest.fixture
def write(tmp_path):
    def written(text, encoding="utf-8"):
        path = tmp_path / "axis.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return written


@pytest.mark.parametrize(
    "text",
    [
        "0,1.5\n0.1,-1.75\n0.2,2e-3\n",
        "0, 1.5\r\n0.1, -1.75\r\n0.2, 0.002\r\n",
        "t,x\n0,1.5\n0.1,-1.75\n0.2,2e-3",
        "time;position\ns;mm\n0;1,5\n0,1;-1,75\n0,2;0,002\n",
        "# a logger\n\n0\t1.5\n0.1\t-1.75\n# pause\n0.2\t2e-3\n",
        "t   x\n 0   1.5\n 0.1 -1.75\n 0.2  2E-3\n",
        "0,5 1\n".replace("0,5 1", "0 1,5") + "0,1 -1,75\n0,2 0,002\n",
        '"t","x"\n"0","1.5"\n"0.1","-1.75"\n"0.2","2e-3"\n',
        "\ufefft,x\n0,1.5\n0.1,-1.75\n0.2,2e-3\n",
        "0,1.5\n0.05,\n0.1,-1.75\n0.15,NaN\n0.2,2e-3\n,3\n",
        "0;1.5;run\n0.1;-1.75;run\n0.2;2e-3;stop\n",
    ],
    ids=[
        "plain",
        "windows",
        "header",
        "german with units",
        "tabs and comments",
        "blanks",
        "blanks and decimal commas",
        "quoted",
        "byte order mark",
        "gaps",
        "text beside",
    ],
)
def test_makes_of_logs(write, text):
    times, positions = read_log(write(text))
    np.testing.assert_array_equal(times, TIMES)
    np.testing.assert_array_equal(positions, POSITIONS)


WIDE = "Drive 7, 3.2\nindex,x [mm],t [s],state\n1,1.5,0,on\n2,-1.75,0.1,on\n3,2e-3,0.2,\n"


@pytest.mark.parametrize("columns", [("t [s]", "x [mm]"), (2, "x [mm]"), ("t [s]", -3)])
def test_columns_by_name_and_number(write, columns):
    times, positions = read_log(write(WIDE), *columns)
    np.testing.assert_array_equal(times, TIMES)
    np.testing.assert_array_equal(positions, POSITIONS)


def test_other_encodings_of_the_header(write):
    times, positions = read_log(write("t;x in µm\n0;1,5\n0,1;-1,75\n0,2;0,002\n", "latin-1"))
    np.testing.assert_array_equal(times, TIMES)
    np.testing.assert_array_equal(positions, POSITIONS)


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("", (), r"axis.csv has no rows: expected a time and a position"),
        ("# nothing\n\n", (), r"axis.csv has no rows"),
        ("0,1\n0.1,x\n", (), r"axis.csv, line 2: 'x' is not a number$"),
        ("# c\n\nt,x\n0,1\n0.1,1.2.3\n", (), r"axis.csv, line 5: '1.2.3' is not a number$"),
        ("0,1\n0.1,2\n0.2\n", (), r"axis.csv, line 3: 1 cell, so no column 1"),
        ("0,1,2\n1,2,3\n0,1\n", (0, 2), r"axis.csv, line 3: 2 cells, so no column 2"),
        ("t,x\n0,1\n0.1,inf\n", (), r"axis.csv, line 3: 'inf' is not a finite number$"),
        ("0,1\n1e999,2\n", (), r"axis.csv, line 2: '1e999' is not a finite number$"),
        ("x,t,x\n0,1,2\n", ("t", "x"), r"columns 0, 2 are all named 'x': give a number$"),
        ("0\n1\n2\n", (), r"no column 1: rows have 1, counted from 0"),
        ("0,1\n1,2\n", (0, 2), r"no column 2: rows have 2, counted from 0"),
        ("0,1\n1,2\n", (0, -3), r"no column -3: rows have 2"),
        ("t,x\n0,1\n", ("t", "y"), r"no column 't' or 'y': found 't', 'x'"),
        ("t,x\n0,1\n", ("t", 0), r"time and position are both column 0"),
        ("t,x\na,b\n", (), r"no row has numbers in columns 0 and 1"),
        ("t,x\n,\n", (), r"no row has numbers"),
    ],
    ids=[
        "empty",
        "only comments",
        "text",
        "text after comments",
        "short row",
        "shorter row",
        "infinite",
        "beyond doubles",
        "name given twice",
        "one column",
        "too far",
        "too far back",
        "unknown name",
        "same column",
        "only text",
        "only blanks",
    ],
)
def test_faults_are_told(write, text, columns, message):
    with pytest.raises(ValueError, match=message):
        read_log(write(text), *columns)


@pytest.mark.parametrize(("name", "columns"), [("time", (1.5, 1)), ("position", (0, None))])
def test_columns_of_other_types_are_refused(write, name, columns):
    with pytest.raises(TypeError, match=rf"^{name} = .*: expected the number of a column, from 0"):
        read_log(write("0,1\n"), *columns)


def test_a_name_given_twice_that_is_not_asked_for(write):
    times, positions = read_log(write("x,t,y,x\n0,1,2,3\n"), "t", "y")
    assert (times.tolist(), positions.tolist()) == ([1.0], [2.0])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_other_unicode_is_named(write, encoding):
    with pytest.raises(ValueError, match=r"axis.csv is in UTF-16, or no text: save it as UTF-8$"):
        read_log(write("t,x\n0,1\n1,2\n", encoding))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_log(tmp_path / "none.csv")


def test_every_digit_is_kept(write):
    rng = np.random.default_rng(0)
    times, positions = np.cumsum(rng.uniform(size=500)), rng.normal(size=500)
    text = "".join(
        f"{t!r},{x!r}\n" for t, x in zip(times.tolist(), positions.tolist(), strict=True)
    )
    found = read_log(write("t,x\n" + text), "t", "x")
    np.testing.assert_array_equal(found[0], times)
    np.testing.assert_array_equal(found[1], positions)
