from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.framework.integrate import runge_kutta_4


class NumpyArithmetic:
    """The mathematics namespace on arrays: one equation for many times or many windows at once."""

    pi = np.pi
    sqrt, exp, log, sin, cos, tan, tanh = np.sqrt, np.exp, np.log, np.sin, np.cos, np.tan, np.tanh
    floor, fabs, where, both = np.floor, np.fabs, np.where, np.logical_and


@pytest.fixture(scope="session")
def arrays():
    return NumpyArithmetic


@pytest.fixture(scope="session")
def outputs_of():
    """Evaluate the outputs of a model without states on whole recordings."""

    def evaluate(model, parameters, **inputs):
        p = model.parameters.record([float(parameters.get(v, s)) for v, s in _starts(model)])
        n = len(next(iter(inputs.values())))
        u = model.inputs.record([inputs.get(name, np.zeros(n)) for name in model.inputs.names])
        x = model.states.record([])
        return SimpleNamespace(**model.outputs(0.0, x, u, p, NumpyArithmetic))

    return evaluate


@pytest.fixture(scope="session")
def states_of():
    """Integrate a model over windows side by side: input of shape (n steps, 3, windows) -> states."""

    def integrate(model, parameters, u, h):
        p = model.parameters.record([float(parameters.get(v, s)) for v, s in _starts(model)])
        x = [np.zeros(u.shape[2]) for _ in model.continuous.names]
        rows = []
        for row in u:

            def f(place, x, row=row):
                record = model.inputs.record([row[round(2 * place)]])
                der = model.derivatives(0.0, model.states.record(x), record, p, NumpyArithmetic)
                return [h * d for d in model.continuous.flat(der)]

            rows.append(x[0])
            x = runge_kutta_4(f, 1, x)
        return np.array(rows)

    return integrate


def _starts(model):
    return [(v.name, v.start) for v in model.all_variables[: len(model.parameters)]]
