"""Every arithmetic gives what the equations mean: Python, C by way of CasADi, arrays, labels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import casadi
import numpy as np
import pytest

from fmu_sources.export.dependencies import Label, LabelArithmetic, names_of
from fmu_sources.export.native.casadi_arithmetic import CASADI, as_written
from fmu_sources.framework.arithmetic import PYTHON, Arithmetic
from fmu_sources.framework.array_arithmetic import ARRAYS

NAMES = ("a", "b", "n")
MEMBERS = {name for name in {*Arithmetic.__annotations__, *vars(Arithmetic)} if not name.startswith("_")}


class Case(NamedTuple):
    """An expression in a, b and n, its value at a point by hand, and the names that it depends on."""

    expression: Callable[[Any, Any, Any, Any], Any]
    at: tuple[float, float, float]
    value: float
    names: str


def picked(length: int) -> Callable[[Any, Any, Any, Any], Any]:
    """Pick from a, b, 2, 3, ... of the given length."""
    return lambda a, b, n, m: m.pick((a, b, *(float(i) for i in range(2, length)))[:length], n)


PLACES = [(-1e300, 10.0), (-3.0, 10.0), (-0.5, 10.0), (0.0, 10.0), (0.9, 10.0), (1.0, 20.0), (1.5, 20.0)]
PAST = [(3.0, 20.0), (1e300, 20.0), (math.inf, 20.0), (-math.inf, 10.0), (math.nan, 10.0)]
CASES = [
    Case(lambda a, b, n, m: a * m.pi, (2.0, 0.0, 0.0), 6.283185307179586, "a"),
    Case(lambda a, b, n, m: m.sqrt(a), (2.25, 0.0, 0.0), 1.5, "a"),
    Case(lambda a, b, n, m: m.exp(a), (1.0, 0.0, 0.0), 2.718281828459045, "a"),
    Case(lambda a, b, n, m: m.log(a), (8.0, 0.0, 0.0), 2.0794415416798357, "a"),
    Case(lambda a, b, n, m: m.sin(a), (0.5235987755982988, 0.0, 0.0), 0.5, "a"),
    Case(lambda a, b, n, m: m.cos(a), (1.0471975511965976, 0.0, 0.0), 0.5, "a"),
    Case(lambda a, b, n, m: m.tan(a), (0.7853981633974483, 0.0, 0.0), 1.0, "a"),
    Case(lambda a, b, n, m: m.tanh(a), (0.5493061443340549, 0.0, 0.0), 0.5, "a"),
    Case(lambda a, b, n, m: m.floor(a), (2.5, 0.0, 0.0), 2.0, "a"),
    Case(lambda a, b, n, m: m.floor(a), (-2.5, 0.0, 0.0), -3.0, "a"),
    Case(lambda a, b, n, m: m.fabs(a) + abs(b), (-2.5, -1.0, 0.0), 3.5, "ab"),
    Case(lambda a, b, n, m: m.where(a > b, a, n), (2.0, 1.0, 7.0), 2.0, "abn"),
    Case(lambda a, b, n, m: m.where(a > b, a, n), (1.0, 1.0, 7.0), 7.0, "abn"),
    Case(lambda a, b, n, m: m.where(a, b, n), (1.0, 4.0, 7.0), 4.0, "abn"),
    Case(lambda a, b, n, m: m.where(a, b, n), (0.0, 4.0, 7.0), 7.0, "abn"),
    Case(lambda a, b, n, m: m.where(m.both(a > 0.0, b > 0.0), n, 0.0), (1.0, 1.0, 7.0), 7.0, "abn"),
    Case(lambda a, b, n, m: m.where(m.both(a > 0.0, b > 0.0), n, 0.0), (1.0, -1.0, 7.0), 0.0, "abn"),
    Case(lambda a, b, n, m: m.where(m.both(a > 0.0, b > 0.0), n, 0.0), (-1.0, -1.0, 7.0), 0.0, "abn"),
    *(Case(picked(2), (10.0, 20.0, n), value, "abn") for n, value in (*PLACES, *PAST)),
    *(Case(picked(1), (10.0, 20.0, n), 10.0, "an") for n in (-1.0, 0.0, 1.0, 5.0)),
    *(
        Case(picked(101), (10.0, 20.0, n), value, "abn")
        for n, value in (*PLACES, (100.0, 100.0), (250.0, 100.0))
    ),
]
all_cases = pytest.mark.parametrize("case", CASES)


@pytest.mark.parametrize("m", [PYTHON, CASADI, ARRAYS, LabelArithmetic()], ids=lambda m: type(m).__name__)
def test_an_arithmetic_has_every_function_and_no_other(m):
    assert {name for name in dir(m) if not name.startswith("_")} == MEMBERS


@all_cases
def test_python_gives_the_value(case):
    assert case.expression(*case.at, PYTHON) == pytest.approx(case.value, rel=1e-15)


@all_cases
def test_casadi_gives_the_value(case):
    with as_written():
        symbols = [casadi.SX.sym(name) for name in NAMES]
        function = casadi.Function("f", symbols, [case.expression(*symbols, CASADI)])

    assert float(function(*case.at)) == pytest.approx(case.value, rel=1e-15)


@all_cases
def test_arrays_give_the_value_at_each_instant(case):
    a, b, n = (np.array([value, other]) for value, other in zip(case.at, (1.0, 1.0, 0.0), strict=True))
    found = case.expression(a, b, n, ARRAYS)

    assert float(found[0]) == pytest.approx(case.value, rel=1e-15)
    assert float(found[1]) == pytest.approx(case.expression(1.0, 1.0, 0.0, PYTHON), rel=1e-15)


@all_cases
def test_arrays_give_the_value_of_numbers_too(case):
    assert float(case.expression(*case.at, ARRAYS)) == pytest.approx(case.value, rel=1e-15)


@all_cases
def test_labels_name_what_the_value_can_depend_on(case):
    labels = [Label(frozenset({name})) for name in NAMES]

    assert names_of(case.expression(*labels, LabelArithmetic())) == set(case.names)
