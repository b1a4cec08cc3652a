"""Units converted into each other: definitions that files give, names, and what has no gain."""

import math

import pytest

from jounce.fmu.cosimulation.conversion import conversion, unit_of
from jounce.fmu.importing.description import FmuUnit


@pytest.mark.parametrize(
    ("given", "taken", "gain"),
    [
        ("deg", "rad", math.pi / 180.0),
        ("rad", "deg", 180.0 / math.pi),
        ("arcsec", "deg", 1.0 / 3600.0),
        ("mm", "m", 1e-3),
        ("m/s", "mm/s", 1e3),
        ("deg/s^2", "rad/s2", math.pi / 180.0),
        ("N·m", "N.m", 1.0),
        ("kN", "N", 1e3),
        ("rpm", "rad/s", 2.0 * math.pi / 60.0),
        ("Hz", "1/s", 1.0),
        ("ms", "s", 1e-3),
        ("bar", "kPa", 100.0),
        ("kW", "N.m/s", 1e3),
        ("", "deg", 1.0),
        ("deg", "1", 1.0),
        ("-", "deg", 1.0),
        ("widgets", "widgets", 1.0),
    ],
)
def test_names_that_are_known(given, taken, gain):
    found, offset = conversion(unit_of(given), unit_of(taken))
    assert found == pytest.approx(gain, rel=1e-15)
    assert offset == 0.0


@pytest.mark.parametrize(
    ("given", "value", "taken", "expected"),
    [
        ("degC", 20.0, "K", 293.15),
        ("K", 300.0, "°C", 26.85),
        ("degF", 32.0, "degC", 0.0),
        ("°F", 212.0, "K", 373.15),
    ],
)
def test_temperatures_have_offsets(given, value, taken, expected):
    gain, offset = conversion(unit_of(given), unit_of(taken))
    assert gain * value + offset == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize(
    ("given", "taken"),
    [("m", "kg"), ("rad", "m"), ("widgets", "m"), ("rad/s", "Hz"), ("m", "m/s")],
)
def test_what_is_of_another_kind_is_not_converted(given, taken):
    assert conversion(unit_of(given), unit_of(taken)) is None


def test_what_a_file_declares_counts_more_than_the_name():
    """Celsius to Fahrenheit: 100 °C are 212 °F."""
    celsius = FmuUnit("degC", (("K", 1),), 1.0, 273.15)
    fahrenheit = FmuUnit("degF", (("K", 1),), 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0)
    gain, offset = conversion(celsius, unit_of("degF", [fahrenheit]))
    assert gain * 100.0 + offset == pytest.approx(212.0, rel=1e-14)
    assert gain * -40.0 + offset == pytest.approx(-40.0, rel=1e-13)
    odd = FmuUnit("m", (("m", 1),), 0.3048)
    assert conversion(unit_of("m", [odd]), unit_of("mm")) == (pytest.approx(304.8), 0.0)


def test_a_declared_name_without_base_falls_back_on_the_name():
    assert conversion(unit_of("deg", [FmuUnit("deg")]), unit_of("rad"))[0] == math.pi / 180.0
    assert conversion(unit_of("%", [FmuUnit("%", (), 0.01)]), FmuUnit("‰", (), 1e-3))[0] == 10.0


def test_a_factor_of_zero_converts_nothing():
    assert conversion(unit_of("m"), FmuUnit("z", (("m", 1),), 0.0)) is None
    assert conversion(FmuUnit("z", (("m", 1),), 0.0), unit_of("m")) is None
