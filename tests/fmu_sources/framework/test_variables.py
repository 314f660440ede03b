from __future__ import annotations

import math
from enum import IntEnum

import pytest

from fmu_sources.framework.variables import (
    choice,
    declare,
    of_each_step,
    parameter,
    sampled,
    state,
    vector,
    whole_number,
)


class Colour(IntEnum):
    red = 1
    blue = 3


@pytest.mark.parametrize(
    ("variable", "value", "rule"),
    [
        (parameter("p", 1.0, "1", "", above=0.0), 0.0, "above 0.0"),
        (parameter("p", 1.0, "1", "", above=0.0), 5e-324, None),
        (parameter("p", 1.0, "1", "", minimum=0.5), 0.4, "at least 0.5"),
        (parameter("p", 1.0, "1", "", minimum=0.5), 0.5, None),
        (parameter("p", 1.0, "1", "", maximum=2.0), 2.1, "at most 2.0"),
        (parameter("p", 1.0, "1", ""), math.nan, "a finite number"),
        (parameter("p", 1.0, "1", ""), -math.inf, "a finite number"),
        (whole_number("n", 1, "", minimum=0, maximum=5), 6, "at most 5"),
        (choice("c", Colour.red, ""), 2, "one of 1 (red), 3 (blue)"),
        (choice("c", Colour.red, ""), 3, None),
    ],
)
def test_a_value_breaks_the_rule_that_is_named(variable, value, rule):
    assert variable.broken_rule(value) == rule


def test_a_vector_is_declared_once_and_has_an_element_each():
    scalar, *elements = declare(parameter("p", 1.0, "1", ""), vector(state("x", "m", "Place", 2.0), 3))

    assert scalar.base == "p"
    assert [(v.name, v.base, v.start, v.unit) for v in elements] == [
        ("x[1]", "x", 2.0, "m"),
        ("x[2]", "x", 2.0, "m"),
        ("x[3]", "x", 2.0, "m"),
    ]


def test_states_of_three_kinds():
    continuous = state("x", "m", "")

    assert (continuous.sampled, continuous.hidden, continuous.restarts) == (False, False, False)
    assert (sampled(continuous).sampled, sampled(continuous, hidden=True).hidden) == (True, True)
    assert (of_each_step(continuous).hidden, of_each_step(continuous).restarts) == (True, True)
