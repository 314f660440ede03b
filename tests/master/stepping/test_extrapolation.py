"""
Coupling error of two masses against their monolithic solution, by the order in which it falls with h.

    m1 x1'' = -k1 x1 - f        f = k (x1 - x2) + c (x1' - x2')        m2 x2'' = -k2 x2 + f

Each mass is solved exactly for an input that is linear in a step, so that all error is that of coupling.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from tests.linear_blocks import Linear
from tests.stubs import bench, wire

STIFF, SOFT, DAMP = 40.0, 25.0, 0.8
END = 1.0
STEPS = (0.005, 0.0025)
WHOLE = np.array(
    [
        [0.0, 1.0, 0.0, 0.0],
        [-STIFF - SOFT, -DAMP, SOFT, DAMP],
        [0.0, 0.0, 0.0, 1.0],
        [SOFT, DAMP, -STIFF - SOFT, -DAMP],
    ]
)


def pair(order, step, extrapolation):
    first = Linear([[0, 1], [-STIFF, 0]], [[0], [-1]], ("x", "v"), ("f_in",))
    own, force = [[0, 1], [-STIFF - SOFT, -DAMP]], {"f": ([-SOFT, -DAMP], [SOFT, DAMP])}
    second = Linear(own, [[0, 0], [SOFT, DAMP]], ("x", "v"), ("x_in", "v_in"), force)
    more = {"extrapolation": extrapolation}
    wires = [wire("b.f", "a.f_in", **more), wire("a.x", "b.x_in", **more), wire("a.v", "b.v_in", **more)]
    if order != [["a", "b"]]:
        wires[1:] = [wire("a.x", "b.x_in"), wire("a.v", "b.v_in")]
    blocks = {"a": first.block(), "b": second.block()}
    return bench(blocks, wires, order, step_size=step, start={"a": {"x": 1.0}})


def error(order, step, extrapolation):
    n = round(END / step)
    result = pair(order, step, extrapolation).run(n).result
    tick = expm(WHOLE * step)
    state = [np.array([1.0, 0.0, 0.0, 0.0])]
    for _ in range(n):
        state.append(tick @ state[-1])
    exact = np.array(state)[:, [0, 2]]
    return np.abs(np.column_stack([result["a.x"], result["b.x"]]) - exact).max()


def observed_order(order, extrapolation):
    errors = [error(order, step, extrapolation) for step in STEPS]
    return np.log2(errors[0] / errors[1])


SIDE_BY_SIDE, SEQUENCE = [["a", "b"]], ["a", "b"]
ITERATED = [{"iterate": ["a", "b"], "tolerance": 1e-13, "maximum": 100}]


@pytest.mark.parametrize("order", [SIDE_BY_SIDE, SEQUENCE], ids=["side by side", "sequence"])
@pytest.mark.parametrize(("extrapolation", "expected"), [(0, 1), (1, 2), (2, 2)])
def test_the_coupling_error_falls_with_the_stated_order(order, extrapolation, expected):
    assert observed_order(order, extrapolation) == pytest.approx(expected, abs=0.15)


def test_the_coupling_error_of_an_iterated_group_falls_with_the_square_of_the_step():
    assert observed_order(ITERATED, 0) == pytest.approx(2.0, abs=0.15)


def test_each_scheme_is_better_than_the_one_before_it():
    step = STEPS[-1]
    schemes = [(SIDE_BY_SIDE, 0), (SEQUENCE, 0), (SEQUENCE, 1), (ITERATED, 0)]
    errors = [error(order, step, extrapolation) for order, extrapolation in schemes]

    assert errors == sorted(errors, reverse=True)
