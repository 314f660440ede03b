from __future__ import annotations

import pytest

from fmu_sources.composed.registry import load
from fmu_sources.export.dependencies import Label, LabelArithmetic
from fmu_sources.framework.variables import Role

NAMES = (
    "spacecraft",
    "motion_simulator_linear",
    "docking_contact",
    "force_sensor",
    "compensator",
    "real_docking",
)


def labels(kind):
    return kind.record([Label(frozenset({name})) for name in kind.names])


@pytest.mark.parametrize("name", NAMES)
def test_no_equation_branches_on_a_signal_or_a_parameter(name):
    """A label refuses to be a truth value, as a symbol of the code generator does."""
    model, m = load(name), LabelArithmetic()
    x, u, p = labels(model.states), labels(model.inputs), labels(model.parameters)
    t = Label(frozenset({"time"}))

    assert model.states.merged(model.initial(x, u, p, m), [None] * len(model.states))
    if model.n_continuous:
        assert model.continuous.flat(model.derivatives(t, x, u, p, m))
    assert set(model.update(t, x, u, p, m)) <= set(model.states.fields)
    assert set(model.outputs(t, x, u, p, m)) == {v.base for v in model.group(Role.OUTPUT)}


@pytest.mark.parametrize("name", NAMES)
def test_delays_name_inputs_choices_and_parameters_that_exist(name):
    model = load(name)
    for delay in model.delays:
        assert delay.input in model.inputs.names
        if delay.by is not None:
            (chosen,) = [v for v in model.variables if v.name == delay.by]
            assert set(delay.steps) == {item.name for item in chosen.items}
        if isinstance(delay.seconds, str):
            assert delay.seconds in model.parameters.names
