"""Quantities: hand-computed values, refusals, and arbitrary text."""

import math
import time

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from jounce.app.units import (
    DURATION,
    FREQUENCY,
    Kind,
    UnitError,
    conversion,
    convert,
    factor,
    motion_kind,
    parse_any,
    parse_motion,
    parse_quantity,
    parse_unit,
    parted,
    show,
    unit_of,
)

TORQUE = Kind(name="a torque", unit="N m", example="2 N m")
STIFFNESS = Kind(name="a stiffness", unit="N m/rad", example="2 N m/rad")
INERTIA = Kind(name="an inertia", unit="kg m^2", example="2 kg m^2")
PERCENTAGE = Kind(name="a percentage", unit="%", example="10 %", above=0.0, below=100.0)
DECIBELS = Kind(name="a ratio in dB", unit="dB", example="12 dB")
REFUSED = [
    ("", "is empty"),
    ("   ", "is empty"),
    ("5", "has no unit"),
    (5, "has no unit"),
    (5.0, "has no unit"),
    (10**400, "has no unit"),
    (math.nan, "is not finite"),
    ("nan m", "is not finite"),
    ("-inf m", "is not finite"),
    ("Infinity", "is not finite"),
    ("1e400 m", "outside the range"),
    ("1e-400 m", "outside the range"),
    ("1e308 km", "outside the range"),
    ("1e-320 mas", "outside the range"),
    ("1e99999999999999999999 m", "outside the range"),
    ("1e999999 km", "outside the range"),
    (True, "is not a quantity in quotation marks"),
    (None, "is not a quantity in quotation marks"),
    (["5 m"], "is not a quantity in quotation marks"),
    ({"value": 5}, "a table is not a quantity in quotation marks"),
    ("3 parsec", "unknown unit 'parsec'"),
    ("3 ARCSEC", "unknown unit 'ARCSEC'"),
    ("5 s", "wrong dimension"),
    ("5 m^2", "wrong dimension"),
    ("5 m/s", "wrong dimension"),
    ("metres", "is not a number followed by a unit"),
    ("five m", "is not a number followed by a unit"),
    ("1_000 m", "no readable unit"),
    ("1,5 m", "no readable unit"),
    ("5 m to 6 m", "no readable unit"),
    ("5 m^0.5", "no readable unit"),
    ("5 m^100", "no readable unit"),
    ("9**9**9**9 m", "no readable unit"),
    ("5 m**9**9**9", "no readable unit"),
    ("5 (m", "no readable unit"),
    ("5 __import__('os')", "no readable unit"),
    ("5 N m/rad s", "a product in a denominator needs parentheses"),
    ("5 " + "m " * 1000, "is not a number followed by a unit"),
]


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("2 ms", DURATION, 0.002),
        ("1.5 min", DURATION, 90.0),
        ("0.5 hour", DURATION, 1800.0),
        ("7 us", DURATION, 7e-6),
        ("7 µs", DURATION, 7e-6),
        ("40 ns", DURATION, 4e-8),
        ("2 Hz", FREQUENCY, 2.0),
        ("1 kHz", FREQUENCY, 1000.0),
        ("3 MHz", FREQUENCY, 3e6),
        ("120 rpm", FREQUENCY, 2.0),
        ("2 N m", TORQUE, 2.0),
        ("2 kN*mm", TORQUE, 2.0),
        ("2 N·m", TORQUE, 2.0),
        ("3 N m / rad", STIFFNESS, 3.0),
        ("500 g m^2", INERTIA, 0.5),
        ("2 tonne m²", INERTIA, 2000.0),
        ("1 N m s**2", INERTIA, 1.0),
        ("10 %", PERCENTAGE, 10.0),
        ("10percent", PERCENTAGE, 10.0),
        ("12dB", DECIBELS, 12.0),
        ("-.5 dB", DECIBELS, -0.5),
    ],
)
def test_quantities_are_returned_in_the_unit_of_their_kind(text, kind, value):
    assert parse_quantity(text, kind) == value


