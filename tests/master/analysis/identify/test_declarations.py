"""An FMU of any names is made linear, followed through time and held by what it declares of itself."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from master.analysis.closed_loop.linearise import Assumption, frozen
from master.analysis.identify.declarations import departures, holding, learns
from master.analysis.identify.varying import period_of
from master.fmi.description import Kind
from master.fmi.linearity import DeclaredLearning, DeclaredLinear
from tests.stubs import bench, gain, variables

STEP = 1e-3
ITEMS = {"off": 1, "slow": 2, "fast": 3}
SWING = DeclaredLinear("swing", "0.0", "it swings", frequency="pace")
SWAY = DeclaredLinear("sway", "0.0", "it sways", frequency="rate")
CALM = (DeclaredLinear("mode", "off", "it adapts"), DeclaredLinear("mode", "slow", "it adapts"))
ADAPTS = DeclaredLearning("mode", "fast", "frozen")


def system_of(linear=(), learning=(), **start):
    """A gain with parameters of made-up names."""
    block = gain()
    fixed = {"variability": "fixed"}
    more = variables(
        *((name, "parameter", fixed) for name in ("swing", "pace", "sway", "rate")),
        ("mode", "parameter", fixed | {"kind": Kind.INTEGER, "items": ITEMS, "start": "1"}),
        ("frozen", "parameter", {"kind": Kind.BOOLEAN, "variability": "tunable", "start": "false"}),
    )
    ports = block.variables + tuple(replace(v, reference=i) for i, v in enumerate(more, len(block.variables)))
    system = bench({"a": replace(block, variables=ports)}, start={"a": start}).system
    instance = system.instances["a"]
    description = replace(instance.description, linear=linear, learning=learning)
    return replace(system, instances={"a": replace(instance, description=description)})


def instance_of(*args, **start):
    return system_of(*args, **start).instances["a"]


def period(*linear, **start):
    return period_of(SimpleNamespace(instance=instance_of(linear, **start), step_size=STEP))


def test_a_declared_value_is_given_and_told_with_its_reason():
    system, found = frozen(system_of((SWING, *CALM), swing=2.0, mode=3), after_run=False)

    assert found == (Assumption("a.swing", 0.0, "it swings"), Assumption("a.mode", "off", "it adapts"))
    assert system.instances["a"].value_of("swing") == 0.0
    assert system.instances["a"].value_of("mode") == 1.0


@pytest.mark.parametrize("mode", [1, 2])
def test_each_of_several_declared_values_is_linear(mode):
    assert list(departures(instance_of((SWING, *CALM), mode=mode))) == []


def test_what_is_not_declared_is_left_alone():
    system = system_of(swing=2.0, mode=3)

    assert frozen(system, after_run=True) == (system, ())
    assert period(swing=2.0, pace=1.0) == 0


def test_an_fmu_that_learns_and_varies_is_held_and_made_constant():
    system, found = frozen(system_of((SWING, *CALM), (ADAPTS,), swing=2.0, mode=3), after_run=True)

    assert [(one.signal, one.value) for one in found] == [("a.frozen", "true"), ("a.swing", 0.0)]
    assert system.instances["a"].value_of("mode") == 3.0


@pytest.mark.parametrize(("start", "expected"), [({"mode": 3}, True), ({"mode": 2}, False)])
def test_an_fmu_learns_with_the_declared_item_until_it_is_held(start, expected):
    instance = instance_of(CALM, (ADAPTS,), **start)

    assert learns(instance) is expected
    assert not learns(holding(instance))
    assert (holding(instance) == instance) is not expected


@pytest.mark.parametrize(
    ("start", "ticks"),
    [
        ({}, 0),
        ({"pace": 5.0}, 0),
        ({"swing": 1.0}, 0),
        ({"swing": 1.0, "pace": 5.0}, 200),
        ({"swing": 1.0, "pace": 3.0}, None),
        ({"swing": 1.0, "pace": 5.0, "sway": 1.0, "rate": 8.0}, 1000),
    ],
)
def test_the_period_is_the_least_common_one_of_what_varies(start, ticks):
    """By hand: 1/5 s and 1/8 s are 200 and 125 ticks, together 1000; 1/3 s is no integer number of ticks."""
    assert period(SWING, SWAY, **start) == ticks
