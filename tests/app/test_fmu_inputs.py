"""CSV files of inputs: columns, units, how they are written, and one line for each error."""

import re
from math import pi

import numpy as np
import pytest

from jounce.app.fmu_inputs import read_inputs, value_at
from jounce.fmu.cosimulation.conversion import unit_of

UNITS = {"u": None, "angle": unit_of("rad"), "A[1,2]": None, "force": unit_of("N")}


@pytest.fixture
def read(tmp_path):
    """Read a text as a file of inputs."""

    def call(text, encoding="utf-8"):
        path = tmp_path / "in.csv"
        path.write_bytes(text.encode(encoding))
        return {name: (t.tolist(), v.tolist()) for name, (t, v) in read_inputs(path, UNITS).items()}

    return call


@pytest.mark.parametrize(
    "text",
    [
        "time,u,force\n0,1,2\n0.5,-3,4e2\n",
        "time;u;force\n0;1;2\n0,5;-3;4e2\n",
        "t\tu\tforce\n0\t1\t2\n0.5\t-3\t4e2\n",
        "\ufefftime_s, u , force\r\n\r\n# a remark\r\n0, 1, 2\r\n0.5, -3, 400.\r\n",
        'Time [s],"u","force [N]"\n0,1,2\n0.5,-3,400',
        "time [ms],u,force [kN]\n0,1,0.002\n500,-3,0.4\n",
        "time,u,force\n0,TRUE,2\n0.5,-3,400\n",
    ],
)
def test_the_same_table_however_it_is_written(read, text):
    found = read(text)
    assert list(found) == ["u", "force"]
    assert found["u"] == ([0.0, 0.5], [1.0, -3.0])
    np.testing.assert_allclose(found["force"], ([0.0, 0.5], [2.0, 400.0]), rtol=1e-15)


def test_units_and_elements_both_have_brackets(read):
    found = read('time,angle [deg],"A[1,2]"\n0,180,3\n')
    np.testing.assert_allclose(found["angle"], ([0.0], [pi]), rtol=1e-15)
    assert found["A[1,2]"] == ([0.0], [3.0])


def test_whole_numbers_keep_all_their_digits(tmp_path):
    path = tmp_path / "in.csv"
    path.write_text("time,u\n0,9007199254740993\n1,-5\n", encoding="utf-8")
    assert read_inputs(path, UNITS)["u"][1].tolist() == [9007199254740993, -5]


@pytest.mark.parametrize(
    "column",
    [[2**64 - 1, 1], [2**63 - 1, -(2**63)], [1234567890123456789, 0.5], [2**64 - 1, -1]],
    ids=["unsigned", "signed", "beside a fraction", "both"],
)
def test_integers_of_64_bits_keep_all_their_digits(tmp_path, column):
    path = tmp_path / "in.csv"
    path.write_text(f"time,u\n0,{column[0]}\n1,{column[1]}\n", encoding="utf-8")
    table = read_inputs(path, UNITS)["u"]
    assert table[1].tolist() == column
    assert [value_at(table, t, steps=True) for t in (0.0, 1.0)] == column
    assert value_at(table, 0.25, steps=False) == pytest.approx(0.75 * column[0] + 0.25 * column[1])


@pytest.mark.parametrize(
    ("time", "line", "held"), [(-1.0, 2.0, 2.0), (0.0, 2.0, 2.0), (0.5, 3.0, 2.0),
                               (1.0, 8.0, 8.0), (9.0, 6.0, 6.0)]
)  # fmt: skip
def test_one_value_of_a_table(time, line, held):
    table = (np.array([0.0, 1.0, 1.0, 2.0]), np.array([2.0, 4.0, 8.0, 6.0]))
    assert value_at(table, time, steps=False) == line
    assert value_at(table, time, steps=True) == held


def test_a_jump_is_two_rows_of_one_time(read):
    assert read("time,u\n0,0\n1,0\n1,5\n")["u"] == ([0.0, 1.0, 1.0], [0.0, 0.0, 5.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["in.csv", "no lines"]),
        ("time,u\n", ["in.csv", "no rows"]),
        ("time\n0\n", ["line 1", "no inputs"]),
        ("0,1\n1,2\n", ["line 1, column 1", "'0'", "begins with time"]),
        ("u,time\n1,0\n", ["line 1, column 1", "'u'", "begins with time"]),
        ("time,v\n0,1\n", ["line 1, column 2", "no input 'v'", "u"]),
        ("time,u,u\n0,1,2\n", ["line 1, column 3", "second column 'u'"]),
        ("time [m],u\n0,1\n", ["line 1, column 1", "in s", "m"]),
        ("time,force [m]\n0,1\n", ["line 1, column 2", "force is in N", "m"]),
        ("# x\ntime,u\n0,1\n\n1,\n", ["line 5, column 'u'", "'' is not a number"]),
        ("time,u\n0,one\n", ["line 2, column 'u'", "'one' is not a number"]),
        ("time,u\n0,nan\n", ["line 2, column 'u'", "'nan' is not a finite"]),
        ("time,u\ninf,1\n", ["line 2, column 'time'", "finite"]),
        ("time,u\n0,1\n1,2,3\n", ["line 3", "3 cells; expected 2"]),
        ("time,u\n0,1\n2,1\n1,1\n", ["line 4", "time 1 comes after 2", "sort"]),
    ],
    ids=repr,
)
def test_what_is_wrong_is_told_by_line_and_column(read, text, words):
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        read(text)
    assert all(word in str(caught.value) for word in words), caught.value


def test_files_that_cannot_be_read(read, tmp_path):
    with pytest.raises(ValueError, match="not UTF-8"):
        read("time,u\n0,1\n", encoding="utf-16")
    with pytest.raises(ValueError, match="No such file"):
        read_inputs(tmp_path / "none.csv", UNITS)
