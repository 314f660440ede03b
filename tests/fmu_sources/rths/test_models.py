"""The benchmark's models against exact solutions of its published matrices."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm, sqrtm

from fmu_sources.composed.registry import load
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.variables import Role
from fmu_sources.rths.rths_ground import PEAK
from fmu_sources.rths.structure import ROOT_OF_STIFFNESS, STIFFNESS

H = 1.0 / 4096.0
K = np.array(STIFFNESS)
CASES = [(1000.0, 0.05), (1100.0, 0.04), (1300.0, 0.03), (1000.0, 0.03)]
M_E, K_E, ZETA_E = 29.13, 1190e3, 0.0097
C_E = 2.0 * ZETA_E * M_E * math.sqrt(K_E / M_E)


def made(name, **values):
    instance = Instance(load(name))
    for key, value in values.items():
        instance[key] = value
    instance.initialise()
    return instance


def modal_damping(mass, zeta):
    """C = P^-T diag(2 zeta w) P^-1 with the mass-normalised modes P."""
    w2, modes = np.linalg.eigh(K / mass)
    inverse = np.linalg.inv(modes / math.sqrt(mass))
    return inverse.T @ np.diag(2.0 * zeta * np.sqrt(w2)) @ inverse


def first_order_hold(A, B):
    """Exact step of x' = A x + B u for u on a straight line: x, u before, u after."""
    n, m = B.shape
    E = expm(np.block([[A * H, B * H, np.zeros((n, m))], [np.zeros((2 * m, n + m)), np.eye(2 * m, m)]]))
    return E[:n, :n], E[:n, n : n + m] - E[:n, n + m :], E[:n, n + m :]


def frame(mass, damping, stiffness):
    n = len(mass)
    inverse = np.linalg.inv(mass)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])


def test_the_frequencies_of_the_first_case_are_the_published_ones():
    assert np.sqrt(np.linalg.eigvalsh(K / 1000.0)) / (2.0 * math.pi) == pytest.approx(
        [3.61, 16.00, 38.09], abs=0.005
    )


def test_the_root_of_the_stiffness_is_that_of_scipy():
    assert pytest.approx(sqrtm(K).real, rel=1e-11) == np.array(ROOT_OF_STIFFNESS)


@pytest.mark.parametrize(("mass", "zeta"), CASES)
def test_the_undivided_building_follows_its_exact_solution(mass, zeta):
    a_g = np.sin(0.02 * np.arange(200)) + 0.3 * np.cos(0.11 * np.arange(200)) - 0.3
    A = frame(mass * np.eye(3), modal_damping(mass, zeta), K)
    F, before, after = first_order_hold(A, np.r_[np.zeros(3), -np.ones(3)][:, None])
    x, reference = np.zeros(6), made("rths_reference", floor_mass=mass, zeta=zeta)
    rows, exact = [], []
    for k in range(199):
        x = F @ x + before[:, 0] * a_g[k] + after[:, 0] * a_g[k + 1]
        reference["a_g"] = a_g[k + 1]
        reference.step(k * H, H)
        rows.append([reference[name] for name in ("x1", "x2", "x3", "v1")])
        exact.append(x[:4])

    assert np.abs(np.array(rows) - exact).max(axis=0) / np.abs(exact).max(axis=0) == pytest.approx(
        np.zeros(4), abs=2e-8
    )


def test_the_building_without_specimen_holds_the_force_and_follows_its_exact_solution():
    mass, zeta = CASES[2]
    M, C, stiffness = mass * np.eye(3), modal_damping(mass, zeta), K.copy()
    M[0, 0] -= M_E
    C[0, 0] -= C_E
    stiffness[0, 0] -= K_E
    A, inverse = frame(M, C, stiffness), np.linalg.inv(M)
    ground = np.r_[np.zeros(3), -inverse @ np.full(3, mass)][:, None]
    force = np.r_[np.zeros(3), inverse[:, 0]][:, None]
    F, before, after = first_order_hold(A, ground)
    _, held, held_too = first_order_hold(A, force)
    a_g, f_e = np.sin(0.02 * np.arange(200)), 500.0 * np.sign(np.sin(0.3 * np.arange(200)))
    x, building = np.zeros(6), made("rths_building", floor_mass=mass, zeta=zeta)
    rows, exact = [], []
    for k in range(199):
        x = F @ x + before[:, 0] * a_g[k] + after[:, 0] * a_g[k + 1] + (held + held_too)[:, 0] * f_e[k]
        building["a_g"], building["f_e"] = a_g[k + 1], f_e[k]
        building.step(k * H, H)
        rate = A @ x + ground[:, 0] * a_g[k + 1] + force[:, 0] * f_e[k]
        rows.append([building[name] for name in ("x1", "x2", "x3", "v1", "a1")])
        exact.append([*x[:4], rate[3]])

    assert np.abs(np.array(rows) - exact).max(axis=0) / np.abs(exact).max(axis=0) == pytest.approx(
        np.zeros(5), abs=2e-8
    )


