"""Each method of others against exact solutions, and plants and filters of SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

from fmu_sources.composed.registry import load
from fmu_sources.framework.instance import Instance

T = 1e-3
W = 2.0 * math.pi
M_S = 1000.0


def driven(name, s_des, s_act=None, f_mea=None, x=None, **values):
    """Return f_comp and s_cmd at each instant, and the instance in the end."""
    zeros = np.zeros(len(s_des))
    s_act, f_mea, x = (zeros if one is None else one for one in (s_act, f_mea, x))
    instance = Instance(load(name))
    for key, value in values.items():
        instance[key] = value
    said = []
    for k, inputs in enumerate(zip(s_des, s_act, f_mea, x, strict=True)):
        for key, value in zip(("s_des", "s_act", "f_mea", "x"), inputs, strict=True):
            instance[key] = value
        if k == 0:
            instance.initialise()
        instance.step(k * T, T)
        said.append((instance["f_comp"], instance["s_cmd"]))
    force, command = np.array(said).T
    return force, command, instance


def tracked(name, slower=1.0, n=3000, **values):
    """Let a plant of SciPy follow s = cos(W t) under f = -m_s w^2 s; return s_act - s."""
    K_p, w_v, z = 30.0 / slower, 40.0 * math.pi / slower, 0.8
    space = signal.tf2ss([K_p * w_v**2], [1.0, 2.0 * z * w_v, w_v**2, K_p * w_v**2])
    A, B, C = signal.cont2discrete(space, T, "zoh")[:3]
    state = np.linalg.solve(np.eye(3) - A, B[:, 0])
    line, error = [1.0] * 2, []
    instance = Instance(load(name))
    for key, value in {"m_s": M_S, "T_f_hat": 0.0, **values}.items():
        instance[key] = value
    for k in range(n):
        s, s_act = math.cos(W * k * T), float(C[0] @ state)
        instance["s_des"], instance["s_act"], instance["f_mea"] = s, s_act, -M_S * W * W * s
        if k == 0:
            instance.initialise()
        error.append(s_act - s)
        instance.step(k * T, T)
        line.append(instance["s_cmd"])
        state = A @ state + B[:, 0] * line.pop(0)
    return np.array(error)


def test_the_first_order_inverse_undoes_its_recursion_exactly():
    lag, reached = 0.0355, 1.0
    s = np.cos(0.01 * np.arange(300))
    _, command, _ = driven("cr_inverse", s, lag=lag)
    alpha = 1.0 + lag / T
    for k in range(300):
        reached += (command[k] - reached) / alpha
        assert reached == pytest.approx(s[k], abs=1e-12)


def test_the_polynomial_of_horiuchi_is_exact_on_a_cubic():
    t = np.arange(250) * T
    s = 1.0 - 2.0 * t + 3.0 * t**2 + 4.0 * t**3
    _, command, _ = driven("horiuchi", s, lag=0.0352)
    ahead = t + 0.035

    expected = 1.0 - 2.0 * ahead + 3.0 * ahead**2 + 4.0 * ahead**3
    assert command[106:] == pytest.approx(expected[106:], rel=1e-9)


def test_the_third_order_inverse_leads_by_its_taylor_series():
    """At 1 Hz what is left is of fourth order in w lag: (w 0.0355)^4 = 2.5e-3 at most."""
    assert np.abs(tracked("inverse3"))[1000:].max() < (W * 0.0355) ** 4


@pytest.mark.parametrize("name", ["amb", "ats"])
@pytest.mark.parametrize("slower", [0.9, 1.1])
def test_adaptation_takes_out_most_of_a_plant_that_is_not_as_believed(name, slower):
    fixed = np.abs(tracked("inverse3", slower))[2000:].max()
    values = {"rate": 5.0} if name == "amb" else {}

    assert np.abs(tracked(name, slower, **values))[2000:].max() < 0.4 * fixed


def test_a_predictor_with_the_right_models_gives_the_force_of_the_desired_motion():
    """Plant and contact by SciPy: zero-order hold of the command, bilinear contact on the samples."""
    contact = {"m_e": 60.0, "k_m": 8e5, "c_m": 800.0, "k_p": 4e5, "c_p": 400.0}
    numerator = np.polymul([800.0, 8e5], [400.0, 4e5])
    b, a = signal.bilinear(numerator, [60.0, 1200.0, 1.2e6], 1.0 / T)
    space = signal.tf2ss(
        [30.0 * (40 * math.pi) ** 2], [1.0, 64 * math.pi, (40 * math.pi) ** 2, 30 * (40 * math.pi) ** 2]
    )
    A, B, C = signal.cont2discrete(space, T, "zoh")[:3]
    s_des = 0.01 * np.sin(15.0 * np.arange(600) * T)
    reached = signal.dlsim((A, B, C, np.zeros((1, 1)), T), np.concatenate([[0.0, 0.0], s_des]))[1][:600, 0]
    f_mea = -signal.lfilter(b, a, reached)
    force, command, _ = driven("smith", s_des, f_mea=f_mea, T_f_hat=0.0, inverse=0, **contact)

    assert command == pytest.approx(s_des, abs=0.0)
    assert force == pytest.approx(-signal.lfilter(b, a, s_des), abs=1e-4 * 2667.0)


def test_stiffness_and_damping_are_identified_and_fill_in_what_is_missing():
    """Contact k = 36000 N/m, c = 300 N s/m where 30255 and 70 are believed; x moves the rope's end."""
    k, c, t = 36_000.0, 300.0, np.arange(3000) * T
    s_des, s_act, x = (0.01 * np.sin(W * (t - late)) for late in (0.0, 0.03, 0.5))
    rate = 0.01 * W * (np.cos(W * (t - 0.03)) - np.cos(W * (t - 0.5)))
    f_mea = -k * (s_act - x) - c * rate
    force, _, _ = driven("qi", s_des, s_act, f_mea, x, T_f_hat=0.0)

    wanted = -k * (s_des - x) - c * 0.01 * W * (np.cos(W * t) - np.cos(W * (t - 0.5)))
    assert np.abs(force - wanted)[2000:].max() < 0.005 * k * 0.01


