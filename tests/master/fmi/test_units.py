from dataclasses import replace

import pytest

from master.fmi.unit_names import unit
from master.fmi.units import Unit, conversion
from tests.stubs import CELSIUS, KELVIN, METRE, MILLIMETRE, NEWTON, bench, gain, wire

FAHRENHEIT = Unit("degF", {"K": 1}, factor=5 / 9, offset=459.67 * 5 / 9)


@pytest.mark.parametrize(
    ("source", "target", "value", "expected"),
    [
        (MILLIMETRE, METRE, 250.0, 0.25),
        (METRE, MILLIMETRE, 0.25, 250.0),
        (CELSIUS, KELVIN, 20.0, 293.15),
        (KELVIN, CELSIUS, 0.0, -273.15),
        (FAHRENHEIT, CELSIUS, 212.0, 100.0),
    ],
)
def test_a_value_goes_from_one_unit_to_the_other(source, target, value, expected):
    found = conversion(source, target)

    assert found.factor * value + found.offset == pytest.approx(expected, rel=1e-14)


def test_the_same_unit_by_two_names_changes_nothing():
    assert conversion(NEWTON, Unit("kg.m/s2", {"kg": 1, "m": 1, "s": -2})).is_identity


def test_different_quantities_do_not_convert():
    assert conversion(NEWTON, METRE) is None


@pytest.mark.parametrize(("source", "target"), [(None, METRE), (METRE, None), (None, None)])
def test_a_missing_unit_fits_every_unit(source, target):
    assert conversion(source, target).is_identity


def test_a_unit_that_is_not_defined_fits_its_own_name_only():
    grade = Unit("grade", defined=False)

    assert conversion(grade, Unit("grade", defined=False)).is_identity
    assert conversion(grade, Unit("grad", defined=False)) is None
    assert conversion(grade, METRE) is None


def test_a_run_converts_from_row_0_on():
    blocks = {"outside": gain(source=CELSIUS), "inside": gain(source=KELVIN, target=KELVIN)}
    made = bench(blocks, [wire("outside.y", "inside.u")], start={"outside": {"u": -40.0}})
    result = made.run(2).result

    assert result["outside.y"].tolist() == [-40.0, -40.0, -40.0]
    assert result["inside.y"].tolist() == pytest.approx([233.15, 233.15, 233.15], rel=1e-14)
    assert (result.unit("outside.y"), result.unit("inside.y")) == ("degC", "K")


def test_a_delayed_wire_converts_too():
    blocks = {"outside": gain(source=CELSIUS), "inside": gain(target=KELVIN)}
    made = bench(blocks, [wire("outside.y", "inside.u", delay=2)], start={"outside": {"u": 1.0}})

    assert made.run(4).result["inside.y"].tolist() == pytest.approx([274.15] * 5, rel=1e-14)


@pytest.mark.parametrize(
    ("source", "target", "value", "expected"),
    [
        ("rpm", "deg/s", 1.0, 6.0),
        ("rev", "deg", 1.0, 360.0),
        ("ft", "in", 1.0, 12.0),
        ("kip", "lbf", 1.0, 1000.0),
        ("degF", "degC", 212.0, 100.0),
        ("degC", "K", -273.15, 0.0),
        ("l/min", "m3/h", 1000.0, 60.0),
        ("psi", "lbf/in2", 1.0, 1.0),
        ("lb ft", "lbf ft", 1.0, 1.0),
        ("mbar", "hPa", 1.0, 1.0),
        ("t", "kg", 1.0, 1000.0),
        ("%", "1", 1.0, 0.01),
    ],
)
def test_units_by_name_convert_exactly(source, target, value, expected):
    found = conversion(unit(source), unit(target))

    assert found.factor * value + found.offset == pytest.approx(expected, rel=1e-15, abs=1e-12)


@pytest.mark.parametrize(
    ("source", "target"), [("rpm", "deg/s"), ("rev", "deg"), ("ft", "in"), ("kip", "lbf")]
)
def test_a_ratio_that_is_an_integer_is_that_integer(source, target):
    assert conversion(unit(source), unit(target)).factor.is_integer()


def test_a_difference_of_temperatures_has_no_offset():
    assert unit("W/degC").offset == 0.0
    assert conversion(unit("W/degC"), unit("W/K")).is_identity


def test_a_unit_that_an_fmu_does_not_define_is_what_its_name_says():
    millimetre = replace(unit("mm"), defined=False)

    assert conversion(millimetre, METRE).factor == 0.001
    assert conversion(millimetre, NEWTON) is None
    assert conversion(millimetre, Unit("mm", defined=False)).is_identity