def test_building_and_specimen_in_one_are_the_undivided_building():
    """The eigenvalues of both parts, joined by f_e = -(m_e a + c_e v + k_e x), are those of the whole."""
    building = load("rths_building")
    p = SimpleNamespace(**{v.name: v.start for v in building.group(Role.PARAMETER)})
    names = ("x1", "x2", "x3", "v1", "v2", "v3")

    def accelerations(motion):
        x = SimpleNamespace(**dict(zip(names, motion, strict=True)), f_held=0.0)
        without = building.derivatives(0.0, x, SimpleNamespace(a_g=0.0), p, PYTHON)
        joined = (without["v1"] * (1000.0 - M_E) - C_E * x.v1 - K_E * x.x1) / 1000.0
        return [joined, without["v2"], without["v3"]]

    lower = np.array([accelerations(row) for row in np.eye(6)]).T
    joined = np.vstack([np.eye(6)[3:], lower])
    whole = frame(1000.0 * np.eye(3), modal_damping(1000.0, 0.05), K)

    assert np.sort_complex(np.linalg.eigvals(joined)) == pytest.approx(
        np.sort_complex(np.linalg.eigvals(whole)), rel=1e-9
    )


def actuator_matrices(k_e=K_E, b_1=425.0, b_2=9.9976e4, a_3=3.3):
    c_e = 2.0 * ZETA_E * M_E * math.sqrt(k_e / M_E)
    A = np.zeros((5, 5))
    A[0, 1] = A[2, 0] = A[3, 4] = 1.0
    A[1] = [-b_2, -b_1, 0.0, -2.1283e13, 0.0]
    A[2, 2:] = [-a_3, 0.0, -4.2297e6]
    A[4, 2:] = [1.0 / M_E, -k_e / M_E, -c_e / M_E]
    return A, np.array([0.0, 2.1283e13 * 1.0261, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("plant", [{}, {"k_e": 1.29e6, "b_1": 418.0, "b_2": 1.05e5, "a_3": 0.7}])
def test_the_actuator_is_its_exact_zero_order_hold_and_its_force_the_difference_quotient(plant):
    A, B = actuator_matrices(**plant)
    k_e = plant.get("k_e", K_E)
    c_e = 2.0 * ZETA_E * M_E * math.sqrt(k_e / M_E)
    E = expm(np.block([[A, B[:, None]], [np.zeros((1, 6))]]) * H)
    x, actuator = np.zeros(5), made("rths_actuator", **plant)
    commands = 1e-3 * np.sin(0.05 * np.arange(1, 300))
    rows, exact, path = [], [], [0.0, 0.0]
    for k, command in enumerate(commands):
        x = E[:5, :5] @ x + E[:5, 5] * command
        path.append(x[3])
        v, v_1 = (path[-1] - path[-2]) / H, (path[-2] - path[-3]) / H
        exact.append([x[3], x[4], k_e * x[3] + c_e * v + M_E * (v - v_1) / H])
        actuator["s_cmd"] = command
        actuator.step(k * H, H)
        rows.append([actuator[name] for name in ("x", "v", "force")])

    assert np.abs(np.array(rows) - exact).max(axis=0) / np.abs(exact).max(axis=0) == pytest.approx(
        np.zeros(3), abs=1e-6
    )


def test_the_poles_of_the_actuator_are_those_of_its_head_and_it_rests_at_its_published_gain():
    A, B = actuator_matrices()
    poles = sorted((p for p in np.linalg.eigvals(A) if p.imag >= 0.0), key=abs)

    assert poles[0] == pytest.approx(-48.2, abs=0.05)
    assert np.abs(poles[1:]) / (2.0 * math.pi) == pytest.approx([46.9, 67.1], abs=0.05)
    assert -np.real(poles[1:]) / np.abs(poles[1:]) == pytest.approx([0.62, 0.019], abs=0.005)
    assert -np.linalg.solve(A, B)[3] == pytest.approx(1.0075, abs=5e-5)


def readings(sensor, x, force, n):
    rows = []
    for k in range(n):
        sensor["x"], sensor["force"] = x, force
        sensor.step(k * H, H)
        rows.append((sensor["x_mea"], sensor["f_mea"]))
    return np.array(rows).T


def test_the_noise_of_the_sensors_has_the_published_power_and_is_independent():
    x, f = readings(made("rths_sensor", quantum_x=0.0), 1e-3, 1000.0, 6000)

    assert np.std(x) == pytest.approx(math.sqrt(6.25e-14 * 4096.0), rel=0.03)
    assert np.std(f) == pytest.approx(math.sqrt(1.16e-3 * 4096.0), rel=0.03)
    assert np.mean(f) == pytest.approx(-1000.0, abs=0.15)
    assert abs(np.corrcoef(x, f)[0, 1]) < 0.04


def test_readings_are_rounded_to_the_quantum_and_stay_within_the_limit():
    sensor = made("rths_sensor", sigma_x=0.0, sigma_f=0.0, quantum_x=0.25, limit_x=1.0, limit_f=50.0)

    assert readings(sensor, 0.6, -80.0, 1)[:, 0] == pytest.approx([0.5, 50.0])
    assert readings(sensor, -7.0, 80.0, 1)[:, 0] == pytest.approx([-1.0, -50.0])
    assert readings(sensor, 0.63, 20.0, 1)[:, 0] == pytest.approx([0.75, -20.0])


def test_a_seed_whose_second_noise_would_leave_the_range_is_refused():
    with pytest.raises(ModelError, match="seed"):
        made("rths_sensor", seed=2**31 - 1)


def test_the_closed_form_is_what_its_formula_says_and_its_largest_value_the_amplitude():
    t = np.arange(1, 122_881) * H
    A = np.zeros_like(t)
    for i in range(25):
        f = 0.4 + 0.37 * i
        A += np.sin(2.0 * math.pi * f * t + i**2) / (1.0 + ((f - 2.5) / 2.0) ** 2)
    A *= np.where(t < 4.0, (t / 4.0) ** 2, np.where(t < 15.0, 1.0, np.exp(-0.3 * (t - 15.0))))
    ground = made("rths_ground")
    said = []
    for k in (0, 1, 8191, 16383, 17736, 61439, 61440, 122_000):
        ground.step(k * H, H)
        said.append(ground["a_g"])

    assert np.abs(A).max() == pytest.approx(PEAK, rel=1e-12)
    assert said == pytest.approx(1.25 / PEAK * A[[0, 1, 8191, 16383, 17736, 61439, 61440, 122_000]], rel=1e-9)


def test_the_sample_controller_is_its_two_filters_after_tustin():
    from scipy import signal

    lead = signal.cont2discrete(([50.8316, 8570.397], [1.0, 8570.397]), H, "bilinear")
    pi = signal.cont2discrete(([2.0, 95.0], [1.0, 0.0]), H, "bilinear")
    target, reached = 1e-3 * np.sin(0.01 * np.arange(400)), 9e-4 * np.sin(0.01 * np.arange(400) - 0.2)
    reached = reached - reached[0]
    y = signal.lfilter(lead[0][0], lead[1], target)
    exact = signal.lfilter(pi[0][0], pi[1], y - reached)
    controller = made("rths_sample")
    said = []
    for k in range(400):
        controller["s_des"], controller["s_act"], controller["f_mea"] = target[k], reached[k], float(k)
        controller.step(k * H, H)
        said.append(controller["s_cmd"])

    assert said == pytest.approx(exact, rel=1e-9, abs=1e-15)
    assert controller["f_comp"] == 399.0