@pytest.mark.parametrize(
    ("text", "derivative", "value", "motion"),
    [
        ("1.5e-3 rad", 0, 0.0015, "angle"),
        ("180 deg", 0, math.pi, "angle"),
        ("60 arcsec", 0, math.pi / 10800, "angle"),
        ("60″", 0, math.pi / 10800, "angle"),
        ("90°", 0, math.pi / 2, "angle"),
        ("2 arcmin", 0, math.pi / 5400, "angle"),
        ("50 mas", 0, math.pi / 12960000, "angle"),
        ("3 urad", 0, 3e-6, "angle"),
        ("3 mrad", 0, 3e-3, "angle"),
        ("-0.5 turn", 0, -math.pi, "angle"),
        ("1 rev/s", 1, math.tau, "angle"),
        ("1 Hz", 1, math.tau, "angle"),
        ("0.2 deg / s^2", 2, math.pi / 900, "angle"),
        ("18 deg s^-3", 3, math.pi / 10, "angle"),
        ("18 deg/s**3", 3, math.pi / 10, "angle"),
        ("18 deg/(s s s)", 3, math.pi / 10, "angle"),
        ("18 deg/s/s/s", 3, math.pi / 10, "angle"),
        ("1 rad/ms^12", 12, 1e36, "angle"),
        ("5 mm", 0, 0.005, "length"),
        ("1 inch", 0, 0.0254, "length"),
        ("−5 µm", 0, -5e-6, "length"),
        ("5 um", 0, 5e-6, "length"),
        ("7 nm", 0, 7e-9, "length"),
        ("2 km", 0, 2000.0, "length"),
        ("+3.m/s", 1, 3.0, "length"),
        ("60 m/min", 1, 1.0, "length"),
    ],
)
def test_motions_are_read_in_si_with_what_they_are(text, derivative, value, motion):
    found, what = parse_motion(text, derivative)
    assert what == motion
    assert found == pytest.approx(value, rel=4e-16, abs=0.0)


@pytest.mark.parametrize(("text", "reason"), REFUSED, ids=[repr(text)[:30] for text, _ in REFUSED])
def test_a_refusal_names_the_value_the_reason_and_what_to_write(text, reason):
    with pytest.raises(UnitError) as refusal:
        parse_motion(text, 0)
    message = str(refusal.value)
    assert show(text) in message
    assert reason in message
    assert "write an angle such as '5 deg' or a length such as '5 mm'" in message
    assert "\n" not in message


def test_angular_frequency_and_frequency_are_told_apart_and_both_right():
    assert parse_quantity("6.283185307179586 rad/s", FREQUENCY) == pytest.approx(1.0, rel=4e-16)
    for text in ("1 1/s", "1 s^-1"):
        with pytest.raises(UnitError, match="write a positive frequency such as '2 Hz'"):
            parse_quantity(text, FREQUENCY)


def test_torque_is_no_stiffness():
    with pytest.raises(UnitError, match="'2 N m' has the wrong dimension; write a stiffness"):
        parse_quantity("2 N m", STIFFNESS)


@pytest.mark.parametrize("text", ["0 %", "-3 %", "100 %", "1e9 %"])
def test_open_bounds_exclude_their_ends(text):
    with pytest.raises(UnitError, match=f"'{text}' is out of range; write a percentage"):
        parse_quantity(text, PERCENTAGE)


def test_closed_bound_admits_its_end():
    kind = Kind(name="a torque from zero", unit="N m", example="2 N m", least=0.0)
    assert parse_quantity("0 N m", kind) == 0.0
    with pytest.raises(UnitError, match="out of range"):
        parse_quantity("-1e-9 N m", kind)


@pytest.mark.parametrize("text", ["0 m/s^3", "-1 deg/s^3"])
def test_positive_motions_refuse_zero_and_below(text):
    with pytest.raises(UnitError, match="a positive angular jerk such as '5 deg/s\\^3'"):
        parse_motion(text, 3, positive=True)


def test_the_first_kind_of_the_dimension_is_taken():
    assert parse_any("3 N m/rad", (TORQUE, STIFFNESS)) == (3.0, STIFFNESS)


@pytest.mark.parametrize(
    ("motion", "derivative", "name"),
    [
        ("angle", 0, "an angle"),
        ("length", 0, "a length"),
        ("angle", 1, "an angular velocity"),
        ("length", 2, "an acceleration"),
        ("length", 6, "a pop"),
        ("angle", 8, "an angular derivative 8"),
    ],
)
def test_kinds_of_motion_are_named_and_accept_their_own_example(motion, derivative, name):
    kind = motion_kind(motion, derivative)
    assert kind.name == name
    assert parse_motion(kind.example, derivative) == (parse_quantity(kind.example, kind), motion)


