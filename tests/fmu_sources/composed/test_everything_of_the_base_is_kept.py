"""A model with an effect declares everything that its base declares."""

from __future__ import annotations

import random

import pytest

from fmu_sources.composed.composition import all_slots, with_effect
from fmu_sources.composed.registry import load, model_files
from fmu_sources.effects.catalogue import candidates, effect
from fmu_sources.export.documentation import documentation_files
from fmu_sources.export.terminals import terminal_files
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.model import Fault, Model, Terminal, no_effect
from fmu_sources.framework.variables import Role

PAST_A_STOP = r"leg_reference\[1\]: leg 1 is commanded past a stop, got 3\.4"
OWN = {"name", "description", "variables"}


def composed_models():
    """Each model with one effect in each slot, another one from slot to slot."""
    found = []
    for name in model_files():
        for i, slot in enumerate(all_slots(load(name))):
            fitting = candidates(slot)
            found.append((name, slot.name, fitting[i % len(fitting)].name))
    return found


def with_absent(base, slot, law):
    return with_effect(base, slot, effect(law), starts=effect(law).absent)


def class_attributes(model):
    """What a model and its classes declare beside equations and what is computed from variables."""
    found = {}
    for kind in type(model).__mro__[:-1]:
        for name, value in vars(kind).items():
            is_fact = not (name.startswith("_") or callable(value) or hasattr(value, "__get__"))
            if is_fact and name not in {*OWN, "base", "placed"}:
                found.setdefault(name, getattr(model, name))
    return found


@pytest.mark.parametrize(("name", "slot", "law"), composed_models())
def test_declarations_of_the_base_are_kept(name, slot, law):
    base = load(name)
    model = with_effect(base, slot, effect(law))

    assert class_attributes(base).items() <= class_attributes(model).items()
    assert model.variables[: len(base.variables)] == base.variables
    for role in Role:
        own = [v for v in model.group(role) if v in base.variables]
        assert own == list(base.group(role))


@pytest.mark.parametrize(("name", "slot", "law"), composed_models())
def test_every_equation_of_the_base_is_kept_where_the_effect_is_absent(name, slot, law):
    base = load(name)
    model = with_absent(base, slot, law)
    plain, other = Instance(base), Instance(model)
    random_numbers = random.Random(1)
    plain.initialise()
    other.initialise()
    for v in base.group(Role.INPUT):
        plain[v.name] = other[v.name] = 1e-3 * random_numbers.uniform(-1.0, 1.0)
    step = 2.0 * (plain[base.sample_time] if base.sample_time else 1e-3)
    for k in range(3):
        plain.step(k * step, step)
        other.step(k * step, step)

    names = [v.name for v in base.all_variables]
    assert [other[n] for n in names] == [plain[n] for n in names]
    own, same = (list(i.model.faults(6e-3, *records(i), PYTHON)) for i in (plain, other))
    assert own == same
    assert len(same) == len(model.fault_texts)


def records(instance):
    model = instance.model
    return (
        model.states.record(instance.values[instance._x]),
        model.inputs.record(instance.values[instance._u]),
        model.parameters.record(instance.values[instance._p]),
    )


@pytest.mark.parametrize("law", [None, "coulomb", "learned_position_velocity"])
def test_a_command_past_a_stop_is_refused_with_and_without_an_effect(law):
    model = load("motion_simulator" if law is None else f"motion_simulator__leg_force_1_{law}")
    instance = Instance(model)
    instance["s_cmd"] = 2.0
    instance.initialise()

    with pytest.raises(ModelError, match=PAST_A_STOP):
        instance.step(0.0, 5e-3)


def test_a_fault_sees_the_input_that_the_equations_see():
    class Fuse(Model):
        name = "fuse"
        description = "Blows at 1 A"
        variables = load("spacecraft").variables
        fault_texts = (Fault("f", "too large", "at most 1"),)
        sample_time = "sample_time"

        def update(self, t, x, u, p, m, slot=no_effect):
            return {"s_des": u.f}

        def faults(self, t, x, u, p, m):
            return [u.f > 1.0]

    instance = Instance(with_effect(Fuse(), "f", effect("gain_error"), starts={"error": 1.0}))
    instance["f"] = 0.6

    with pytest.raises(ModelError, match="f: too large"):
        instance.initialise()


def test_the_start_follows_from_the_inputs_that_the_equations_see():
    """At rest on a signal of 3 N, a sensor that reads 2 N too much and then 10 % too much shows 5.5 N."""
    model = with_effect(load("force_sensor"), "f_act", effect("offset"), starts={"offset": 2.0})
    model = with_effect(model, "f_act", effect("extra_lag"), starts={"time_constant": 0.05})
    model = with_effect(model, "f_act", effect("gain_error"), starts={"error": 0.1})
    instance = Instance(model)
    instance["sigma"], instance["f_act"] = 0.0, 3.0
    instance.initialise()
    at_start = instance["f_mea"]
    instance.step(0.0, 1e-3)

    assert [at_start, instance["f_mea"]] == pytest.approx([5.5, 5.5], rel=1e-12)


def test_what_a_base_declares_beside_the_fields_of_a_model_is_kept():
    class Own(type(load("spacecraft"))):
        terminals = (Terminal("plug", "force", "A plug", {"force": "f"}),)
        something_new = ("kept",)

    model = with_effect(with_effect(Own(), "f", effect("offset")), "f", effect("gain_error"))

    assert model.something_new == ("kept",)
    assert model.terminals == Own.terminals
    assert isinstance(model, Own)


def test_the_compensator_keeps_its_three_plugs():
    model = load("compensator__command_extra_lag")
    written = terminal_files(model)["terminalsAndIcons/terminalsAndIcons.xml"]

    assert [t.name for t in model.terminals] == ["spacecraft", "motion_simulator", "docking"]
    assert written == terminal_files(load("compensator"))["terminalsAndIcons/terminalsAndIcons.xml"]


def test_the_documentation_shows_the_equations_of_base_and_effects():
    page = documentation_files(load("docking_contact__rope_force_slack"))["documentation/index.html"].decode()

    assert "m_e x_e&#x27;&#x27; = -k_m x_e - c_m x_e&#x27;" in page
    assert "F = value (1 - tanh((side r - r_0) / w)) / 2" in page


def test_an_input_that_no_equation_reads_is_no_slot():
    names = [slot.name for slot in all_slots(load("compensator"))]

    assert {"s_des", "f_mea"} <= set(names)
    assert not {"v_des", "a_des"} & set(names)
    for method, name in (("compensator", "v_des"), ("force_lead", "s_act")):
        with pytest.raises(ValueError, match=f"no such slot, got '{name}'"):
            with_effect(load(method), name, effect("offset"))
