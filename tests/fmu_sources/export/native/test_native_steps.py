"""Steps unlike the one before: what is known from the last step must not pass for what is asked now."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from native_library import VERSIONS, Fmu
from native_model import MODEL

from fmu_sources.composed import registry
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.model import Model

OK, ERROR = 0, 3
CONTACT = registry.load("docking_contact")  # without a sampling period: its steps may have any length
LENGTHS = (1e-3, 1e-3, 2.5e-3, 1e-3, 1e-4, 1e-4, 0.7e-3)  # s: 5, 5, 13, 5, 1, 1 and 4 substeps


@pytest.fixture(params=VERSIONS, ids=lambda version: version.__name__)
def contact(request: pytest.FixtureRequest, library: Callable[[Model], Path]) -> Iterator[Fmu]:
    instance = request.param(library(CONTACT), CONTACT)
    assert instance.initialise() == OK
    yield instance
    instance.free()


@pytest.mark.parametrize("n_before", [0, 1, 2])
@pytest.mark.parametrize("h", [0.0, -0.0, -1e-3, math.nan, math.inf])
def test_a_length_that_is_no_positive_number_is_refused_first_and_later(
    contact: Fmu, h: float, n_before: int
) -> None:
    for k in range(n_before):
        assert contact.step(k * 1e-3, 1e-3) == OK

    assert contact.step(n_before * 1e-3, h) == ERROR
    assert contact.messages[0].startswith("communication step: not a positive number")
    assert contact.step(n_before * 1e-3, 1e-3) == OK


def test_steps_of_changing_lengths_equal_those_of_the_model_bit_for_bit(contact: Fmu) -> None:
    python = Instance(CONTACT)
    python.initialise()
    for k, h in enumerate(LENGTHS):
        python["v_act"] = 0.1 * k
        assert contact.set(v_act=0.1 * k) == contact.step(python.time, h) == OK
        python.step(python.time, h)
        assert struct.pack("d", contact.get("x")) == struct.pack("d", python["x"])


@pytest.mark.parametrize("late", [1e-6, -1e-6, math.nan, math.inf])
def test_a_start_is_checked_in_steps_as_long_as_the_last_one(contact: Fmu, late: float) -> None:
    assert contact.step(0.0, 1e-3) == contact.step(1e-3, 1e-3) == OK

    assert contact.step(2e-3 + late, 1e-3) == ERROR
    assert contact.messages[0].startswith("communication ")


def test_a_parameter_set_between_equal_steps_is_checked(fmu: Fmu) -> None:
    fmu.initialise()
    assert fmu.step(0.0, 1e-3) == fmu.step(1e-3, 1e-3) == OK
    fmu.set(m=0.0)

    assert fmu.step(2e-3, 1e-3) == ERROR
    assert fmu.messages == ["m: value not allowed, got 0.0 kg, expected above 0.0"]


@pytest.mark.parametrize("values", [(math.inf, -math.inf), (math.nan, 0.0), (0.0, -math.inf)])
def test_no_input_that_is_not_finite_hides_behind_another(fmu: Fmu, values: tuple[float, float]) -> None:
    fmu.initialise()
    fmu.set(**{"u[1]": values[0], "u[2]": values[1]})

    assert fmu.step(0.0, 1e-3) == ERROR
    assert "value not allowed" in fmu.messages[0]


def test_finite_inputs_whose_sum_is_not_finite_are_taken(fmu: Fmu) -> None:
    """The step is made: it ends with the model's own fault, as in Python, not with a word on the inputs."""
    python = Instance(MODEL)
    python.initialise()
    fmu.initialise()
    for name in ("u[1]", "u[2]"):
        python[name] = 1e308
        assert fmu.set(**{name: 1e308}) == OK

    with pytest.raises(ModelError, match="y: off the table") as refused:
        python.step(0.0, 1e-3)
    assert fmu.step(0.0, 1e-3) == ERROR
    assert fmu.messages == [str(refused.value)]
