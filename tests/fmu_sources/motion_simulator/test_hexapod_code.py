"""The equations as CasADi symbols: what the native flavour is generated from."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.motion_simulator.motion_simulator import MODEL
from tests.fmu_sources.motion_simulator.hexapod import N, at_rest

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("casadi") is None,
    reason="CasADi is not installed: the equations cannot be traced (extra `native`)",
)


@pytest.fixture(scope="module")
def functions():
    from fmu_sources.export.native.trace import trace

    return trace(MODEL)


def moving():
    """States in motion away from the neutral pose, inputs and parameters."""
    instance = at_rest((0.05, -0.08, 0.11, 0.1, -0.15, 0.2))
    for i, name in enumerate(MODEL.states.names[6:N]):
        instance[name] += 0.01 * (i - 8)
    instance["f_contact"], instance["wrench[4]"] = 100.0, 30.0
    return (
        [instance[name] for name in kind.names] for kind in (MODEL.states, MODEL.inputs, MODEL.parameters)
    )


def test_a_derivative_costs_few_operations(functions):
    function = functions["derivatives"]
    loads_and_stores = 2 * MODEL.n_continuous + len(MODEL.inputs) + len(MODEL.parameters)
    # for each of four limits six times two comparisons and their junction, five more junctions, one choice
    time_past_limits = 4 * (6 * 3 + 5 + 4)

    # 1777 without limits; these add five choices a leg
    assert function.n_instructions() - loads_and_stores < 2100 + time_past_limits


@pytest.mark.parametrize("name", ["initial", "derivatives", "outputs", "update", "faults"])
def test_symbols_give_what_numbers_give(functions, name):
    x, u, p = moving()
    records = (MODEL.states.record(x), MODEL.inputs.record(u), MODEL.parameters.record(p))
    results = {
        "initial": lambda: MODEL.states.merged(MODEL.initial(*records, PYTHON), x),
        "update": lambda: MODEL.states.merged(MODEL.update(0.0, *records, PYTHON), x),
        "derivatives": lambda: MODEL.continuous.flat(MODEL.derivatives(0.0, *records, PYTHON)),
        "outputs": lambda: MODEL.results.flat(MODEL.outputs(0.0, *records, PYTHON)),
        "faults": lambda: MODEL.faults(0.0, *records, PYTHON),
    }

    np.testing.assert_array_equal(
        np.array(functions[name](0.0, x, u, p)).ravel(), np.array(results[name](), dtype=float)
    )
