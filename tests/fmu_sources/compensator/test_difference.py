from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import cont2discrete

from fmu_sources.compensator.difference import (
    DifferenceMethod,
    attributes,
    continuous,
    discrete,
    process_parameters,
    weight,
)
from fmu_sources.framework.arithmetic import PYTHON
from tests.fmu_sources.compensator.made import CONTACTS, T, parameters, polynomials

METHODS = {
    DifferenceMethod.backward: "backward_diff",
    DifferenceMethod.forward: "euler",
    DifferenceMethod.bilinear: "bilinear",
}
NAMES = ("m_e", "k_m", "c_m", "k_p", "c_p")


def h_of(method):
    return weight(method, PYTHON)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("contact", CONTACTS)
def test_process_parameters_equal_the_discretisation_of_scipy(contact, method):
    num, den, _ = cont2discrete(polynomials(contact), T, METHODS[method])
    num = np.r_[np.zeros(3 - num.size), num.ravel()]
    a, b, c, d, e = process_parameters(parameters(contact), h_of(method))

    assert [a, b] == pytest.approx(-den[1:], rel=1e-9)
    assert [c, d, e] == pytest.approx(num, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize(
    ("contact", "expected"),
    [
        ("S1", (1.9926, -0.9949, 394.14, -451.16, 127.72)),
        ("S2", (1.9423, -0.9615, 20512.8, -20512.8, 5128.2)),
        ("E", (1.9942, -0.9959, 370.30, -449.84, 131.88)),
    ],
)
def test_backward_process_parameters_are_those_of_the_tables(contact, expected):
    assert process_parameters(parameters(contact), 1.0) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_polynomials_return_from_the_discrete_form(method):
    polynomial = (1.9e5, 223.0, 80.0)
    there = discrete(polynomial, h_of(method), T)

    assert continuous(there, h_of(method), T) == pytest.approx(polynomial, rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("contact", ["S1", "E", "E, other stiffness"])
def test_attribute_parameters_return_from_the_process_parameters(contact, method):
    p = parameters(contact)
    found = attributes(process_parameters(p, h_of(method)), h_of(method), p, PYTHON)

    assert found.valid
    assert {name: getattr(found, name) for name in NAMES} == pytest.approx(CONTACTS[contact], rel=1e-5)


def test_a_common_gain_scales_all_attribute_parameters():
    p = parameters("S1")
    a, b, c, d, e = process_parameters(p, 1.0)
    found = attributes((a, b, 0.95 * c, 0.95 * d, 0.95 * e), 1.0, p, PYTHON)

    assert found.valid
    assert [getattr(found, n) for n in NAMES] == pytest.approx(
        [0.95 * getattr(p, n) for n in NAMES], rel=1e-5
    )


def test_elements_of_equal_time_constant_are_singular():
    p = parameters("S2")
    found = attributes(process_parameters(p, 1.0), 1.0, p, PYTHON)

    assert tuple(found) == (0.0, 0.0, 0.0, 0.0, 0.0, False)


def test_a_small_error_of_a_makes_the_attribute_parameters_not_physical():
    p = parameters("S1")
    a, b, c, d, e = process_parameters(p, 1.0)

    assert not attributes((a + 5e-3, b, c, d, e), 1.0, p, PYTHON).valid


@pytest.mark.parametrize(
    "Y", [(0.0,) * 5, (1.0, 0.0, 0.0, 0.0, 0.0), (-2.1, 1.1, -350.0, 428.0, -135.0), (1e30,) * 5]
)
def test_no_process_parameters_give_a_result_that_is_not_finite(Y):
    found = attributes(Y, 1.0, parameters("S1"), PYTHON)

    assert np.isfinite(found[:5]).all()
    assert not found.valid
