from fractions import Fraction

import pytest

from fmu_sources.export.units import scale_of, si_exponents

ACCELERATION = {"m": 1, "s": -2}
FORCE = {"kg": 1, "m": 1, "s": -2}


@pytest.mark.parametrize(
    "name",
    [
        "m/s2",
        "m/s^2",
        "m/s**2",
        "m/s/s",
        "m s-2",
        "m.s-2",
        "m*s^-2",
        "m/(s s)",
        "m/s\u00b2",
        "m s\u207b\u00b2",
    ],
)
def test_an_acceleration_is_read_in_all_its_spellings(name):
    assert scale_of(name).exponents == ACCELERATION
    assert scale_of(name).factor == 1


@pytest.mark.parametrize(
    ("name", "exponents", "factor"),
    [
        ("1", {}, "1"),
        ("count", {}, "1"),
        ("%", {}, "0.01"),
        ("mm", {"m": 1}, "0.001"),
        ("\u00b5m", {"m": 1}, "0.000001"),
        ("cm", {"m": 1}, "0.01"),
        ("in", {"m": 1}, "0.0254"),
        ("ft", {"m": 1}, "0.3048"),
        ("km", {"m": 1}, "1000"),
        ("ms", {"s": 1}, "0.001"),
        ("us", {"s": 1}, "0.000001"),
        ("min", {"s": 1}, "60"),
        ("h", {"s": 1}, "3600"),
        ("g", {"kg": 1}, "0.001"),
        ("t", {"kg": 1}, "1000"),
        ("lb", {"kg": 1}, "0.45359237"),
        ("mN", FORCE, "0.001"),
        ("MN", FORCE, "1000000"),
        ("lbf", FORCE, "4.4482216152605"),
        ("kip", FORCE, "4448.2216152605"),
        ("N m", {"kg": 1, "m": 2, "s": -2}, "1"),
        ("N.m/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}, "1"),
        ("lb ft", {"kg": 1, "m": 2, "s": -2}, "1.3558179483314004"),
        ("lb ft/s", {"kg": 1, "m": 1, "s": -1}, "0.138254954376"),
        ("kPa", {"kg": 1, "m": -1, "s": -2}, "1000"),
        ("MPa", {"kg": 1, "m": -1, "s": -2}, "1000000"),
        ("mbar", {"kg": 1, "m": -1, "s": -2}, "100"),
        ("bar", {"kg": 1, "m": -1, "s": -2}, "100000"),
        ("J", {"kg": 1, "m": 2, "s": -2}, "1"),
        ("kJ", {"kg": 1, "m": 2, "s": -2}, "1000"),
        ("kg.m2/s2", {"kg": 1, "m": 2, "s": -2}, "1"),
        ("W", {"kg": 1, "m": 2, "s": -3}, "1"),
        ("kW", {"kg": 1, "m": 2, "s": -3}, "1000"),
        ("mV", {"kg": 1, "m": 2, "s": -3, "A": -1}, "0.001"),
        ("kV", {"kg": 1, "m": 2, "s": -3, "A": -1}, "1000"),
        ("mA", {"A": 1}, "0.001"),
        ("Ohm", {"kg": 1, "m": 2, "s": -3, "A": -2}, "1"),
        ("H", {"kg": 1, "m": 2, "s": -2, "A": -2}, "1"),
        ("F", {"kg": -1, "m": -2, "s": 4, "A": 2}, "1"),
        ("Hz", {"s": -1}, "1"),
        ("kHz", {"s": -1}, "1000"),
        ("1/s", {"s": -1}, "1"),
        ("1/min", {"s": -1}, "1/60"),
        ("mrad", {"rad": 1}, "0.001"),
        ("N/(m/s)", {"kg": 1, "s": -1}, "1"),
        ("N s/m", {"kg": 1, "s": -1}, "1"),
        ("um/s", {"m": 1, "s": -1}, "0.000001"),
        ("l", {"m": 3}, "0.001"),
        ("l/min", {"m": 3, "s": -1}, "1/60000"),
        ("W/(m2.K)", {"kg": 1, "s": -3, "K": -1}, "1"),
    ],
)
def test_a_unit_is_read_exactly(name, exponents, factor):
    found = scale_of(name)

    assert found.exponents == exponents
    assert found.factor == Fraction(factor)
    assert found.offset == 0


def test_a_pound_per_square_inch_is_the_force_of_a_pound_on_an_inch_squared():
    assert scale_of("psi") == scale_of("lbf/in2")


@pytest.mark.parametrize(
    ("name", "zero"), [("degC", Fraction("273.15")), ("degF", Fraction("459.67") * Fraction(5, 9))]
)
def test_a_temperature_alone_has_its_offset(name, zero):
    assert scale_of(name).offset == zero
    assert scale_of(f"1/{name}").offset == 0
    assert scale_of(f"{name}2").offset == 0


def test_angles_are_exact_to_each_other():
    assert scale_of("rev").factor / scale_of("deg").factor == 360
    assert scale_of("rpm").factor / scale_of("deg/s").factor == 6


@pytest.mark.parametrize(
    "name",
    [
        "W/m2 K",
        "m/",
        "/",
        "m//s",
        "(m",
        "m)",
        "furlong",
        "10 N",
        "m 2",
        "m^1.5",
        "m^99999",
        "kkg",
        "e",
        "m+s",
    ],
)
def test_a_name_that_is_no_unit_or_two_is_refused(name):
    with pytest.raises(ValueError, match="unit "):
        scale_of(name)


def test_exponents_come_in_the_order_of_the_base_units_without_zeros():
    assert [*si_exponents("A s/rad m kg-1".replace("/rad", ""))] == ["kg", "m", "s", "A"]
    assert si_exponents("N/N") == {}
