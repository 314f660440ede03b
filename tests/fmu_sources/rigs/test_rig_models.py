from __future__ import annotations

import math

import pytest

from fmu_sources.framework.instance import Instance
from fmu_sources.rigs import (
    motion_driven_specimen,
    oscillator,
    servo_axis,
    servo_axis_driven,
    servo_axis_inverse,
)

MODELS = [
    r.MODEL for r in (motion_driven_specimen, oscillator, servo_axis, servo_axis_driven, servo_axis_inverse)
]


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_starts_at_rest(model):
    instance = Instance(model)
    instance.initialise()
    instance.step(0.0, 1e-3)

    assert all(instance[v.name] == 0.0 for v in model.all_variables if v.output)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_slot_receives_a_force_that_resists(model):
    (slot,) = model.slots
    x = model.states.record([0.01] * len(model.states))
    u = model.inputs.record([0.01] * len(model.inputs))
    p = Instance(model).values[: len(model.parameters)]
    seen = []

    def note(name, value, **signals):
        seen.append((name, value, signals))
        return value

    from fmu_sources.framework.arithmetic import PYTHON

    model.derivatives(0.0, x, u, model.parameters.record(p), PYTHON, slot=note)
    model.outputs(0.0, x, u, model.parameters.record(p), PYTHON, slot=note)
    assert {name for name, _, _ in seen} == {slot.name}
    assert all(value > 0.0 and set(signals) == set(slot.signals) for _, value, signals in seen)


def test_oscillator_rings_at_its_frequency_and_damping():
    instance = Instance(oscillator.MODEL)
    instance["y"] = 0.1
    instance.initialise()
    for k in range(100):
        instance.step(k * 2e-4, 2e-4)

    p = {name: instance[name] for name in ("mass", "damping", "stiffness")}
    rate, w0 = p["damping"] / p["mass"] / 2.0, math.sqrt(p["stiffness"] / p["mass"])
    w = math.sqrt(w0**2 - rate**2)
    t = 0.02
    exact = 0.1 * math.exp(-rate * t) * (math.cos(w * t) + rate / w * math.sin(w * t))
    assert instance["y"] == pytest.approx(exact, abs=1e-6)


def test_driven_axis_reaches_its_final_speed_exponentially():
    instance = Instance(servo_axis_driven.MODEL)
    instance.initialise()
    instance["v"] = 1.0
    for k in range(100):
        instance.step(k * 1e-3, 1e-3)

    final = 35.15065188248547 / 203.5
    assert instance["der_q"] == pytest.approx(final * (1.0 - math.exp(-203.5 / 95.1 * 0.1)), rel=1e-9)


def test_inverse_axis_gives_the_force_of_its_motion():
    instance = Instance(servo_axis_inverse.MODEL)
    instance["der_q"], instance["der_der_q"] = 0.1, -2.0
    instance.initialise()

    assert instance["force"] == pytest.approx(95.1 * -2.0 + 203.5 * 0.1)


def test_specimen_answers_stiffness_and_damping():
    instance = Instance(motion_driven_specimen.MODEL)
    instance["stiffness"], instance["damping"], instance["x"], instance["der_x"] = 100.0, 10.0, 0.5, -1.0
    instance.initialise()

    assert instance["force"] == pytest.approx(40.0)


def test_cascade_saturates_before_the_pulse_is_added():
    instance = Instance(servo_axis.MODEL)
    instance.initialise()
    instance["q_ref"], instance["pulse"] = 1.0, 5.0
    instance.step(0.0, 1e-3)

    assert instance["v"] == pytest.approx(15.0)
    assert instance["force"] == pytest.approx(15.0 * 35.15065188248547)
