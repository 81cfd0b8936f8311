"""Units at the door: text with a unit in, SI out, and back to the last bit."""

import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutwise import units

numbers = st.floats(-1e60, 1e60, allow_nan=False).filter(
    lambda x: not 0.0 < abs(x) < 1e-60
)  # more or less is out of scale
dimensions = st.sampled_from(sorted(units.DIMENSIONS))


@given(numbers, dimensions)
def test_text_is_read_back_to_the_last_bit(value, dimension):
    assert units.parse(units.text(value, dimension), dimension) == value


@given(st.text(max_size=20), dimensions)
def test_any_text_is_a_finite_number_or_a_unit_fault(text, dimension):
    with suppress(units.UnitFault):
        assert math.isfinite(units.parse(text, dimension))


@pytest.mark.parametrize("dimension", sorted(units.DIMENSIONS))
def test_every_example_is_a_quantity_of_its_dimension(dimension):
    assert units.parse(units.DIMENSIONS[dimension].example, dimension) > 0
    assert units.show(1.0, dimension)


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("80 mm/s", "speed", 0.08),
        ("4.8 m/min", "speed", 0.08),
        ("60 rpm", "angular_speed", math.tau),
        ("60 1/min", "angular_speed", math.tau),
        ("60 U/min", "angular_speed", math.tau),
        ("6 rad/s", "angular_speed", 6.0),
        ("2 Hz", "frequency", 2.0),
        ("0.1 mm/rev", "feed_per_revolution", 1e-4),
        ("0.1 mm", "feed_per_revolution", 1e-4),
        ("1.2 Nm", "moment", 1.2),
        ("1200 Nmm", "moment", 1.2),
        ("4.1e-3 kg m²", "inertia", 4.1e-3),
        ("50 µm", "small_length", 5e-5),
        ("50 μm", "length", 5e-5),  # Greek mu, not the micro sign
        ("−0.05 mm", "length", -5e-5),  # minus sign of word processors
        ("2000 N/mm^2", "stress", 2e9),
        ("30 %", "dimensionless", 0.3),
        ("20°", "angle", math.radians(20)),
    ],
)  # fmt: skip
def test_what_engineers_write(text, dimension, value):
    assert units.parse(text, dimension) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "dimension", "message"),
    [
        (80, "speed", '80 has no unit; write it as text with a unit, for example "80 mm/s"'),
        ("80", "speed", "has no unit"),
        ("80 mm", "speed", '"mm" is not a unit of speed'),
        ("80 furlong/parsec/x", "speed", "is not a unit"),
        ("50 Hz", "angular_speed", "Hz is for frequencies"),
        ("50 rad/s", "frequency", "is not a unit of frequency"),
        ("50 rpm", "frequency", "is not a unit of frequency"),
        ("0,2 mm", "length", 'has a decimal comma; write it with a decimal point, for example "0.2 mm"'),
        ("1e999 mm", "length", "too large"),
        ("nan mm", "length", "is not a number with a unit"),
        (float("nan"), "dimensionless", "not a finite number"),
        (True, "length", "expected a quantity"),
        (None, "length", "expected a quantity"),
        ("2 mm", "dimensionless", "is not a plain number"),
    ],
)
def test_what_is_no_quantity_is_named(text, dimension, message):
    with pytest.raises(units.UnitFault) as fault:
        units.parse(text, dimension)
    assert message in str(fault.value)
