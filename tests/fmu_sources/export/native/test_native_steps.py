"""Steps unlike the one before: what is known from the last step must not pass for what is asked now."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fmu_sources.composed import registry
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.model import Model
from tests.fmu_sources.export.native.native_library import VERSIONS, Fmu
from tests.fmu_sources.export.native.native_model import MODEL

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


ENDLESS = [
    (
        "spacecraft",
        "sample_time",
        1e-12,
        1e-3,
        "too long for sample_time, got 0.001 s, expected at most 10000 ",
    ),
    (
        "spacecraft",
        "sample_time",
        5e-324,
        1e-3,
        "too long for sample_time, got 0.001 s, expected at most 10000 ",
    ),
    (
        "force_sensor",
        "sample_time",
        1e-8,
        1e-3,
        "too long for sample_time, got 0.001 s, expected at most 10000 ",
    ),
    (
        "spacecraft",
        "sample_time",
        1e-3,
        10.001,
        "too long for sample_time, got 10.001 s, expected at most 10000 ",
    ),
    (
        "docking_contact",
        None,
        None,
        201.0,
        "too long, got 201.0 s, expected at most 1000000 substeps of 0.0002 s",
    ),
    (
        "docking_contact",
        None,
        None,
        1e300,
        "too long, got 1e+300 s, expected at most 1000000 substeps of 0.0002 s",
    ),
    (
        "motion_simulator_linear",
        "sample_time",
        1e4,
        1e4,
        "too long, got 10000.0 s, expected at most 1000000 sub",
    ),
]


@pytest.mark.parametrize(("name", "parameter", "value", "h", "message"), ENDLESS)
@pytest.mark.parametrize("version", VERSIONS)
def test_a_step_of_endlessly_many_parts_is_refused_alike(
    name: str,
    parameter: str | None,
    value: float,
    h: float,
    message: str,
    version: type[Fmu],
    library: Callable[[Model], Path],
) -> None:
    model = registry.load(name)
    fmu, python = version(library(model), model), Instance(model)
    if parameter is not None:
        python[parameter] = value
        assert fmu.set(**{parameter: value}) == OK
    assert fmu.initialise() == OK
    python.initialise()

    assert fmu.step(0.0, h) == ERROR
    with pytest.raises(ModelError, match="^communication step: " + re.escape(message)) as refused:
        python.step(0.0, h)
    assert fmu.messages == [str(refused.value)]
    fmu.free()


@pytest.mark.parametrize(("name", "h"), [("spacecraft", 10.0), ("docking_contact", 200.0)])
def test_the_longest_step_is_made(name: str, h: float, library: Callable[[Model], Path]) -> None:
    model = registry.load(name)
    fmu = VERSIONS[0](library(model), model)
    assert fmu.initialise() == OK

    assert fmu.step(0.0, h) == OK
    fmu.free()


@pytest.mark.parametrize("h", [0.0, -1e-3, math.nan, math.inf])
@pytest.mark.parametrize("name", ["spacecraft", "docking_contact"])
def test_python_refuses_a_length_that_is_no_positive_number(name: str, h: float) -> None:
    python = Instance(registry.load(name))
    python.initialise()

    with pytest.raises(ModelError, match=r"^communication step: not a positive number, got .* above 0\.0 s$"):
        python.step(0.0, h)


SAMPLED = [name for name in registry.model_files() if registry.load(name).sample_time is not None]


@pytest.mark.parametrize("name", SAMPLED)
def test_no_sampling_period_makes_a_step_endless(name: str) -> None:
    """Either the period breaks its rule or the step holds too many of it."""
    python = Instance(registry.load(name))
    python[python.model.sample_time or ""] = 1e-12

    with pytest.raises(ModelError, match=r"value not allowed, got 1e-12 s|too long for .* of 1e-12 s"):
        python.initialise() or python.step(0.0, 1e-3)
