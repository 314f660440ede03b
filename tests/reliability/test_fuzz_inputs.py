"""Inputs of every kind that nobody would write; more of them: `python -m tests.reliability.fuzz_inputs`."""

from __future__ import annotations

import pytest

from tests.reliability.fuzz_inputs import KINDS, main_


@pytest.mark.parametrize("kind", KINDS)
def test_a_few_inputs_of_each_kind_end_in_words(kind):
    found = main_(5, seed=2, kind=kind)

    assert found.inputs >= 5
    assert found.faults == []


@pytest.mark.long
def test_five_hundred_inputs_end_in_words():
    assert main_(500, seed=3).faults == []
