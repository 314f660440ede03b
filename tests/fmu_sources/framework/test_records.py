from __future__ import annotations

import pytest

from fmu_sources.framework.records import RecordType
from fmu_sources.framework.variables import parameter, vector

SCALARS = RecordType("scalars", [parameter("a", 1.0, "1", ""), parameter("b", 2.0, "1", "")])
MIXED = RecordType(
    "mixed",
    [parameter("a", 0.0, "1", ""), *vector(parameter("v", 0.0, "1", ""), 3), parameter("b", 0.0, "1", "")],
)
ONE = RecordType("one", vector(parameter("v", 0.0, "1", ""), 1))


def test_a_list_is_seen_by_names_and_a_vector_as_a_tuple():
    record = MIXED.record([1.0, 2.0, 3.0, 4.0, 5.0])

    assert (record.a, record.v, record.b) == (1.0, (2.0, 3.0, 4.0), 5.0)
    assert SCALARS.record([7.0, 8.0]).b == 8.0
    assert ONE.record([9.0]).v == (9.0,)


def test_fields_become_the_list_again():
    assert MIXED.flat({"b": 5.0, "v": (2.0, 3.0, 4.0), "a": 1.0}) == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert SCALARS.flat({"b": 8.0, "a": 7.0}) == [7.0, 8.0]


@pytest.mark.parametrize(("kind", "fields"), [(SCALARS, {"a": 1.0}), (MIXED, {"a": 1.0, "b": 2.0})])
def test_a_missing_field_is_not_passed_over(kind, fields):
    with pytest.raises(KeyError):
        kind.flat(fields)


def test_given_fields_replace_the_old_numbers_and_no_other():
    old = [1.0, 2.0, 3.0, 4.0, 5.0]

    assert MIXED.merged({"v": (0.0, 0.0, 0.0)}, old) == [1.0, 0.0, 0.0, 0.0, 5.0]
    assert old == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_a_vector_of_another_length_is_a_fault_of_the_equations():
    with pytest.raises(AssertionError, match="v"):
        MIXED.merged({"v": (0.0, 0.0)}, [0.0] * 5)
