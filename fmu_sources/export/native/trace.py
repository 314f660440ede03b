"""A model's equations as CasADi functions of (t, x, u, p), flat and dense."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

from ...framework.model import Model
from .casadi_arithmetic import CASADI, as_written

ARGUMENTS = ("t", "x", "u", "p")


def trace(model: Model) -> dict[str, Any]:
    """
    Trace the equations of a model.

    Returns:
        Functions `initial` and `update` (new states), `derivatives` (of continuous states), `outputs`,
        `faults` and `outputs_along` (derivative of the outputs along p, u, x as one more argument `seed`).
    """
    counts = {"t": 1, "x": len(model.states), "u": len(model.inputs), "p": len(model.parameters)}
    with as_written():
        t, x, u, p = symbols = [ca.SX.sym(name, count) for name, count in counts.items()]
        xs, us, ps = _scalars(x), _scalars(u), _scalars(p)
        states, inputs, params = (
            model.states.record(xs),
            model.inputs.record(us),
            model.parameters.record(ps),
        )
        signals = (t, states, inputs, params, CASADI)
        results = {
            "initial": model.states.merged(model.initial(*signals[1:]), xs),
            "update": model.states.merged(model.update(*signals), xs),
            "derivatives": model.continuous.flat(model.derivatives(*signals)),
            "outputs": model.results.flat(model.outputs(*signals)),
            "faults": list(model.faults(*signals)),
        }
        functions = {name: ca.Function(name, symbols, [_column(y)]) for name, y in results.items()}
    functions["outputs_along"] = _outputs_along(symbols, _column(results["outputs"]))
    return functions


def _scalars(column: Any) -> list[Any]:
    return [column[i] for i in range(column.numel())]


def _column(values: Sequence[Any]) -> Any:
    return ca.densify(ca.vertcat(*values)) if values else ca.SX(0, 1)


def _outputs_along(symbols: Sequence[Any], y: Any) -> Any:
    _, x, u, p = symbols
    knowns = ca.vertcat(p, u, x)
    seed = ca.SX.sym("seed", knowns.numel())
    along = ca.jtimes(y, knowns, seed) if y.numel() and knowns.numel() else ca.SX(y.numel(), 1)
    return ca.Function("outputs_along", [*symbols, seed], [ca.densify(along)])
