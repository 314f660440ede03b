from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from fmu_sources.docking_contact.docking_contact import MODEL as CONTACT
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.variables import Role
from fmu_sources.real_docking.real_docking import MODEL

M_S, M_E, K_M, C_M, K_P, C_P = 820.0, 80.0, 150e3, 158.0, 37.9e3, 65.0
K, C = K_M + K_P, C_M + C_P
A = np.array(
    [
        [0, 1, 0, 0],
        [0, 0, -K_M / M_S, -C_M / M_S],
        [0, 0, 0, 1],
        [K_P / M_E, C_P / M_E, -K / M_E, -C / M_E],
    ]
)


def make(**values):
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def states(real):
    return [real[name] for name in ("s", "v_s", "x_e", "der_x_e")]


def test_ports_and_start_values():
    real = make(s=-0.01)

    assert [v.name for v in MODEL.group(Role.INPUT)] == ["v"]
    assert [v.name for v in MODEL.group(Role.STATE) if v.output] == ["s", "v_s", "x"]
    assert real["f"] == pytest.approx(0.01 * K_M * K_P / K, rel=1e-14)


def test_derivatives_by_hand():
    x = MODEL.states.record([0.02, 0.5, 0.01, 0.2, 0.003])
    u = MODEL.inputs.record([0.1])
    p = MODEL.parameters.record([4.0, 2.0, 1000.0, 10.0, 400.0, 5.0, 100.0, 1.0])
    f_r = 500.0 * (0.02 - 0.013) + 5.0 * (0.5 - 0.3)
    expected = {"s": 0.5, "v_s": -12.0 / 4.0, "x_e": 0.2, "der_x_e": (f_r - 12.0) / 2.0, "x": 0.1}

    assert MODEL.derivatives(0.25, x, u, p, PYTHON) == pytest.approx(expected)
    assert MODEL.outputs(0.25, x, u, p, PYTHON) == pytest.approx({"f": -12.0})


def test_free_motion_equals_the_matrix_exponential():
    real = make(s=-0.01, v_s=0.02)
    start = np.array(states(real))
    for k in range(1000):
        real.step(k * 1e-3, 1e-3)

    assert states(real) == pytest.approx(expm(A) @ start, rel=1e-7, abs=1e-9)


def test_frequency_and_damping_are_those_of_the_loop_not_of_eq_3():
    slow = min(np.linalg.eigvals(A), key=abs)

    assert abs(slow) / (2 * math.pi) == pytest.approx(0.9746, abs=1e-4)
    assert -slow.real / abs(slow) == pytest.approx(0.00486, abs=1e-5)


def test_without_damping_the_frequencies_solve_the_biquadratic():
    u = MODEL.inputs.record([0.0])
    p = MODEL.parameters.record([M_S, M_E, K_M, 0.0, K_P, 0.0, 0.0, 1.0])
    columns = [
        list(MODEL.derivatives(0.0, MODEL.states.record(unit), u, p, PYTHON).values())
        for unit in np.eye(5)[:4].tolist()
    ]
    w2 = np.abs(np.linalg.eigvals(np.array(columns).T[:4])) ** 2
    terms = np.array([w2**2, -K / M_E * w2, np.full(4, K_M * K_P / (M_S * M_E))])

    assert np.abs(terms.sum(axis=0)) == pytest.approx(0.0, abs=1e-9 * np.abs(terms).max())


def test_it_shares_the_equations_of_the_contact():
    real, contact = make(s=-0.01), Instance(CONTACT)
    contact["s_act"] = -0.01
    contact.initialise()
    x = MODEL.states.record([0.02, 0.5, 0.01, 0.2, 0.003])
    p = MODEL.parameters.record(real.values[: len(MODEL.parameters)])
    u = CONTACT.inputs.record([0.02, 0.5, 0.0])
    q = CONTACT.parameters.record(contact.values[: len(CONTACT.parameters)])
    ours = MODEL.derivatives(0.0, x, MODEL.inputs.record([0.0]), p, PYTHON)
    theirs = CONTACT.derivatives(0.0, CONTACT.states.record([0.01, 0.2, 0.003]), u, q, PYTHON)

    assert ours["der_x_e"] == theirs["der_x_e"]
    assert MODEL.slots == CONTACT.slots


def test_the_integration_converges_with_order_four():
    def error(step):
        real = make(s=-0.01)
        start = np.array(states(real))
        model_substep, type(MODEL).substep = MODEL.substep, step
        try:
            for k in range(5):
                real.step(k * 0.02, 0.02)
        finally:
            type(MODEL).substep = model_substep
        return abs(real["x_e"] - (expm(0.1 * A) @ start)[2])

    assert math.log2(error(2e-3) / error(1e-3)) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("m_s", -1.0, "m_s: value not allowed, got -1.0 kg, expected above 0.0"),
        ("k_m", 0.0, "k_m: value not allowed, got 0.0 N/m, expected above 0.0"),
        ("v", math.nan, "v: value not allowed, got nan m/s, expected a finite number"),
    ],
)
def test_a_bad_value_is_refused(name, value, message):
    with pytest.raises(ModelError) as error:
        make(**{name: value})

    assert str(error.value) == message
