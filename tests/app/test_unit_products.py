"""Products of units against pint's reading of the same table."""

from decimal import Decimal

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jounce.app.unit_products import UnknownUnitError, product_of
from jounce.units import BASE, PREFIXES, UNITS


def pints_registry():
    """Return pint's registry of our units."""
    registry = pint.UnitRegistry(None, non_int_type=Decimal)
    for symbol, (word, size) in PREFIXES.items():
        registry.define(f"{word}- = {size} = {symbol}-")
    for symbol in BASE:
        registry.define(f"{symbol} = [{symbol}]{words(symbol)}")
    for symbol, unit in UNITS.items():
        if symbol not in BASE and not unit.zero:
            powers = unit.powers | ({"rev": 1} if symbol == "Hz" else {})
            product = " * ".join([str(unit.size), *(f"{b} ** {n}" for b, n in powers.items())])
            registry.define(f"{symbol} = {product}{words(symbol)}")
    registry.define("decibel = [level] = dB")
    return registry


def words(symbol):
    return "".join(f" = {word}" for word in ("_", *UNITS[symbol].words))


REGISTRY = pints_registry()
NAMES = [n for s, unit in UNITS.items() if not unit.zero for n in (s, *unit.words)] + ["dB"]
PREFIXED = [p for symbol, (word, _) in PREFIXES.items() for p in (symbol, word)]
names = st.builds(
    "".join,
    st.tuples(st.sampled_from(["", *PREFIXED]), st.sampled_from(NAMES), st.sampled_from(["", "s"])),
)
powers = st.builds(
    lambda name, n: name if n == 1 else f"{name}**{n}", names, st.integers(-9, 9).filter(bool)
)
groups = st.lists(powers, min_size=1, max_size=3).map(lambda parts: f"({'*'.join(parts)})")
factors = st.one_of(powers, groups)


@given(st.lists(factors, min_size=1, max_size=3), st.lists(factors, max_size=3))
def test_a_product_is_what_pint_says(above, below):
    text = "/".join(["*".join(above), *below])
    try:
        expected = REGISTRY.Quantity(Decimal(1), text).to_root_units()
    except pint.UndefinedUnitError as error:
        name = error.unit_names if isinstance(error.unit_names, str) else error.unit_names[0]
        with pytest.raises(UnknownUnitError):
            product_of(name)
        return
    found = product_of(text)
    assert float(found.size) == pytest.approx(float(expected.magnitude), rel=1e-15)
    told = {name.strip("[]"): int(n) for name, n in expected.dimensionality.items()}
    assert dict(found.dimension) == told


@pytest.mark.parametrize("name", ["parsec", "arcsecx", "kk", "ss", "degC", "MM"])
def test_a_name_that_no_unit_has_is_told(name):
    with pytest.raises(UnknownUnitError, match=f"^{name}$"):
        product_of(f"m/{name}")


def test_a_kilohertz_is_exactly_a_thousand_hertz():
    assert product_of("kHz").size == 1000 * product_of("Hz").size
