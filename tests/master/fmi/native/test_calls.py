import ctypes

import numpy as np
import pytest
from numba import njit

from master.fmi.native import calls
from master.fmi.native.jit import tell_numba
from tests.stubs import EXCHANGE, STEP

tell_numba()
COMPONENT, ANSWER = 4711, 2


@njit
def exchange_compiled(address, component, references, n, values):
    return calls.exchange(address, component, references, n, values)


@njit
def exchange_3_compiled(address, component, references, n, values, n_values):
    return calls.exchange_3(address, component, references, n, values, n_values)


@njit
def do_step_compiled(address, component, t, h):
    return calls.do_step(address, component, t, h)


@njit
def do_step_3_compiled(address, component, t, h, answers):
    return calls.do_step_3(address, component, t, h, answers)


def address_of(function):
    return ctypes.cast(function, ctypes.c_void_p).value


@pytest.mark.parametrize(
    ("version", "call", "n_values"),
    [
        (2, calls.exchange, ()),
        (2, exchange_compiled, ()),
        (3, calls.exchange_3, (6,)),
        (3, exchange_3_compiled, (6,)),
    ],
)
def test_a_setter_gets_component_references_and_values(version, call, n_values):
    seen = []

    def setter(component, references, n, values, *n_values):
        given = (ctypes.c_double * n).from_address(values)
        seen.append((component, [references[i] for i in range(n)], list(given), n_values))
        return ANSWER

    function = EXCHANGE[version](setter)
    references, values = np.array([7, 9], dtype=np.uint32), np.array([0.5, -1.0])
    data = (references.ctypes.data, 2, values.ctypes.data)

    assert call(address_of(function), COMPONENT, *data, *n_values) == ANSWER
    assert seen == [(COMPONENT, [7, 9], [0.5, -1.0], n_values)]


@pytest.mark.parametrize("call", [calls.do_step, do_step_compiled])
def test_a_step_of_fmi_2_gets_time_and_size_and_keeps_no_old_state(call):
    seen = []
    function = STEP[2](lambda *a: seen.append(a) or ANSWER)

    assert call(address_of(function), COMPONENT, 0.25, 0.125) == ANSWER
    assert seen == [(COMPONENT, 0.25, 0.125, 1)]


@pytest.mark.parametrize("call", [calls.do_step_3, do_step_3_compiled])
def test_a_step_of_fmi_3_gets_four_cells_for_its_answers(call):
    seen = []
    function = STEP[3](lambda *a: seen.append(a) or ANSWER)
    cells = np.zeros(4)
    places = tuple(cells.ctypes.data + 8 * i for i in range(4))

    assert call(address_of(function), COMPONENT, 0.25, 0.125, cells.ctypes.data) == ANSWER
    assert seen == [(COMPONENT, 0.25, 0.125, True, *places)]