def test_passivity_takes_out_the_energy_that_a_step_generates():
    """By 2 N, v_des = 0.5, v_act = 0.1 m/s: E = T 2 0.4, beta = E/(T v^2) = 3.2, f_comp = 2 - 3.2 0.5."""
    s_des, s_act, f = np.array([0.0, 5e-4]), np.array([0.0, 1e-4]), np.array([2.0, 2.0])
    force, _, instance = driven("tdpa", s_des, s_act, f, T_f_hat=0.0)

    assert force[1] == pytest.approx(0.4, rel=1e-9)
    assert instance["energy"] == pytest.approx(0.0, abs=1e-12)


def test_passivity_leaves_a_loop_that_loses_energy_alone():
    s_des, s_act, f = np.array([0.0, 1e-4]), np.array([0.0, 5e-4]), np.array([2.0, 2.0])
    force, _, instance = driven("tdpa", s_des, s_act, f, T_f_hat=0.0)

    assert force[1] == 2.0
    assert instance["energy"] == 0.0


def test_the_damper_of_the_passivity_controller_is_bounded():
    """Energy T 1000 0.4 = 0.4 J, wanted 1600 N s/m at 0.5 m/s; 1000 are allowed, T 1000 0.25 = 0.25 J go."""
    s_des, s_act, f = np.array([0.0, 5e-4]), np.array([0.0, 1e-4]), np.array([1000.0, 1000.0])
    force, _, instance = driven("tdpa", s_des, s_act, f, T_f_hat=0.0, largest_damping=1000.0)

    assert force[1] == pytest.approx(500.0, rel=1e-9)
    assert instance["energy"] == pytest.approx(0.15, rel=1e-9)
