"""The native binary gives what the model's Python instance gives, to the last bit."""

from __future__ import annotations

import importlib.util
import random
import struct
from collections.abc import Callable
from pathlib import Path

import pytest

from fmu_sources.composed import registry
from fmu_sources.export import native
from fmu_sources.export.native.compile import compile_for
from fmu_sources.export.native.platforms import LINUX
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import Role
from tests.costs import long_for
from tests.fmu_sources.export.native.native_library import GUID, VERSIONS, Fmu, Fmu2, Fmu3, kind
from tests.fmu_sources.export.native.native_model import MODEL
from tests.fmu_sources.export.native.native_random import random_inputs, random_parameters

NAMES = [*registry.model_files(), "specimen"]
FEW = [
    "compensator",
    "docking_contact",
    "force_sensor",
    "specimen",
]  # each kind; all of them are slow to compile
Library = Callable[[Model], Path]


def load(name: str) -> Model:
    return MODEL if name == "specimen" else registry.load(name)


def bits(values: list[float]) -> list[bytes]:
    return [struct.pack("d", value) for value in values]


class Pair:
    """A native instance beside a Python one."""

    def __init__(self, fmu: Fmu) -> None:
        self.fmu, self.model = fmu, fmu.model
        self.python = Instance(fmu.model)
        shown = [i for i, v in enumerate(self.model.all_variables) if not v.hidden]
        kinds = sorted({kind(self.model.all_variables[i]) for i in shown})
        self.groups = [[i for i in shown if kind(self.model.all_variables[i]) == k] for k in kinds]
        self.inputs = [self.fmu.index[v.name] for v in self.model.group(Role.INPUT)]

    def set(self, values: dict[str, float]) -> None:
        for name, value in values.items():
            self.python[name] = value
            assert self.fmu.set(**{name: value}) == 0

    def set_inputs(self, values: list[float]) -> None:
        for i, value in zip(self.inputs, values, strict=True):
            self.python.values[i] = value
        assert not self.inputs or self.fmu.set_references(self.inputs, values) == 0

    def step(self, h: float) -> bool:
        """Step both; False once both refuse, because the random run left what the model allows."""
        t = self.python.time
        try:
            self.python.step(t, h)
        except ModelError:
            assert self.fmu.step(t, h) == 3
            return False
        if self.fmu.step(t, h) == 3:
            assert "not finite" in self.fmu.messages[-1]
            assert any(not abs(value) < float("inf") for value in self.python.values)
            return False
        return True

    def assert_equal(self) -> None:
        for group in self.groups:
            expected = [float(self.python.values[i]) for i in group]
            assert bits([float(v) for v in self.fmu.get_references(group)]) == bits(expected)


def run_beside(fmu: Fmu, n_steps: int, seed: int) -> int:
    """Run with random parameters and inputs, some steps twice as long; the number of steps compared."""
    rng = random.Random(seed)
    pair = Pair(fmu)
    pair.set(random_parameters(pair.model, rng))
    pair.set_inputs(random_inputs(pair.model, rng))
    pair.python.initialise()
    assert fmu.initialise() == 0, fmu.messages
    pair.assert_equal()
    period = pair.python[pair.model.sample_time] if pair.model.sample_time else 1e-3
    for k in range(n_steps):
        pair.set_inputs(random_inputs(pair.model, rng))
        if not pair.step(period * (2 if k % 7 == 0 else 1)):
            return k
        pair.assert_equal()
    return n_steps


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", FEW)
def test_native_equals_python_bit_for_bit(library: Library, name: str, version: type[Fmu]) -> None:
    fmu = version(library(load(name)), load(name))

    assert run_beside(fmu, 200, seed=1) == 200


@pytest.mark.slow
@pytest.mark.parametrize("name", long_for(NAMES[2:], NAMES))
def test_native_equals_python_bit_for_bit_over_10000_steps(library: Library, name: str) -> None:
    compared = 0
    seed = 0
    while compared < 10_000 and seed < 200:
        compared += run_beside(Fmu2(library(load(name)), load(name)), min(1000, 10_000 - compared), seed)
        seed += 1

    assert compared == 10_000


@pytest.mark.parametrize("name", FEW)
def test_fmi_2_and_fmi_3_agree_bit_for_bit(library: Library, name: str) -> None:
    model = load(name)
    both = [Fmu2(library(model), model), Fmu3(library(model), model)]
    shown = [i for i, v in enumerate(model.all_variables) if not v.hidden and kind(v) == "real"]
    rng = random.Random(2)
    rows = [random_inputs(model, rng) for _ in range(50)]
    inputs = [i for i, v in enumerate(model.all_variables) if v.role is Role.INPUT]
    results = []
    for fmu in both:
        assert fmu.initialise() == 0
        for k, row in enumerate(rows):
            assert fmu.set_references(inputs, row) == fmu.step(k * 1e-3, 1e-3) == 0
        results.append(bits(fmu.get_references(shown)))

    assert results[0] == results[1]


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="needs ziglang")
@pytest.mark.parametrize("name", long_for(NAMES[1:], NAMES))
def test_the_release_library_equals_python_bit_for_bit(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"{name}.so"
    path.write_bytes(compile_for(LINUX, native.generate(load(name), GUID), name))

    assert run_beside(Fmu3(path, load(name)), 500, seed=3) == 500
