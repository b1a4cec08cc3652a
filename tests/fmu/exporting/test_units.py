"""Units of FMUs against pint."""

import pint
import pytest

from jounce.app.units import factor
from jounce.fmu.exporting import units
from jounce.fmu.exporting.units import unit_definition
from jounce.units import UNITS

REGISTRY = pint.UnitRegistry()
BASE = {"kg": "kilogram", "m": "meter", "s": "second", "A": "ampere", "rad": "radian"}
SPELLED = {
    "um": "micrometer",
    "urad": "microradian",
    "us": "microsecond",
    "mas": "milliarcsecond",
    "mil": "thou",
    "rev": "turn",
}


PREFIXED = ["mrad", "mdeg", "km", "cm", "mm", "um", "nm", "ms", "us", "kN", "MPa", "kW", "mV", "mA"]


@pytest.mark.parametrize("symbol", [name for name in UNITS if not UNITS[name].zero] + PREFIXED)
def test_every_symbol_is_what_pint_says(symbol):
    unit = unit_definition(symbol)
    quantity = REGISTRY.Quantity(1.0, SPELLED.get(symbol, symbol))
    if symbol == "Hz":  # pint has its cycle as an angle
        assert (unit.factor, dict(unit.exponents)) == (1.0, {"s": -1})
        return
    for name, exponent in unit.exponents:
        quantity = quantity / REGISTRY.Quantity(1.0, BASE.get(name, name)) ** exponent
    assert quantity.to("dimensionless").magnitude == pytest.approx(unit.factor, rel=1e-12)


@pytest.mark.parametrize(
    "symbol", [name for name in UNITS if name != "Hz" and not UNITS[name].zero]
)
def test_a_scenario_file_reads_every_unit_as_an_fmu_does(symbol):
    assert factor(symbol) == unit_definition(symbol).factor


@pytest.mark.parametrize("name", ["degC", "degF"])
def test_temperatures_with_a_zero_of_their_own_are_no_factors(name):
    assert float(UNITS[name].zero) == pytest.approx(REGISTRY.Quantity(0.0, name).to("K").magnitude)
    with pytest.raises(ValueError, match="is not known"):
        unit_definition(name)


@pytest.mark.parametrize(
    ("name", "factor", "exponents"),
    [
        ("1", 1.0, {}),
        ("1/s2", 1.0, {"s": -2}),
        ("N.m.s/rad", 1.0, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("N/mm/s", 1e3, {"kg": 1, "s": -3}),
        ("m2.s-2", 1.0, {"m": 2, "s": -2}),
    ],
)
def test_products_and_quotients(name, factor, exponents):
    unit = unit_definition(name)
    assert (unit.factor, dict(unit.exponents)) == (pytest.approx(factor), exponents)


@pytest.mark.parametrize(
    "name", ["furlong", "N*m", "", "N.", "m/", "rad/(s)", "m0", "1.1", "kmin", "Mm100", "ukg"]
)
def test_what_is_not_known_is_refused(name):
    with pytest.raises(ValueError, match="is not known"):
        unit_definition(name)


@pytest.mark.parametrize("position", ["1", "rad", "deg", "arcsec", "m", "mm"])
def test_the_units_of_a_loop_fit_together(position):
    """Torque is inertia times acceleration, and gains times error, its integral and rate."""

    def size(*names):
        factor, exponents = 1.0, dict.fromkeys(BASE, 0)
        for name in names:
            unit = unit_definition(name)
            factor *= unit.factor
            for symbol, exponent in unit.exponents:
                exponents[symbol] += exponent
        exponents.pop("rad")
        return pytest.approx(factor, rel=1e-12), exponents

    torque = size(units.effort(position))
    assert size(units.inertia(position), units.rate(position, 2)) == torque
    assert size(units.gain(position, 0), position) == torque
    assert size(units.gain(position, -1), position, "s") == torque
    assert size(units.gain(position, 1), units.rate(position, 1)) == torque