def test_factor_and_convert_are_inverse():
    assert factor("arcsec") == math.pi / 648000
    assert factor("Hz") == math.tau
    assert convert(math.pi, "deg") == pytest.approx(180.0, rel=4e-16)
    assert convert(parse_motion("7 um/s", 1)[0], "um/s") == pytest.approx(7.0, rel=4e-16)


@pytest.mark.parametrize("unit", ["", "5 m", "parsec", "m/s m", "m^1000"])
def test_factor_refuses_what_is_no_unit(unit):
    with pytest.raises(UnitError, match="write a unit such as 'arcsec'") as refusal:
        factor(unit)
    assert repr(unit) in str(refusal.value)


def test_units_are_checked_alone_and_taken_from_quantities():
    angle = motion_kind("angle", 0)
    assert parse_unit(" µrad ", [angle]) == "urad"
    assert unit_of("60″") == "arcsec"
    for text in ("m", "parsec", "", 3):
        with pytest.raises(UnitError, match="write the unit of an angle such as 'deg'") as refusal:
            parse_unit(text, [angle])
        assert show(text) in str(refusal.value)


def test_an_integer_too_long_to_print_is_refused():
    with pytest.raises(UnitError, match="a huge number has no unit"):
        parse_motion(10**5000, 0)


def test_long_values_are_shortened_in_messages():
    with pytest.raises(UnitError) as refusal:
        parse_motion("x" * 10_000, 0)
    assert len(str(refusal.value)) < 200


@pytest.mark.parametrize(
    "text", ["9**9**9**9 m", "1 " + "(" * 5000, "1 " + "m*" * 5000, "9" * 9999]
)
def test_hostile_text_is_refused_at_once(text):
    begin = time.process_time()
    with pytest.raises(UnitError):
        parse_motion(text, 0)
    assert time.process_time() - begin < 0.5


UNIT_LIKE = st.text(alphabet="mskgradNHz0123456789.+-eE*/^() %µ″²", max_size=30)
NUMBER_LIKE = st.floats(allow_nan=True, allow_infinity=True).map(repr)


@seed(1)
@settings(max_examples=300, deadline=None, database=None)
@given(
    st.text()
    | UNIT_LIKE
    | st.tuples(NUMBER_LIKE, UNIT_LIKE).map(" ".join)
    | st.tuples(NUMBER_LIKE, st.sampled_from(["mas", "km", "rad", "turn"])).map(" ".join)
)
def test_any_text_is_a_finite_number_or_a_unit_error(text):
    try:
        value, _ = parse_motion(text, 0)
    except UnitError:
        return
    assert math.isfinite(value)


@pytest.mark.parametrize(
    ("unit", "to", "ratio"),
    [("arcsec", "mas", 1e3), ("arcmin/s^2", "arcsec/s^2", 60.0), ("mm", "m", 1e-3),
     ("Hz", "rpm", 60.0), ("N m", "kg m^2/s^2", 1.0), ("%", "%", 1.0)],
)  # fmt: skip
def test_units_convert(unit, to, ratio):
    assert conversion(unit, to) == ratio


@pytest.mark.parametrize(
    ("unit", "to"), [("mm", "arcsec"), ("mm", "lux"), ("lux", "mm"), ("", "m")]
)
def test_units_of_another_kind_do_not(unit, to):
    with pytest.raises(UnitError, match="write a unit such as 'arcsec'"):
        conversion(unit, to)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("60 arcsec", ("60", "arcsec")),
        (" -.5e-3mm ", ("-.5e-3", "mm")),
        ("−1e−3 s^−1", ("-1e-3", "s^-1")),
        ("+2. N m/(rad s)", ("+2.", "N m/(rad s)")),
        ("7", ("7", "")),
        ("5 1/s", ("5", "1/s")),
        ("1e5", ("1e5", "")),
        ("e5 mm", None),
        ("", None),
        ("ZVD", None),
        (". mm", None),
    ],
)
def test_a_quantity_has_two_parts(text, parts):
    assert parted(text) == parts
