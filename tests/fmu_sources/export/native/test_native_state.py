"""Saved states, several instances, threads, derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from fmu_sources.framework.model import Model
from tests.fmu_sources.export.native.native_library import Fmu, Fmu2
from tests.fmu_sources.export.native.native_model import MODEL

OK, ERROR = 0, 3


def run(fmu: Fmu, first: int, n: int) -> list[tuple[float, ...]]:
    rows = []
    for k in range(first, first + n):
        fmu.set(**{"u[1]": math.sin(0.1 * k), "u[2]": math.cos(0.3 * k)})
        assert fmu.step(k * 1e-3, 1e-3) == OK
        rows.append((fmu.get("y"), fmu.get("v"), fmu.get("mean"), fmu.get("f")))
    return rows


def test_a_restored_state_repeats_the_run_to_the_last_bit(fmu: Fmu) -> None:
    fmu.initialise()
    run(fmu, 0, 5)
    state = fmu.save()
    first = run(fmu, 5, 20)

    assert fmu.restore(state) == OK
    assert run(fmu, 5, 20) == first


def test_a_serialised_state_goes_into_another_instance(fmu: Fmu) -> None:
    fmu.set(m=3.0)
    fmu.initialise()
    run(fmu, 0, 5)
    content = fmu.serialise(fmu.save())
    other = type(fmu)(fmu.path, MODEL)
    status, state = other.deserialise(content)

    assert status == other.restore(state) == OK
    assert run(other, 5, 20) == run(fmu, 5, 20)


@pytest.mark.parametrize(
    "damage", [lambda b: b[:-1], lambda b: b + b"\0", lambda b: b"x" + b[1:], lambda b: b""]
)
def test_bytes_that_are_no_state_of_this_model_are_refused(
    fmu: Fmu, damage: Callable[[bytes], bytes]
) -> None:
    content = fmu.serialise(fmu.save())
    status, state = fmu.deserialise(damage(content))

    assert status == ERROR
    assert not state
    assert fmu.messages[0].startswith("FMU state: ")


def test_a_state_saved_before_the_run_restores_the_phase_too(fmu: Fmu) -> None:
    state = fmu.save()
    fmu.initialise()
    fmu.step(0.0, 1e-3)

    assert fmu.restore(state) == fmu.initialise() == fmu.step(0.0, 1e-3) == OK


def test_instances_do_not_know_each_other(fmu: Fmu) -> None:
    other = type(fmu)(fmu.path, MODEL)
    other.set(m=20.0)
    alone = type(fmu)(fmu.path, MODEL)
    for each in (fmu, other, alone):
        each.initialise()
    mixed = []
    for k in range(20):
        mixed += run(fmu, k, 1)
        run(other, k, 1)

    assert mixed == run(alone, 0, 20)


def test_threads_give_what_one_thread_gives(library: Callable[[Model], Path]) -> None:
    def whole_run(_: int) -> list[tuple[float, ...]]:
        fmu = Fmu2(library(MODEL), MODEL)
        fmu.initialise()
        return run(fmu, 0, 300)

    expected = whole_run(0)
    with ThreadPoolExecutor(4) as pool:
        assert all(rows == expected for rows in pool.map(whole_run, range(8)))


def test_the_directional_derivative_is_that_of_the_output_equations(fmu: Fmu) -> None:
    """The hard law is f = (k1 + k2) y (1 + y y), so df/dy = (k1 + k2) (1 + 3 y y)."""
    fmu.set(law=4)
    fmu.initialise()

    assert fmu.derivative("f", "y") == pytest.approx(800.0 * (1.0 + 3.0 * 0.01), rel=1e-14)
    assert fmu.derivative("f", "k[1]") == pytest.approx(0.1 * 1.01, rel=1e-14)
    assert fmu.derivative("f", "u[1]") == 0.0
    assert fmu.derivative("y", "y") == 1.0
